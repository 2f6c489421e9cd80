"""Keyboard and screen reader, light and dark, a tablet in landscape: axe finds nothing serious, nothing is cut."""

from __future__ import annotations

from typing import Any

import pytest
from planner import Hands

CUT = """() => [...document.querySelectorAll(
        "header button, .segments button, .tabs button, th, #state, summary, [data-key=size]")]
    .filter(x => x.checkVisibility() && x.scrollWidth > x.clientWidth + 1).map(x => x.outerHTML.slice(0, 90))"""
OUTSIDE = """() => [...document.querySelectorAll("header *, .toolbar *, .bar *, #path *")]
    .filter(x => { const box = x.getBoundingClientRect(); return box.right > innerWidth + 1 || box.left < -1; })
    .filter(x => x.checkVisibility())
    .map(x => x.outerHTML.slice(0, 90))"""


@pytest.mark.large(beyond=1)
@pytest.mark.parametrize(("theme", "width"), [("light", 1500), ("dark", 1500), ("light", 1024)])
def test_the_accessibility_checker_axe_finds_nothing_serious_and_no_text_is_cut_off(
    page: Any, hands: Hands, theme: str, width: int
) -> None:
    axe = pytest.importorskip("axe_playwright_python.sync_playwright").Axe()
    page.set_viewport_size({"width": width, "height": 768})
    page.emulate_media(color_scheme=theme)
    page.wait_for_selector(f"html[data-theme='{theme}']")
    if width < 1280:
        page.get_by_role("button", name="Text").click()

    def looked_at() -> None:
        found = axe.run(page).response["violations"]
        assert [x["id"] for x in found if x["impact"] in ("serious", "critical")] == [], found
        assert page.evaluate(CUT) == []
        assert page.evaluate(OUTSIDE) == []

    states = page.locator("#checks td .state").all_inner_texts()
    assert states
    assert all(states), "states have words beside their colours"
    looked_at()
    page.get_by_role("button", name="Text").click()
    looked_at()
    page.get_by_role("button", name="Text").click()
    page.get_by_role("button", name="New ...").first.click()
    looked_at()
    page.keyboard.press("Escape")
    hands.choose("block")
    looked_at()
    hands.choose("actions", "3")
    page.get_by_role("tab", name="Sweeps").click()
    looked_at()
    hands.file.write_text(hands.text.replace("mass: 300 t", "mass: 300 bananas"))
    page.wait_for_selector("html[data-faults='1']")
    page.get_by_label("scene", exact=True).select_option("start page")
    looked_at()


def test_a_lift_can_be_planned_with_the_keyboard_alone(page: Any, hands: Hands) -> None:
    """Tab leads from the header to the outline, where a thing is chosen, and to the form, where a field is filled."""

    def to(selector: str) -> None:
        for _ in range(80):
            if page.evaluate("selector => document.activeElement.matches(selector)", selector):
                return
            page.keyboard.press("Tab")
        raise AssertionError(f"no key leads to {selector}")

    page.locator("header select").focus()
    to("#outline [data-path='block']")
    page.keyboard.press("Enter")
    to("#form [data-key='mass']")
    page.keyboard.press("Control+a")
    page.keyboard.type("310 t")
    page.keyboard.press("Enter")
    hands.written("mass: 310 t")
    to("#form [data-key='size']")
    hands.previewed()  # until then the stages are made anew
    page.locator("#stages button").nth(3).focus()
    page.keyboard.press("Enter")
    page.locator("#state", has_text="up").wait_for()
    page.get_by_role("tab", name="Checks").focus()
    page.keyboard.press("ArrowRight")
    assert page.get_by_role("tab", name="Loads").get_attribute("aria-selected") == "true"
