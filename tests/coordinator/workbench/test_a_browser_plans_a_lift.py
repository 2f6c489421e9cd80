"""The workbench in a browser: preview beside another editor, edits by text and form, undo, conflicts, runs."""

from __future__ import annotations

import os
import shutil
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from heavylift.coordinator.workbench import runs, version_of
from heavylift.nodes.scene import bundled

PATIENCE_s = 60.0


@pytest.fixture
def page(chromium: Any, address: str) -> Any:
    """The page of the folder when its checks are there."""
    page = chromium.new_page(viewport={"width": 1500, "height": 950}, color_scheme="light")
    complaints: list[str] = []
    page.on("pageerror", lambda error: complaints.append(str(error)))
    page.goto(address)
    page.wait_for_selector("html[data-checks][data-schema]")
    yield page
    assert complaints == []
    page.close()


def previewed(page: Any, text: str) -> None:
    """Wait until the checks of a text are shown."""
    page.wait_for_selector(f"html[data-checks='{version_of(text)}']")


def until(page: Any, holds: Callable[[], bool]) -> None:
    """Wait until something holds."""
    deadline = time.monotonic() + PATIENCE_s
    while not holds():
        assert time.monotonic() < deadline
        page.wait_for_timeout(50)


def scene_of(folder: Path) -> Path:
    return folder / "my-lift.yaml"


def test_the_workbench_notices_a_file_saved_by_any_editor(page: Any, folder: Path) -> None:
    assert page.locator("#verdict").inner_text().startswith("GREEN")
    assert page.locator(".sheet svg").count() == 3
    text = scene_of(folder).read_text()
    wider = text.replace("size: [20 m, 16 m, 8 m]", "size: [22 m, 16 m, 8 m]")
    scene_of(folder).write_text(wider)
    previewed(page, wider)
    assert "22.00" in page.locator(".sheet svg").first.text_content()
    assert page.locator(".view.stale").count() == 0
    scene_of(folder).write_text(wider.replace("22 m, 16 m", "22 bananas, 16 m"))
    page.wait_for_selector("html[data-faults='1']")
    assert "line 11" in page.locator("#faults").inner_text()
    page.wait_for_selector(".view.stale")
    assert "22.00" in page.locator(".sheet svg").first.text_content(), "the last good picture stays"
    assert "last good picture" in page.locator(".view .mark").first.inner_text()


def test_the_slider_of_the_workbench_leads_through_the_stages(page: Any) -> None:
    stages = page.locator("#stages button")
    assert stages.all_inner_texts()[:4] == ["at the start", "take up slack", "lift off", "up"]
    before = page.locator(".sheet").nth(1).inner_html()
    stages.filter(has_text="sideways").click()
    assert "sideways" in page.locator("#state").inner_text()
    page.locator(".sheet").nth(1).locator("text=/^3[.]/").first.wait_for()
    assert page.locator(".sheet").nth(1).inner_html() != before, "the block hangs a metre above its supports"
    page.locator("#checks tbody tr").first.click()
    assert "sideways" not in page.locator("#state").inner_text(), "a check leads to its place and time"


def test_text_and_form_of_the_workbench_edit_the_same_file_and_undo_works(page: Any, folder: Path) -> None:
    text = scene_of(folder).read_text()
    page.locator(".cm-line", has_text="mass: 300 t").click(position={"x": 40, "y": 5})
    field = page.locator("#form input[data-key='mass']")
    field.fill("310 t")
    field.press("Enter")
    formed = text.replace("mass: 300 t", "mass: 310 t")
    previewed(page, formed)
    assert scene_of(folder).read_text() == formed, "comments and order are kept"
    page.locator(".cm-line", has_text="mass: 310 t").click(position={"x": 40, "y": 5})
    page.keyboard.press("End")
    page.keyboard.press("Backspace")
    page.keyboard.type("kg")
    typed = formed.replace("310 t", "310 kg")
    page.wait_for_selector(f"html[data-faults], html[data-checks='{version_of(typed)}']")
    for _ in range(3):
        page.get_by_role("button", name="undo").click()
    previewed(page, text)
    assert scene_of(folder).read_text() == text


def test_a_change_from_another_editor_is_never_overwritten_unseen(page: Any, folder: Path) -> None:
    text = scene_of(folder).read_text()
    page.route("**/save", lambda route: route.abort())
    page.locator(".cm-line", has_text="name: lift").click()
    page.keyboard.press("End")
    page.keyboard.type("-of-mine")
    theirs = text.replace("name: lift", "name: theirs")
    scene_of(folder).write_text(theirs)
    page.locator("#conflict").wait_for()
    assert scene_of(folder).read_text() == theirs
    page.unroute("**/save")
    page.get_by_role("button", name="keep mine").click()
    previewed(page, text.replace("name: lift", "name: lift-of-mine"))
    assert "name: lift-of-mine" in scene_of(folder).read_text()


def test_the_scene_schema_completes_and_explains_keys_in_the_editor(page: Any) -> None:
    page.locator(".cm-line", has_text="mass: 300 t").click(position={"x": 40, "y": 5})
    page.keyboard.press("End")
    page.keyboard.press("Enter")
    page.keyboard.type("ine")
    page.locator(".cm-tooltip-autocomplete", has_text="inertia").wait_for()
    page.keyboard.press("Escape")
    page.locator(".cm-line .tok-key", has_text="supports").hover()
    page.locator(".cm-tooltip .about", has_text="Supports under the block").wait_for()


def drag(page: Any, body: str, p: list[float], by: tuple[int, int]) -> None:
    """Drag what is seen at a point of a body by so many pixels."""
    script = """([body, p]) => { const { stage } = workbench.views;
        const [x, y] = stage.labels.seen(stage.labels.place(body, p), stage.camera);
        const box = stage.gl.domElement.getBoundingClientRect(); return [box.x + x, box.y + y]; }"""
    x, y = page.evaluate(script, [body, p])
    page.mouse.move(x, y)
    page.mouse.down()
    page.mouse.move(x + by[0] / 2, y + by[1] / 2)
    page.mouse.move(x + by[0], y + by[1], steps=3)
    page.mouse.up()


def test_two_clicks_measure_a_distance_in_the_drawing(page: Any) -> None:
    page.get_by_role("button", name="top", exact=True).click()
    page.get_by_role("button", name="measure", exact=True).click()
    for x in (9.9, -9.9):
        drag(page, "block", [x, -7.9, 4.0], (0, 0))
    told = page.locator(".moving", has_text="x ").inner_text()
    assert abs(float(told.partition(" m")[0]) - 19.8) < 0.8, "from one end of the block to the other, to a pixel"


def test_dragging_an_item_writes_its_new_place_into_the_scene(page: Any, folder: Path) -> None:
    before = scene_of(folder).read_text()
    page.get_by_role("button", name="move", exact=True).click()
    drag(page, "block", [9.0, -7.0, 4.0], (-30, 0))
    page.wait_for_selector("html[data-picture^='start'], html[data-picture^='path']")
    page.locator(".cm-line", has_text="at: [40 m, 75 m, 6 m]").wait_for(state="detached")
    page.wait_for_timeout(300)
    (line,) = [x for x in scene_of(folder).read_text().splitlines() if x not in before.splitlines()]
    x, y, z = (float(x.removesuffix(" m")) for x in line.partition("[")[2].partition("]")[0].split(", "))
    assert (x, y) != (40.0, 75.0)
    assert z == 6.0
    assert "# on supports of 2 m" in line, "comments stay"
    page.get_by_role("button", name="undo").click()
    previewed(page, before)
    middle = page.evaluate("""() => workbench.views.stage.run.boxes.filter(b => b.body === 'crane.main')
        .reduce((a, b) => b.size[1] > a.size[1] ? b : a).centre""")
    drag(page, "crane.main", [middle[0], middle[1] - 40.0, middle[2]], (40, 0))
    page.locator(".cm-line", has_text="crane: {type: goliath-900, at: 40 m}").wait_for(state="detached")


@pytest.mark.large
def test_a_run_is_started_in_the_workbench_and_its_results_are_opened(page: Any, folder: Path) -> None:
    short = scene_of(folder).read_text().replace("name: lift\n", "name: lift\nend: 5 s\n")
    scene_of(folder).write_text(short)
    page.wait_for_selector(f"html[data-picture='start {version_of(short)}']")
    page.get_by_role("button", name="run", exact=True).click()
    page.wait_for_selector("html[data-run='ended 0']", timeout=120_000)
    assert "take up slack" in page.locator("#lines").inner_text()
    with page.expect_popup() as popup:
        page.get_by_role("link", name="3D page").click()
    popup.value.wait_for_selector("html[data-ready='yes']")
    assert popup.value.locator("#title").inner_text() == "lift"
    with page.expect_popup() as popup:
        page.get_by_role("link", name="report").click()
    popup.value.get_by_role("heading", name="Lift report").wait_for()
    shutil.copy(folder / "my-lift.mcap", folder / "other.mcap")
    page.reload()
    page.get_by_role("tab", name="runs").click()
    for box in (page.locator("#recordings input").nth(0), page.locator("#recordings input").nth(1)):
        box.check()
    with page.expect_popup() as popup:
        page.get_by_role("link", name="compare these two").click()
    popup.value.get_by_role("heading", name="Largest use of each quantity").wait_for()


PLANNER = """import sys
scene, out = sys.argv[2], sys.argv[4]
text = open(scene).read().replace("min until all", "min ramp 1 s until all")
open(out, "w").write(text.replace("traverse 20 m/min", "traverse 15 m/min"))
print("saves 9 s")
"""


def test_a_planned_timing_is_shown_as_changes_to_accept_or_refuse(
    page: Any, folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(runs, "COMMAND", [sys.executable, "-c", PLANNER])  # which takes a minute
    before = scene_of(folder).read_text()
    page.get_by_role("button", name="plan", exact=True).click()
    page.locator("#proposal").wait_for()
    assert scene_of(folder).read_text() == before, "nothing is changed before it is accepted"
    page.locator(".cm-deletedChunk").first.scroll_into_view_if_needed()
    page.get_by_role("button", name="Reject").first.click()
    page.get_by_role("button", name="accept the rest").click()
    previewed(page, after := before.replace("traverse 20 m/min", "traverse 15 m/min"))
    assert scene_of(folder).read_text() == after
    assert page.locator("#proposal").is_hidden()


SPREADSHEET = """lug\tx\ty\tz
A1\t-26000\t0\t5400
A2\t-21500\t0\t5400
B3\t21500\t0\t5400
B4\t26000\t0\t5400
"""


def test_a_lift_by_two_cranes_is_planned_from_a_spreadsheet_by_mouse_and_forms_alone(page: Any, folder: Path) -> None:
    page.on("dialog", lambda dialog: dialog.accept("two-cranes"))
    page.get_by_label("scene", exact=True).select_option("tandem")
    page.get_by_role("button", name="copy").click()
    page.wait_for_selector("select option[value='two-cranes.yaml']:checked", state="attached")
    form, path = page.locator("#form"), folder / "two-cranes.yaml"

    def into(*keys: str) -> None:
        form.get_by_role("button", name="scene", exact=True).click()
        for key in keys:
            form.locator(f"[data-key='{key}']").click()

    into("block")
    form.locator("input[data-key='mass']").fill("640 t")
    form.locator("input[data-key='mass']").press("Enter")
    page.locator(".cm-line", has_text="mass: 640 t").wait_for()
    into("block", "lugs")
    form.locator("textarea").fill(SPREADSHEET)
    form.get_by_label("lengths in").select_option("mm")
    form.get_by_role("button", name="add these rows").click()
    page.locator(".cm-line", has_text="A2: [-21500 mm, 0 mm, 5400 mm]").wait_for()
    form.get_by_label("add ...").select_option(label="wait")
    until(page, lambda: path.read_text().endswith("  - {stage: wait, wait: 20 s}\n"))
    into("actions")
    form.get_by_role("button", name="earlier 6").click()
    until(page, lambda: path.read_text().endswith("  - stage: swing\n    wait: 30 s\n"))
    text = path.read_text()
    assert text.count("#") == bundled()["tandem"].read_text().count("#"), "all comments are there"
    previewed(page, text)
    assert page.locator("html").get_attribute("data-faults") == "0"


def test_a_bundled_scene_is_viewed_and_copied_in_the_workbench(page: Any, folder: Path) -> None:
    page.on("dialog", lambda dialog: dialog.accept("my-jib"))
    page.get_by_label("scene", exact=True).select_option("jib")
    page.get_by_text("read only").wait_for()
    page.get_by_role("button", name="copy").click()
    page.wait_for_selector("select option[value='my-jib.yaml']", state="attached")
    assert (folder / "my-jib.yaml").exists()


@pytest.mark.parametrize("theme", ["light", "dark"])
def test_states_are_shown_in_words_besides_colours_and_axe_finds_no_serious_fault(page: Any, theme: str) -> None:
    page.emulate_media(color_scheme=theme)
    page.wait_for_selector(f"html[data-theme='{theme}']")
    words = page.locator("#checks td .state").all_inner_texts()
    assert words
    assert all(words)
    axe = pytest.importorskip("axe_playwright_python.sync_playwright")
    found = axe.Axe().run(page).response["violations"]
    assert [x["id"] for x in found if x["impact"] in ("serious", "critical")] == [], "keyboard and screen reader"


PICTURES = os.environ.get("HEAVYLIFT_PICTURES")  # folder for those of WORKBENCH.md


@pytest.mark.large
def test_the_screenshot_of_the_workbench_is_taken(page: Any, folder: Path, tmp_path: Path) -> None:
    shutil.copy(bundled()["turnover"], folder / "turnover.yaml")
    page.set_viewport_size({"width": 1500, "height": 900})
    page.get_by_label("scene", exact=True).select_option("turnover.yaml")
    text = (folder / "turnover.yaml").read_text()
    previewed(page, text)
    page.locator(".cm-line", has_text="mass: 900 t").click(position={"x": 40, "y": 5})
    page.locator("#stages button", has_text="turn to 90 degrees").click()
    page.locator(".sheet").nth(1).locator("text=/50[.]99/").first.wait_for()
    page.wait_for_timeout(500)
    path = Path(PICTURES or tmp_path) / "workbench.png"
    page.screenshot(path=path, scale="css")
    assert path.stat().st_size > 30_000
