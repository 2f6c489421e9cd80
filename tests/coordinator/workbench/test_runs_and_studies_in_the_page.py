"""Runs and studies by button: a live run takes orders, results lead to their places, studies have their pages."""

from __future__ import annotations

from typing import Any

import pytest
from planner import Hands, RUN_s


def shorten(hands: Hands, last: str) -> None:
    """Leave only the first stage of the lift, followed by one more line."""
    begun, _, _ = hands.text.partition("  - stage: lift off")
    hands.file.write_text(f"{begun}{last}")
    hands.previewed()


def test_buttons_of_the_workbench_pause_and_command_and_continue_and_stop_a_run(page: Any, hands: Hands) -> None:
    shorten(hands, "  - stage: long wait\n    wait: 100 h\n")
    said = page.get_by_label("What the run says").get_by_role("status")
    page.get_by_role("button", name="Run", exact=True).click()
    page.wait_for_function("() => Number(document.documentElement.dataset.samples) > 1", timeout=RUN_s * 1e3)
    assert page.locator("#grid.motion .curves canvas").count() > 0, "loads are drawn while the lift is simulated"
    page.locator("#control").get_by_role("button", name="pause").click()
    said.filter(has_text="paused at").wait_for()
    page.locator("#control progress[value]").wait_for()
    page.get_by_role("button", name="stop hooks").click()
    said.filter(has_text="continues").wait_for()
    events = "workbench.views.motion.run.events.map(x => x.text)"
    assert not any("all hooks: stop" in x for x in page.evaluate(events)), "it waits until the run continues"
    page.locator("#control").get_by_role("button", name="continue").click()
    page.wait_for_function(f"() => {events}.some(x => x.includes('all hooks: stop'))")
    page.locator("#control").get_by_role("button", name="stop").click()
    page.wait_for_selector("html[data-run^=ended]")
    page.wait_for_function("() => document.querySelector('#verdict').textContent.startsWith('my-lift.mcap: ')")
    page.get_by_role("tab", name="Checks").click()
    row = page.locator("#checks tbody tr", has_text="lug design load").first
    subject = row.locator("td").nth(2).inner_text().split(" (")[0]
    row.click()
    page.wait_for_selector(f"html[data-pinned='{subject}']")
    hands.file.write_text(hands.text.replace("mass: 300 t", "mass: 310 t"))
    hands.previewed()
    page.get_by_role("tab", name="Runs").click()
    page.locator("#recordings .older").wait_for()
    page.get_by_role("button", name="Report and drawings", exact=True).first.click()
    said.filter(has_text="the scene was changed after my-lift.mcap was recorded").wait_for()
    assert not [*hands.file.parent.glob("*-report*")], "a report of the former scene would look like one of this scene"


@pytest.mark.large
def test_the_workbench_compares_the_run_of_a_changed_scene_with_the_run_of_the_original(
    page: Any, hands: Hands
) -> None:
    shorten(hands, "")
    hands.run()
    page.get_by_role("button", name="Duplicate").click()
    page.get_by_role("dialog").get_by_role("button", name="create").click()
    page.wait_for_selector("option[value='my-lift-2.yaml']:checked", state="attached")
    hands.file = hands.file.parent / "my-lift-2.yaml"
    hands.choose("block")
    hands.fill("mass", "250 t")
    hands.written("mass: 250 t")
    hands.run()
    page.get_by_role("button", name="beside my-lift.mcap").click()
    page.locator("#differences", has_text="mass").wait_for()
    with page.expect_popup() as popup:
        page.get_by_role("link", name="one report of both").click()
    popup.value.get_by_role("heading", name="Largest use of each quantity").wait_for()
    popup.value.close()


@pytest.mark.large
def test_a_sweep_and_a_limit_search_started_in_the_workbench_open_as_pages(page: Any, hands: Hands) -> None:
    shorten(hands, "")
    page.get_by_role("tab", name="Sweeps").click()
    form, pages = page.get_by_role("form", name="Vary the scene"), page.get_by_label("Pages of studies")
    form.get_by_role("button", name="start").click()
    form.get_by_text("name what to vary").wait_for()
    for kind, step, name in (("sweep", "50 t", "my-lift-study-1"), ("limits", "", "my-lift-limits.html")):
        form.get_by_label("study").select_option(kind)
        for label, value in (("quantity", "block.mass"), ("from", "200 t"), ("to", "300 t"), ("step", step)):
            if value:
                form.get_by_label(label, exact=True).fill(value)
        form.get_by_role("button", name="start").click()
        link = pages.get_by_role("link", name=name)
        link.wait_for(timeout=RUN_s * 1e3)
        with page.expect_popup() as popup:
            link.click()
        popup.value.locator("td", has_text="t").first.wait_for()
        assert "block.mass" in popup.value.locator("body").inner_text()
        popup.value.close()
