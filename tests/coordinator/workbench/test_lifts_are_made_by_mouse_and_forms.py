"""Whole lifts by mouse and forms alone, from an empty folder to verdict and report: that of the tutorial, and one of
two cranes from a spreadsheet. They take the pictures of the page, too."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from heavylift.nodes.scene import bundled
from heavylift.nodes.scene.text import read
from planner import Hands, RUN_s

SHEETS = Path(__file__).parent / "spreadsheets"


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """An empty folder."""
    return tmp_path


@pytest.mark.large
def test_the_lift_of_the_tutorial_can_be_made_changed_run_compared_and_reported_in_the_workbench(
    page: Any, hands: Hands
) -> None:
    hands.begin("my-lift", "lift")
    hands.previewed()
    verdict, worst = page.locator("#verdict"), page.locator("#checks tbody tr").first
    assert verdict.inner_text().startswith("GREEN: 96 passed")
    hands.choose("block")
    hands.fill("mass", "600 t")
    hands.written("mass: 600 t")
    hands.previewed()
    assert verdict.inner_text().startswith("RED")
    assert "lug design load" in worst.inner_text()
    assert "114 %" in worst.inner_text()
    page.get_by_role("button", name="undo").click()
    hands.written("mass: 300 t")
    hands.previewed()
    assert hands.run().startswith("GREEN: 105 passed")
    page.get_by_role("tab", name="Loads and tables").click()
    assert "1928.3" in page.locator("#panel").inner_text(), "the peak tension of the tutorial"

    page.get_by_role("button", name="Duplicate").click()
    page.get_by_role("dialog").get_by_label("name").fill("slower")
    page.get_by_role("dialog").get_by_role("button", name="create").click()
    page.wait_for_selector("option[value='slower.yaml']:checked", state="attached")
    hands.file = hands.file.parent / "slower.yaml"
    hands.previewed()
    hands.choose("actions", "3")
    hands.fill("speed", "10 m/min", order="trolleys")
    hands.written("trolleys: traverse 10 m/min by 2 m")
    hands.previewed()
    assert hands.run().startswith("GREEN")
    page.get_by_role("button", name="beside my-lift.mcap").click()
    page.locator("#differences h2", has_text="my-lift.mcap").wait_for()
    page.wait_for_timeout(500)
    hands.picture("variants")
    with page.expect_popup() as popup:
        page.get_by_role("link", name="one report of both").click()
    popup.value.get_by_role("heading", name="Largest use of each quantity").wait_for()
    page.get_by_role("button", name="Report and drawings", exact=True).first.click()
    page.wait_for_selector("html[data-kept='slower.mcap']", timeout=RUN_s * 1e3)
    kept = {x.name for x in hands.file.parent.glob("slower-*")}
    assert kept >= {"slower-report.pdf", "slower-report.xlsx", "slower-report.dxf", "slower-drawing-1.svg"}
    page.get_by_label("scene", exact=True).select_option("start page")
    assert page.locator("#start .state.green").count() == 2, "scenes of the folder are listed with their verdicts"


def test_an_empty_scene_becomes_a_lift_without_faults_through_the_menus_of_the_workbench(
    page: Any, hands: Hands
) -> None:
    hands.begin("first", "")
    for group, label in (
        ("Block", "block"),
        ("Cranes", "goliath-900"),
        ("Lifting beams", "lifting beam"),
        ("Lifting beams", "sling of all beams"),
        ("Lifting beams", "shackle of all beams"),
        ("Stages", "take up slack"),
        ("Stages", "lift off"),
    ):
        hands.add(group, label)
    hands.previewed()
    assert page.locator("html").get_attribute("data-faults") == "0"
    assert page.locator("#verdict").inner_text().startswith("GREEN")


@pytest.mark.large
def test_a_lift_by_two_cranes_can_be_planned_for_a_block_from_a_spreadsheet(page: Any, hands: Hands) -> None:
    hands.begin("two-cranes", "")
    for number, place in (("1", "40 m"), ("2", "76 m")):
        hands.add("Cranes", "goliath-900")
        hands.choose("cranes", f"crane-{number}")
        hands.fill("at", place)
        hands.written(f"crane-{number}: {{type: goliath-900, at: {place}}}")
    hands.add("Block", "block")
    hands.choose("block")
    hands.paste((SHEETS / "block.csv").read_text(), "mm", "kg")
    for key, value in (("at", "[58 m, 70 m, 7 m]"), ("lug capacity", "200 t")):
        hands.fill(key, value)
        hands.written(f"{key}: {value}")
    hands.choose("block", "supports")
    hands.paste((SHEETS / "supports.csv").read_text(), "mm")
    hands.fill("capacity", "200 t")
    hands.written("  capacity: 200 t")
    hands.choose("block", "lugs")
    hands.paste((SHEETS / "lugs.csv").read_text(), "mm", instead=True)
    hands.previewed()
    for label in ("sling of all beams", "shackle of all beams", *4 * ["lifting beam"]):
        hands.add("Lifting beams", label)
    for number, hook in enumerate(("crane-1 H1", "crane-1 H2", "crane-2 H1", "crane-2 H2"), 1):
        hands.choose("rig", "loaders", f"loader-{number}")
        for key, value in (("hook", hook), ("sling", "12 m")):
            hands.fill(key, value)
            hands.until(
                lambda at=("rig", "loaders", f"loader-{number}", key), value=value: found(hands.text, *at) == value
            )  # type: ignore[misc]
    for stage in ("take up slack", "lift off", "hoist", "traverse", "wait"):
        hands.add("Stages", stage)
    hands.choose("actions", "0")
    page.get_by_role("button", name="remove the stage").click()
    hands.until(lambda: "stage: at rest" not in hands.text)
    hands.shown()
    hands.choose("actions", "2")
    hands.fill("value", "1.5 m", order="all hooks")
    hands.written("by 1.5 m")
    hands.choose("actions", "3")
    hands.fill("ramp", "one swing", order="trolleys")
    hands.written("traverse 10 m/min ramp one swing by 2 m")
    hands.previewed()
    assert page.locator("html").get_attribute("data-faults") == "0"
    page.locator("#stages span").filter(has_text="traverse").click()
    page.wait_for_timeout(500)
    hands.picture("workbench")
    at_rest = page.locator("#verdict").inner_text()
    assert at_rest.startswith("GREEN"), at_rest
    assert hands.run().startswith("GREEN")
    tandem = bundled()["tandem"].read_text()
    for path in (("block", "mass"), ("block", "lugs"), ("block", "supports", "at")):
        assert metres(found(hands.text, *path)) == metres(found(tandem, *path)), "what came from the spreadsheet"


def found(text: str, *path: str) -> Any:
    """What is written at a path of a scene's text."""
    value: Any = read(text, "x").data
    for key in path:
        value = value[key]
    return value


def metres(value: Any) -> Any:
    """Written quantities in m and t."""
    if isinstance(value, dict):
        return {key: metres(x) for key, x in value.items()}
    if isinstance(value, list):
        return [metres(x) for x in value]
    number, unit = value.split()
    return float(number) / (1e3 if unit in ("mm", "kg") else 1.0)
