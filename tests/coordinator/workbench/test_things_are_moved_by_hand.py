"""By hand in the browser: what is dragged or nudged writes its place, snaps, and can be undone."""

from __future__ import annotations

from typing import Any

import pytest
from heavylift.nodes.scene.text import read
from planner import Hands


def place(text: str, *path: str | int) -> list[float]:
    """The lengths [m] at a path of a scene's text."""
    found: Any = read(text, "x").data
    for key in path:
        found = found[key]
    return [float(x.removesuffix(" m")) for x in (found if isinstance(found, list) else [found])]


@pytest.fixture
def mover(page: Any, hands: Hands) -> Hands:
    """A planner who has an obstacle in the scene, looks at it from above, and moves things."""
    hands.file.write_text(
        hands.text.replace("\nrig:", "\nobstacles:\n  wall: {box: [6 m, 6 m, 3 m], at: [70 m, 75 m, 1.5 m]}\n\nrig:")
    )
    hands.previewed()
    page.get_by_role("button", name="larger").first.click()
    page.get_by_role("button", name="move", exact=True).click()
    page.wait_for_function("() => workbench.views.stage.gl.domElement.clientWidth > 600")
    page.get_by_role("button", name="top", exact=True).click()
    return hands


def test_two_clicks_in_the_picture_measure_a_distance(page: Any, hands: Hands) -> None:
    page.get_by_role("button", name="top", exact=True).click()
    page.get_by_role("button", name="measure", exact=True).click()
    for x in (9.9, -9.9):
        hands.drag("block", [x, -7.9, 4.0], (0, 0))
    told = page.locator(".moving", has_text="x ").inner_text()
    assert abs(float(told.partition(" m")[0]) - 19.8) < 0.8, "from one end of the block to the other, to a pixel"


def test_dragging_a_block_obstacle_or_crane_edits_the_scene_and_can_be_undone(page: Any, mover: Hands) -> None:
    before = mover.text
    for body, p, path in (
        ("block", [9.0, 1.0, 4.0], ("block", "at")),
        ("wall", [0.0, 0.0, 1.5], ("obstacles", "wall", "at")),
    ):
        mover.drag(body, p, (25, -15))
        mover.until(lambda path=path: place(mover.text, *path) != place(before, *path))  # type: ignore[misc]
        now, then = place(mover.text, *path), place(before, *path)
        assert all(abs(2 * x - round(2 * x)) < 1e-6 for x in now[:2]), "on the grid"
        assert now[2] == then[2], "from above heights stay"
        assert mover.text.count("#") == before.count("#"), "comments stay"
        page.wait_for_function("text => workbench.editor.text === text", arg=mover.text)
        page.get_by_role("button", name="undo").click()
        mover.until(lambda: mover.text == before)
        mover.previewed()
    boxes = "workbench.views.stage.run.boxes.filter(b => b.body === 'crane.main')"
    middle = page.evaluate(f"() => {boxes}.reduce((a, b) => b.size[1] > a.size[1] ? b : a).centre")
    mover.drag("crane.main", [middle[0], middle[1] - 40.0, middle[2]], (40, 0))
    mover.until(lambda: place(mover.text, "cranes", "crane", "at") != [40.0])


def test_a_support_is_moved_by_dragging_and_by_arrow_keys(page: Any, mover: Hands) -> None:
    path = ("block", "supports", "at", 3)
    mover.drag("block", [8.0, 6.0, -4.0], (-14, 0))
    mover.until(lambda: place(mover.text, *path) != [8.0, 6.0])
    x, y = place(mover.text, *path)
    assert x < 8.0
    assert place(mover.text, "block", "supports", "at", 0) == [-8.0, -6.0], "the others stay"
    page.locator("#views canvas").first.focus()
    for key in ("ArrowDown", "Shift+ArrowRight", "ArrowDown"):  # not waiting for pictures
        page.keyboard.press(key)
    mover.until(lambda: place(mover.text, *path) == [x + 0.01, y - 1.0])
    mover.previewed()


def test_a_lug_that_passes_close_to_a_hook_snaps_to_the_position_under_the_hook(page: Any, mover: Hands) -> None:
    """The beam of loader-1 hangs between P1 and P2, so its hook stands at x = -6 m of the block."""
    views = "const { stage, picture } = workbench.views"
    hung = "const h = picture.hooks.find(x => x.name === 'crane.H1')"
    hook = page.evaluate(f"() => {{ {views}; {hung}; return stage.labels.place(h.body, h.p).toArray(); }}")
    lug = page.evaluate(f"() => {{ {views}; return stage.labels.place('block', [-8, -6, 4.3]).toArray(); }}")
    here, there = (mover.grip("world", p) for p in (lug, [hook[0], hook[1], lug[2]]))
    page.mouse.move(*here)
    page.mouse.down()
    page.mouse.move(there[0] + 1, there[1], steps=4)
    page.mouse.up()
    mover.until(lambda: place(mover.text, "block", "lugs", "P1") != [-8.0, -6.0, 4.3])
    x, y, z = place(mover.text, "block", "lugs", "P1")
    assert [40.0 + x, 75.0 + y] == pytest.approx(hook[:2], abs=2e-3), "to a millimetre, as it is written"
    assert z == 4.3


def test_dragging_a_part_in_a_side_view_of_the_workbench_changes_only_the_height(page: Any, mover: Hands) -> None:
    page.get_by_role("button", name="along y", exact=True).click()
    page.wait_for_timeout(100)
    mover.drag("wall", [0.0, -3.0, 1.0], (0, -30))
    mover.until(lambda: place(mover.text, "obstacles", "wall", "at")[2] > 1.5)
    x, y, z = place(mover.text, "obstacles", "wall", "at")
    assert (x, y) == (70.0, 75.0)
    assert abs(2 * z - round(2 * z)) < 1e-6


def test_clicking_a_part_in_the_picture_opens_its_form_and_shows_its_lines_in_the_scene_text(
    page: Any, hands: Hands
) -> None:
    hands.drag("block", [9.0, -7.0, 4.0], (0, 0))
    page.locator("#outline [data-path='block'][aria-current]").wait_for()
    page.locator("#form [data-key='mass']").wait_for()
