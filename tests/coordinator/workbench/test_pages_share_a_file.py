"""Two pages of one workbench show the same scene: neither overwrites what the other has written."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import pytest
from planner import Hands, PATIENCE_s


@pytest.fixture
def second(chromium: Any, page: Any, hands: Hands) -> Iterator[Hands]:
    """A planner before another page of the same scene."""
    other = chromium.new_page(viewport=page.viewport_size)
    other.set_default_timeout(1e3 * PATIENCE_s)
    other.goto(page.url)
    other.wait_for_selector("html[data-schema][data-checks]")
    yield Hands(other, hands.file)
    other.close()


def test_an_edit_in_one_workbench_page_appears_in_others_and_an_edit_of_an_outdated_version_is_refused(
    hands: Hands, second: Hands
) -> None:
    delayed = list[Any]()
    second.page.route("**/edit", lambda route: delayed.append(route))
    second.choose("block")
    second.fill("mass", "320 t")
    second.until(lambda: bool(delayed))
    hands.choose("block")
    hands.fill("mass", "310 t")
    hands.written("mass: 310 t")
    second.written("mass: 310 t")
    delayed[0].continue_()
    second.page.locator("#form .error", has_text="changed elsewhere").wait_for()
    assert "mass: 310 t" in hands.text
    second.page.unroute("**/edit")
    second.fill("mass", "330 t")
    second.written("mass: 330 t")
    hands.written("mass: 330 t")


def test_text_typed_in_one_workbench_page_is_not_lost_when_another_page_saves(hands: Hands, second: Hands) -> None:
    second.page.route("**/save", lambda route: route.abort())
    second.page.locator(".cm-line", has_text="name: lift").click()
    second.page.keyboard.press("End")
    second.page.keyboard.type("-of-mine")
    hands.choose("block")
    hands.fill("mass", "310 t")
    hands.written("mass: 310 t")
    second.page.locator("#conflict").wait_for()
    assert "of-mine" not in hands.text
    second.page.unroute("**/save")
    second.page.get_by_role("button", name="take theirs").click()
    second.shown()
    assert "of-mine" not in hands.text
