"""A tugger line from the ground to a hanging block: its tension is checked and drawn, and it limits the swing."""

from __future__ import annotations

import numpy as np
import pytest
from heavylift.coordinator.record import RopeLines, play
from heavylift.kernel import SceneError
from heavylift.nodes.limits import uses_on_path
from heavylift.nodes.models import system
from heavylift.nodes.plan import Plan
from heavylift.nodes.scene import parse
from heavylift.nodes.statics import follow

PULL, SPREAD = 4e3, 0.5
SCENE = """
heavylift: 1
name: tugged
samples: 20 Hz
block:
  mass: 20 t
  size: [6 m, 4 m, 3 m]
  at: [20 m, 0 m, 2 m]
  lugs: {N1: [0 m, 0 m, 1.6 m]}
  supports: {height: 0.5 m, at: [[-2 m, -1.5 m], [2 m, -1.5 m], [-2 m, 1.5 m], [2 m, 1.5 m]], capacity: 10 t}
cranes:
  jib: {type: jib-60, radius: 20 m}
rigging:
  legs: {on: jib main, to: [N1], length: 8 m, sling: {EA: 60 MN, breaking: 2 MN, diameter: 36 mm}}
mechanism:
  name: tuggers
  forces: {%s}
actions:
  - {stage: take up, jib main: hoist 1 m/min until all slings taut}
  - {stage: lift off, jib main: hoist 1 m/min until lifted}
  - {stage: up, jib main: hoist 5 m/min by 2 m}
  - {stage: slew, jib: slew 1 deg/s by 5 deg}
  - {stage: hanging, wait: 40 s}
"""
LINE = (
    "%s: {type: tugger line, start: {body: world, at: [20 m, %s m, 2 m]}, end: {body: block, at: [0 m, %s m, 0 m]},"
    " tension: 4 kN, spread: %s, speed: 0.02 m/s, capacity: %s}"
)


def plan(spread: float = SPREAD, capacity: str = "7 kN") -> Plan:
    """Two lines, which pull the block to either side."""
    lines = (("port", 30, 2), ("starboard", -30, -2))
    return parse(SCENE % ", ".join(LINE % (name, far, near, spread, capacity) for name, far, near in lines)).plan


def swing(of: Plan) -> float:
    """Range [m] across the boom of the block's motion in the last two periods of its hanging stage."""
    run = play(of)
    return float(np.ptp(run.past.part(0, len(run.t)).poses["block"][run.t > run.t[-1] - 25.0, 1]))


@pytest.mark.parametrize("capacity", ["7 kN", "0 kN"])
def test_the_tension_of_a_tugger_line_is_checked_against_its_capacity(capacity: str) -> None:
    """Without a capacity its limit is not known."""
    loaded = plan(capacity=capacity)
    rows = [x for x in uses_on_path(loaded, list(follow(loaded).states)) if x.limit.quantity == "rope tension"]
    tugs = {x.limit.subject: x for x in rows if x.limit.subject != "jib.main"}
    assert {*tugs} == {"port", "starboard"}
    for row in tugs.values():
        assert row.value == pytest.approx(PULL)
        assert row.use == (pytest.approx(PULL / 7e3) if capacity == "7 kN" else None)


def test_a_tugger_line_tension_set_above_its_capacity_is_refused() -> None:
    with pytest.raises(SceneError, match=r"rope tension of port would be 4 kN, 103 %; 3.9 kN is allowed"):
        plan(capacity="3.9 kN")


def test_the_tugger_line_tension_stays_within_its_spread_and_the_line_is_drawn_to_the_block() -> None:
    loaded = plan()
    run = play(loaded)
    tension = run.past.part(0, len(run.t)).tensions["port"]
    assert (1.0 - SPREAD) * PULL < tension.min() < 0.8 * PULL
    assert 1.1 * PULL < tension.max() < (1.0 + SPREAD) * PULL
    (row,) = [x for x in run.judge.fine[1] if (x.limit.subject, x.limit.quantity) == ("port", "rope tension")]
    assert tension.max() <= row.value * (1.0 + 1e-9) < (1.0 + SPREAD) * PULL
    assert row.use == pytest.approx(row.value / 7e3)
    (drawn,) = [x for x in RopeLines([system(loaded)]).drawn() if x.rope == "port"]
    assert (drawn.a, drawn.b_body, drawn.b) == ((20.0, 30.0, 2.0), "block", (0.0, 2.0, 0.0))


def test_tugger_lines_with_friction_damp_the_residual_swing_after_slewing() -> None:
    """Lines of constant tension alone bring the swing to no rest."""
    assert swing(plan()) < 0.2 * swing(plan(spread=0.0))
