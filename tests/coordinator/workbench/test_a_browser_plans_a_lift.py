"""The workbench in a browser: preview beside another editor, edits by text and form, undo, conflicts, proposals."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import pytest
from heavylift.coordinator.workbench import runs, version_of
from heavylift.nodes.scene.text import read
from planner import Hands


def test_the_workbench_page_shows_a_scene_saved_by_any_editor(page: Any, hands: Hands) -> None:
    assert page.locator("#verdict").inner_text().startswith("GREEN")
    assert page.locator(".sheet svg").count() == 3
    wider = hands.text.replace("size: [20 m, 16 m, 8 m]", "size: [22 m, 16 m, 8 m]")
    hands.file.write_text(wider)
    hands.previewed()
    assert "22.00" in page.locator(".sheet svg").first.text_content()
    assert page.locator(".view.stale").count() == 0
    hands.file.write_text(wider.replace("22 m, 16 m", "22 bananas, 16 m"))
    page.wait_for_selector("html[data-faults='1']")
    assert "line 11" in page.locator("#faults").inner_text()
    assert "^" in page.locator("#faults pre").text_content()
    page.wait_for_selector(".view.stale")
    assert "22.00" in page.locator(".sheet svg").first.text_content(), "the last good picture stays"
    assert "last good picture" in page.locator(".view .mark").first.inner_text()
    assert page.locator("#outline .bad").first.inner_text().startswith("Block"), "the outline shows where the fault is"


def test_the_slider_of_the_workbench_steps_through_the_stages(page: Any) -> None:
    stages = page.locator("#stages span")
    assert stages.all_text_contents() == ["at the start", "take up slack", "lift off", "up", "sideways", "swing"]
    before = page.locator(".sheet").nth(1).inner_html()
    stages.filter(has_text="sideways").click()
    assert "sideways" in page.locator("#state").inner_text()
    page.locator(".sheet").nth(1).locator("text=/^3[.]/").first.wait_for()
    assert page.locator(".sheet").nth(1).inner_html() != before, "the block hangs a metre above its supports"
    row = page.locator("#checks tbody tr").first
    subject = row.locator("td").nth(2).inner_text().split(" (")[0]
    row.click()
    assert "sideways" not in page.locator("#state").inner_text(), "a check leads to its time"
    page.wait_for_selector(f"html[data-pinned='{subject}']")  # and to its place


def test_edits_by_text_and_by_form_change_the_same_file_and_can_be_undone(page: Any, hands: Hands) -> None:
    text = hands.text
    hands.choose("block")
    hands.fill("mass", "310 t")
    formed = text.replace("mass: 300 t", "mass: 310 t")
    hands.previewed(formed)
    assert hands.text == formed, "comments and order are kept"
    page.locator(".cm-line", has_text="mass: 310 t").click(position={"x": 40, "y": 5})
    page.keyboard.press("End")
    page.keyboard.press("Backspace")
    page.keyboard.type("kg")
    typed = formed.replace("310 t", "310 kg")
    page.wait_for_selector(f"html[data-faults], html[data-checks='{version_of(typed)}']")
    for _ in range(3):
        page.get_by_role("button", name="undo").click()
    hands.previewed(text)
    assert hands.text == text


def test_assumed_values_are_amber_in_the_workbench_until_the_user_accepts_them(page: Any, hands: Hands) -> None:
    hands.file.write_text(hands.text.replace("limits: {clearance: 0.5 m, ", "limits: {"))
    hands.written("limits: {off-lead")
    hands.choose("limits")
    page.locator("[data-assumed='clearance']").get_by_role("button").click()
    hands.written("clearance: 0.5 m}")
    page.locator("[data-assumed='clearance']").wait_for(state="detached")
    hands.previewed()
    hands.file.write_text(hands.text.replace(", clearance: 0.5 m}", "}"))
    hands.shown()
    hands.previewed()
    page.locator("#checks tr.amber").get_by_role("button", name="accept assumed limits").first.click()
    hands.written("assumed: accept")


def test_a_form_of_the_workbench_offers_types_and_hooks_and_keeps_the_unit_of_an_edited_value(
    page: Any, hands: Hands
) -> None:
    menu = page.locator("#outline").get_by_label("add to Cranes").locator("option")
    assert any(x.startswith("jib-60: luffing jib crane") for x in menu.all_inner_texts())
    offered = "x => [...x.list.options].map(y => y.value)"
    hands.choose("cranes", "crane")
    assert "jib-60" in page.locator("#form [data-key='type']").evaluate(offered)
    hands.choose("rig", "loaders", "loader-1")
    assert page.locator("#form [data-key='hook']").evaluate(offered) == ["crane H1", "crane H2", "crane H3"]
    page.locator("#stages span").filter(has_text="sideways").click()
    state = page.locator("#state").inner_text()
    hands.fill("sling", "11.5")
    hands.written("sling: 11.5 m")
    hands.previewed()
    assert page.locator("#state").inner_text().split(" · ")[1:] == state.split(" · ")[1:], "the end of the same stage"


def test_the_workbench_shows_a_change_by_another_editor_as_a_conflict_and_does_not_overwrite_it(
    page: Any, hands: Hands
) -> None:
    text = hands.text
    page.route("**/save", lambda route: route.abort())
    page.locator(".cm-line", has_text="name: lift").click()
    page.keyboard.press("End")
    page.keyboard.type("-of-mine")
    theirs = text.replace("name: lift", "name: theirs")
    hands.file.write_text(theirs)
    page.locator("#conflict").wait_for()
    assert hands.text == theirs
    page.unroute("**/save")
    page.get_by_role("button", name="keep mine").click()
    hands.previewed(text.replace("name: lift", "name: lift-of-mine"))
    assert "name: lift-of-mine" in hands.text


def test_the_text_editor_of_the_workbench_completes_and_explains_scene_keys_by_the_schema(page: Any) -> None:
    page.locator(".cm-line", has_text="mass: 300 t").click(position={"x": 40, "y": 5})
    page.keyboard.press("End")
    page.keyboard.press("Enter")
    page.keyboard.type("ine")
    page.locator(".cm-tooltip-autocomplete", has_text="inertia").wait_for()
    page.keyboard.press("Escape")
    page.locator(".cm-line .tok-key", has_text="supports").hover()
    page.locator(".cm-tooltip .about", has_text="Supports under the block").wait_for()


def test_a_second_block_can_be_added_by_the_menu_of_the_workbench(page: Any, hands: Hands) -> None:
    hands.add("Block", "another block")
    keys = list(read(hands.text, "x").data)
    assert keys[keys.index("blocks") - 1] == "cranes", "among the keys where the schema has it"
    hands.previewed()
    assert page.locator("html").get_attribute("data-faults") == "0"
    page.wait_for_function("() => workbench.views.stage.frames.has('block-1')")
    hands.choose("blocks", "block-1")
    hands.fill("mass", "40 t")
    hands.written("    mass: 40 t")


PLANNER = """import sys
scene, out = sys.argv[2], sys.argv[4]
text = open(scene).read().replace("min until all", "min ramp 1 s until all")
open(out, "w").write(text.replace("traverse 20 m/min", "traverse 15 m/min"))
print("saves 9 s")
"""


def test_the_user_accepts_or_refuses_each_change_that_the_timing_planner_proposes(
    page: Any, hands: Hands, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(runs, "COMMAND", [sys.executable, "-c", PLANNER])  # which takes a minute
    before = hands.text
    page.get_by_role("button", name="Shorten ...", exact=True).click()
    changes = page.locator("#proposal li")
    changes.first.wait_for()
    assert hands.text == before, "nothing is changed before it is accepted"
    changes.filter(has_text="ramp 1 s").get_by_role("button", name="refuse").click()
    changes.filter(has_text="traverse").get_by_role("button", name="accept").click()
    after = before.replace("traverse 20 m/min", "traverse 15 m/min")
    hands.previewed(after)
    assert hands.text == after
    assert page.locator("#proposal").is_hidden()
    assert not [*hands.file.parent.glob("*-planned.yaml")], "a proposal leaves no file behind"


def test_a_bundled_scene_can_be_viewed_and_copied(page: Any, folder: Path) -> None:
    page.get_by_label("scene", exact=True).select_option("jib")
    page.get_by_text("read only").wait_for()
    page.get_by_role("button", name="Copy into the folder").click()
    page.get_by_role("dialog").get_by_label("name").fill("my-jib")
    page.get_by_role("dialog").get_by_role("button", name="create").click()
    page.wait_for_selector("select option[value='my-jib.yaml']", state="attached")
    assert (folder / "my-jib.yaml").exists()
