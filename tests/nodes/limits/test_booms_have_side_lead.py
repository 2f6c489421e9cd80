"""Off-lead in the plane of a boom and side lead across it, for every bundled boom crane at any slewing angle."""

from __future__ import annotations

from math import atan2, degrees

import numpy as np
import pytest
from heavylift.kernel.description import Line, Point, Rope, ScalarSignal, System
from heavylift.kernel.model import numbers, points, scalar
from heavylift.nodes.limits import evaluated, signal_of, signals_of, uses_on_path
from heavylift.nodes.scene import LoadedScene, parse
from heavylift.nodes.statics import follow

EXACT = 1e-12
PULL = 5e3  # [N] level to 1e-5, from so far
CLOSE = 3e-4  # [rad] of 0.05: falls that converge do not share the load by their cosines alone
TYPES = {"jib-60": 20, "crawler-250": 14, "pedestal-400": 26, "rough-terrain-59": 9}  # with a radius [m]
SCENE = """
heavylift: 1
name: boom
limits: {off-lead: 20 deg%s}
block:
  mass: 10 t
  size: [2 m, 2 m, 2 m]
  at: [%d m, 0 m, 1.5 m]
  lugs: {N1: [0 m, 0 m, 1.1 m]}
  supports: {height: 0.5 m, at: [[-1 m, -1 m], [1 m, -1 m], [-1 m, 1 m], [1 m, 1 m]], capacity: 10 t}
cranes:
  crane: {type: %s, radius: %d m}
rigging:
  legs: {on: crane main, to: [N1], length: 4 m, sling: {EA: 60 MN, breaking: 2 MN, diameter: 36 mm}}
mechanism:
  name: tug
  forces:
    tug: {type: tugger line, start: {body: world, at: [0 m, 1000000 m, 4 m]}, end: {body: block, at: [0 m, 0 m, 1.1 m]},
          tension: 5 kN}
actions:
  - {stage: take up, crane main: hoist 1 m/min until all slings taut}
  - {stage: lift off, crane main: hoist 1 m/min until lifted}
  - {stage: up, crane main: hoist 5 m/min by 2 m}
  - {stage: slew, crane: slew 1 deg/s by 60 deg}
  - {stage: hanging, wait: 1 s}
"""


def scene(kind: str, more: str = "") -> LoadedScene:
    """A block that a level force of 5 kN pulls towards +y, while its crane slews by 60 degrees."""
    return parse(SCENE % (more, TYPES[kind], kind, TYPES[kind]))


@pytest.mark.parametrize("seed", range(20))
def test_lead_angles_along_and_across_a_boom_are_projections_of_its_rope(seed: int) -> None:
    random = np.random.default_rng(seed)
    axis, tip = random.normal(0.0, 10.0, 3), random.normal(0.0, 10.0, 3)
    rope = np.array([*random.normal(0.0, 2.0, 2), -random.uniform(1.0, 30.0)])
    line = Line(Point("world", tuple(tip)), Point("hook", tuple(tip + rope)))
    system = System(ropes=(Rope("rope", (line,), 1e8, 10.0),))
    out = (tip - axis) * [1.0, 1.0, 0.0]
    out /= np.linalg.norm(out)
    for kind, along in (("boom lead", out), ("side lead", np.cross([0.0, 0.0, 1.0], out))):
        x = ScalarSignal(kind, ropes=("rope",), point=Point("hook"), origin=Point("world", tuple(axis)))
        found = scalar(x, [p.p for p in points(x, system)], numbers(x, system), ())
        assert found == pytest.approx(atan2(rope @ along, -rope[2]), abs=EXACT)


@pytest.mark.parametrize("kind", TYPES)
def test_a_level_pull_turns_from_off_lead_to_side_lead_as_the_boom_slews(kind: str) -> None:
    """tan(lead) is the part of the pull in its plane over what hangs on the rope."""
    plan = scene(kind, ", off-lead along: 4 deg, off-lead across: 2 deg").plan
    states = [x for x in follow(plan).states if x.stage in ("up", "slew", "hanging")]
    signals = signals_of(states)
    (hook,) = [x for m in plan.machines for x in m.hooks]
    rows = {
        x.quantity: x for x in plan.limits if x.quantity.startswith("off-lead") and x.quantity != "off-lead in wind"
    }
    assert {*rows} == {"off-lead along", "off-lead across"}
    angle = np.array([x.coordinates["crane.slewing"] for x in states])
    assert np.ptp(angle) == pytest.approx(np.radians(60.0), abs=1e-6)
    hangs = signals.tensions[hook.rope] * np.cos(evaluated(plan, ScalarSignal("off-lead", ropes=(hook.rope,)), signals))
    for quantity, part in (("off-lead along", np.sin(angle)), ("off-lead across", np.cos(angle))):
        found = evaluated(plan, signal_of(rows[quantity], plan.machines, plan.gravity), signals)
        assert found == pytest.approx(np.arctan(PULL * part / hangs), abs=CLOSE)
    uses = {x.limit.quantity: x for x in uses_on_path(plan, states)}
    assert degrees(uses["off-lead across"].value) == pytest.approx(np.degrees(np.arctan(PULL / hangs)).max(), rel=0.01)


def test_the_off_lead_limit_across_a_boom_is_listed_as_side_lead() -> None:
    by = {x.quantity: x for x in scene("jib-60", ", off-lead across: 1 deg").plan.limits}
    assert by["off-lead across"].note == "side lead: across the plane of the boom"
    assert by["off-lead"].value == pytest.approx(np.radians(20.0))
    assert {x.quantity for x in scene("jib-60").plan.limits if "off-lead" in x.quantity} == {"off-lead"}


def test_a_side_lead_beyond_its_limit_gives_a_red_check() -> None:
    loaded = scene("jib-60", ", off-lead across: 1 deg")
    uses = {x.limit.quantity: x for x in uses_on_path(loaded.plan, list(follow(loaded.plan).states))}
    assert uses["off-lead across"].beyond
    assert not uses["off-lead"].beyond
