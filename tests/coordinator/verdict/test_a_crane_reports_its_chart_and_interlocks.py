"""Radius and chart in each stage, how a crane is set up, interlocks with their margin, speed as hooks lift off."""

from __future__ import annotations

from functools import cache
from math import acos, cos, degrees, radians

import pytest
from heavylift.coordinator.record import Played, play
from heavylift.nodes.limits import HookReach
from heavylift.nodes.scene import check, load

LIGHT = "block.mass=40 t"
ROUNDED = 1e-4  # by which a radius may exceed that of its row, as rounding does


@cache
def played(name: str, *settings: str) -> Played:
    return play(load(name, list(settings)).plan)


def test_chart_capacity_and_load_are_listed_with_the_radius_at_start_end_and_maximum_of_each_stage() -> None:
    """At rest: the tip of 42 m stands 14 m out, then luffs by the scene; the next longer radius of the chart counts."""
    scene = load("crawler", [LIGHT])
    found = HookReach(scene.plan).see_path(scene.states)
    stages = list(dict.fromkeys(x.stage for x in found))
    assert [x.when for x in found] == ["begins", "most", "ends"] * len(stages)
    chart = {14.0: 104.5e3, 16.0: 86e3, 18.0: 72.5e3, 20.0: 62.5e3, 24.0: 48.5e3}
    up = [x for x in found if x.stage == "up"]
    assert [x.radius for x in up] == pytest.approx([14.0] * 3, abs=1e-6)
    assert [x.load for x in up] == pytest.approx([43.55e3] * 3, rel=1e-6)
    out = [x for x in found if x.stage == "luff out"]
    assert out[-1].radius == pytest.approx(1.5 + 42.0 * cos(radians(60.8)), abs=0.02)
    assert degrees(acos((out[0].radius - 1.5) / 42.0)) == pytest.approx(degrees(acos(12.5 / 42.0)), abs=0.1)
    for x in found:
        assert x.capacity == next(most for radius, most in chart.items() if x.radius <= radius * (1.0 + ROUNDED))
        assert x.use == x.load / x.capacity
    message = str(check(scene))
    assert "Radius and chart:" in message
    assert "boom 42 m, counterweight 100 t, falls 16, base tracks 7.8 m long, 7.2 m apart" in message


def test_the_largest_chart_utilisation_in_the_table_of_a_run_is_that_of_the_hook_load_check() -> None:
    run = played("crawler", LIGHT)
    hook = next(c for c in run.verdict.checks if c.quantity == "hook load")
    (table,) = (x for x in run.verdict.tables if x.title == "Radius and chart")
    rows = [dict(zip((x.name for x in table.columns), row, strict=True)) for row in table.rows]
    most = max((row for row in rows if row[""] == "most"), key=lambda row: row["use"])
    assert hook.use == pytest.approx(most["use"] / 100.0, rel=1e-12)
    assert (hook.t, hook.value) == (most["at"], pytest.approx(most["load"] * 1e3, rel=1e-12))


def test_an_interlock_that_never_stops_a_drive_is_listed_with_its_margin() -> None:
    heavy, light = played("crawler"), played("crawler", LIGHT)
    (own,) = (c for c in light.verdict.checks if c.quantity == "interlock")
    hook = next(c for c in light.verdict.checks if c.quantity == "hook load")
    assert own.state != "red"
    assert own.shown.endswith(f"at worst {100 * (own.value or 0):.0f} %")
    more = 1.03 * 1.05  # its moment is that chart; peaks lie between samples
    assert own.use == pytest.approx(more * (hook.use or 0.0), rel=0.03)
    tripped = [c for c in heavy.verdict.checks if c.quantity == "interlock"]
    assert [c.state for c in tripped] == ["red"]
    assert "stopped" in tripped[0].sentence


@pytest.mark.parametrize(("most", "state"), [("0.9 m/min", "red"), ("1.1 m/min", "green")])
def test_the_lift_off_speed_of_hooks_is_checked_against_its_limit(most: str, state: str) -> None:
    """The crawler hoists with 1 m/min until its load is lifted."""
    checks = load("crawler", [LIGHT, f"limits={{touch: {most}}}"]).checks
    (own,) = (c for c in checks if c.quantity == "lift-off speed")
    assert own.state == state
    assert own.value == pytest.approx(1.0 / 60.0, rel=1e-12)
    assert own.stage == "lift off"
    assert next(c for c in checks if c.quantity == "landing speed").value == pytest.approx(0.5 / 60.0, rel=1e-12)
