"""A certificate that is missing or expired at the date of the project is a row that is not checked."""

from __future__ import annotations

from datetime import date, timedelta

import pytest
from heavylift.kernel.description import NOT_CHECKED
from heavylift.nodes.scene import load

TODAY = date(2026, 11, 29)
ITEMS = {"hall": ("WR-60", "SH-55"), "lift": ("WR-96", "SH-150"), "turnover": ("WR-96", "SH-200")}


def rows(name: str, *settings: str) -> dict[str, str]:
    found = (x for x in load(name, [*settings]).checks if x.quantity == "inputs")
    return {x.subject.removeprefix("certificate of "): x.why for x in found if x.subject.startswith("certificate")}


@pytest.mark.parametrize("name", ITEMS)
def test_the_certificate_of_lifting_gear_is_checked_at_the_date_of_the_project(name: str) -> None:
    first, *others = ITEMS[name]
    fresh = [f"gear.{x}.certificate={TODAY.isoformat()}" for x in others]
    for days, open_ in ((0, False), (365, False), (367, True), (3000, True)):
        given = [*fresh, f"gear.{first}.certificate={(TODAY - timedelta(days)).isoformat()}"]
        assert rows(name, *given) == {}
        assert rows(name, *given, f"project.date={TODAY.isoformat()}") == ({first: NOT_CHECKED} if open_ else {})
    unread = [*fresh, f"gear.{first}.certificate=in the drawer", f"project.date={TODAY.isoformat()}"]
    assert rows(name, *unread) == {first: NOT_CHECKED}
