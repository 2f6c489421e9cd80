"""Speeds at lift-off and landing are those of the points that touch, of the block that is meant."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from heavylift.coordinator.record import Played, play
from heavylift.coordinator.verdict import History, touches
from heavylift.nodes.limits import touching
from heavylift.nodes.scene import LoadedScene, load, parse

TAUT = '{stage: up, all hooks: "hoist 0.3 m/min until all slings taut"}'
LIFTED = '{all hooks: "hoist 0.3 m/min until lifted"}'
TILTED = f'{TAUT}, {LIFTED}, {{all hooks: "hoist 3 m/min by 0.5 m"}}, {{crane H3: "lower 3 m/min by 0.6 m"}}'
LUGS = "lugs: {A: [-2 m, 2 m, 2 m], B: [2 m, 2 m, 2 m], C: [-2 m, -2 m, 2 m], D: [2 m, -2 m, 2 m]}"
FEET = "supports: {height: 0.5 m, at: [[-2 m, -2 m], [2 m, -2 m], [-2 m, 2 m], [2 m, 2 m]]}"
QUAY = f"""\
heavylift: 1
name: lands
blocks:
  own: {{mass: 40 t, size: [6 m, 5 m, 4 m], at: [0 m, 8 m, 2.5 m], {LUGS}, {FEET}}}
  low: {{mass: 40 t, size: [6 m, 5 m, 4 m], at: [30 m, 8 m, 2.5 m], {LUGS}, {FEET}}}
cranes: {{hall: {{type: overhead-100, at: 0 m, trolley: 8 m}}}}
rigging: {{legs: {{on: hall main, to: [own.A, own.B, own.C, own.D], length: 6 m, sling: {{EA: 120 MN}}}}}}
obstacles: {{quay: {{box: [8 m, 8 m, 1 m], at: [0 m, 20 m, 0.5 m], meets: lower corners}}}}
limits: {{touch: 2 m/min}}
actions:
  - hall: hoist 1 m/min until own lifted
  - hall: hoist 4 m/min by 1 m
  - hall traversing: traverse 15 m/min ramp one swing by 12 m
  - hall: lower 3 m/min until own landed on quay
"""


@pytest.fixture(scope="module")
def tilted() -> Played:
    return play(load("lift", [f"actions=[{TILTED}]"]).plan)


@pytest.fixture(scope="module")
def quay() -> LoadedScene:
    return parse(QUAY, "quay.yaml", passing=True)


def speeds(scene: LoadedScene) -> dict[tuple[str, str], float | None]:
    rows = (x for x in scene.checks if x.quantity in ("lift-off speed", "landing speed"))
    return {(x.subject, x.quantity): x.value and 60.0 * x.value for x in rows}


def test_the_landing_speed_of_a_block_that_lands_on_one_edge_is_that_of_the_edge(tilted: Played) -> None:
    """The force of a pad at the instant of contact is that of its damper alone, which shows the speed."""
    (found,) = (x for x in tilted.verdict.checks if x.quantity == "landing speed")
    past = tilted.past.part(0, len(tilted.t))
    i = int(np.searchsorted(past.t, found.t or 0.0))
    pads = [pad for m in tilted.plan.machines for pad in m.system.supports if pad.name in past.tensions]
    shown = max(past.tensions[pad.name][i] / pad.d for pad in pads)
    assert sum(past.tensions[pad.name][i] > 0.0 for pad in pads) < len(pads)
    assert (found.state, found.value) == ("red", pytest.approx(shown, rel=1e-3))


def test_a_block_that_leaves_its_supports_while_the_hooks_are_lowered_is_not_counted_as_lift_off(
    tilted: Played,
) -> None:
    past = tilted.past.part(0, len(tilted.t))
    assert "block lift-off speed" in touches(tilted.plan, past)
    unwound = replace(past, lengths={name: -L for name, L in past.lengths.items()})
    assert "block lift-off speed" not in touches(tilted.plan, unwound)


def test_the_lift_off_speed_is_as_accurate_late_in_a_run_as_at_its_start(tilted: Played) -> None:
    past = tilted.past.part(0, len(tilted.t))
    late: History = replace(past, t=past.t + 100_000.0)
    speed, then = (touches(tilted.plan, x)["block lift-off speed"][0] for x in (past, late))
    assert then == pytest.approx(speed, abs=1e-10)


def test_an_action_without_a_name_is_checked_on_the_equilibrium_path(quay: LoadedScene) -> None:
    assert speeds(quay)["own", "lift-off speed"] == pytest.approx(1.0)


def test_a_landing_on_an_obstacle_is_checked_at_rest(quay: LoadedScene) -> None:
    assert speeds(quay)["own", "landing speed"] == pytest.approx(3.0)
    assert [x.state for x in quay.checks if x.quantity == "landing speed" and x.subject == "own"] == ["red"]


def test_an_ordered_hook_speed_is_checked_only_for_the_block_that_hangs_on_that_hook(quay: LoadedScene) -> None:
    assert speeds(quay)["low", "landing speed"] is speeds(quay)["low", "lift-off speed"] is None
    assert [x[0] for x in touching(quay.plan, "lift-off speed", "own")] == [1]


@pytest.mark.parametrize("hook", ["", 'jib main: "lower 3 m/min by 1 m", '])
def test_a_block_dropped_while_an_unloaded_hook_is_lowered_gives_a_red_check(hook: str) -> None:
    up = '{jib main: "hoist 1 m/min until all slings taut"}, {jib main: "hoist 1 m/min until lifted"}'
    drop = f'{{jib main: "hoist 1 m/min by 100 mm"}}, {{{hook}legs: release}}, {{wait: 2 s}}'
    checks = play(load("jib", [f"actions=[{up}, {drop}]", "end=60 s"]).plan).verdict.checks
    assert [x.state for x in checks if x.quantity == "landing"] == ["red"]
