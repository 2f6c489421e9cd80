"""A frame of `rig` hangs on the hooks of every type, lifts a block there, and its crane moves it; statics by hand."""

from __future__ import annotations

from math import cos, radians, sin
from random import Random

import msgspec
import pytest
from heavylift.coordinator.record import play
from heavylift.kernel import SceneError
from heavylift.kernel.description import Point
from heavylift.nodes.scene import LoadedScene, parse
from heavylift.nodes.scene.keys.parts import place, poses
from heavylift.nodes.scene.text import library
from heavylift.nodes.scenes import bundled

FRAME = 20.0  # of a block loader besides the hook block [t]
SCENE = """
heavylift: 1
name: framed
block:
  mass: {mass} t
  size: [8 m, 6 m, 2 m]
  at: [{x} m, {y} m, 2 m]
  lugs: {{P: [-2 m, 0 m, 1.3 m], Q: [2 m, 0 m, 1.3 m]}}
  supports: {{height: 1 m, at: [[-3 m, -2 m], [3 m, -2 m], [-3 m, 2 m], [3 m, 2 m]]}}
cranes: {{crane: {{type: {type}{more}}}}}
rig: {{slack: 0.1 m, loaders: {{one: {{hook: {hook}, sling: 3 m, lugs: [P, Q]}}}}}}
actions:
  - one: hoist 0.3 m/min until all slings taut
  - one: hoist 0.3 m/min until lifted
  - stage: up
    one: hoist 1 m/min by 0.5 m
"""
NEAR = {"rough-terrain-59": ", radius: 6 m"}  # so that its chart allows it
MASS = 4.0  # [t]


def lifted(name: str) -> str:
    """A scene whose block stands below the first hook of a type."""
    more = NEAR.get(name, "")
    text = f"heavylift: 1\nname: bare\nend: 1 s\ncranes: {{crane: {{type: {name}{more}}}}}\n"
    bare = parse(text, "bare.yaml", passing=True)
    hook, given = next(iter(bare.scene.machines["crane"].hooks.items()))
    (machine,) = bare.plan.machines
    x, y, _ = place(Point(given.on, given.at), poses(machine.system)).tolist()
    return SCENE.format(mass=MASS, x=x, y=y, type=name, hook=hook.replace(".", " "), more=more)


@pytest.mark.parametrize("name", sorted(library()))
@pytest.mark.large(beyond=3)
def test_a_frame_can_hang_on_every_crane_type(name: str) -> None:
    scene = parse(lifted(name), "scene.yaml", passing=True)
    (hook,) = (h for machine in scene.plan.machines for h in machine.hooks if h.eye.body == "one.upper")
    assert scene.statics.known
    last = scene.statics.states[-1]
    assert not last.grounded
    carried = (MASS + FRAME) * 1e3 + hook.block_mass
    assert last.tensions[hook.rope] == pytest.approx(carried * scene.plan.gravity, rel=1e-6)
    rows = {(use.limit.quantity, use.limit.subject): use.value for use in scene.uses}
    assert rows["loader load", "one"] == pytest.approx(MASS * 1e3 * scene.plan.gravity, rel=1e-2)
    run = play(scene.plan)
    assert run.peaks[hook.rope].tension == pytest.approx(carried * scene.plan.gravity, rel=0.1)


AFLOAT = """
heavylift: 1
name: afloat
waves: {{height: 0.2 m, period: 8 s, heading: 150 deg, ramp: 20 s}}
vessels:
  barge:
    mass: 13400 t
    size: [110 m, 32 m, 8 m]
    draught: 4 m
    com: [0 m, 0 m, 1 m]
    at: [{x} m, {y} m, 0 m]
    heading: {heading} deg
    {motion}
block:
  on: {on}
  mass: {mass} t
  size: [8 m, 6 m, 2 m]
  at: [{bx} m, {by} m, 7 m]
  lugs: {{P: [-2 m, 0 m, 1.3 m], Q: [2 m, 0 m, 1.3 m]}}
  supports: {{height: 6 m, at: [[-3 m, -2 m], [3 m, -2 m], [-3 m, 2 m], [3 m, 2 m]]}}
cranes: {{crane: {{type: pedestal-400, on: barge, at: [0 m, 0 m, 4 m], radius: 26 m}}}}
rig: {{slack: {slack} m, loaders: {{one: {{{frame}hook: crane main, sling: 3 m, lugs: [P, Q]}}}}}}
actions:
  - one: hoist 1 m/min until all slings taut
  - one: hoist 6 m/min until lifted
  - stage: up
    one: hoist 6 m/min by 1 m
"""
MOTIONS = {
    "given": "responses: {heave: [0.45 m/m, 10 deg], roll: [0.5 deg/m, -70 deg]}",
    "forces": "motion: forces\n    floating: {waterplane: 3500 m2, GM: 5 m, GML: 150 m, "
    "mooring: {surge: 2 MN/m, sway: 2 MN/m, yaw: 900000 kN m/rad}}",
}
BAR = """
frame type: 1
name: bar
eye: {body: bar, apart: 2 m}
slings: [{body: bar, at: [-2 m, 0 m, -1 m]}, {body: bar, at: [2 m, 0 m, -1 m]}]
bodies: {bar: {mass: 20 t, com: [0 m, 0 m, -0.5 m], box: [5 m, 0.5 m, 1 m]}}
"""


def afloat(seed: int, motion: str) -> LoadedScene:
    """A frame on the hook of a crane that stands on a barge, anywhere and with any heading."""
    r = Random(seed)
    x, y, heading = r.uniform(-60.0, 60.0), r.uniform(-60.0, 60.0), r.uniform(-180.0, 180.0)
    deck = r.random() < 0.7
    c, s = cos(radians(heading)), sin(radians(heading))
    place = {"on": "barge", "bx": 26.0, "by": 0.0} if deck else {"on": "world", "bx": x + 26 * c, "by": y + 26 * s}
    frame = r.choice(["", "type: bar, "])
    own = {"x": x, "y": y, "heading": heading, "motion": MOTIONS[motion], "frame": frame, "slack": r.uniform(0.1, 0.4)}
    types = f"types: {{bar: {{{', '.join(BAR.strip().splitlines())}}}}}\n" if frame else ""
    return parse(AFLOAT.format(mass=100.0, **place, **own) + types, "afloat.yaml", passing=True)


@pytest.mark.parametrize("motion", MOTIONS)
@pytest.mark.parametrize("seed", range(6))
@pytest.mark.large(beyond=2)
def test_a_frame_can_hang_on_a_crane_on_a_vessel(seed: int, motion: str) -> None:
    scene = afloat(seed, motion)
    assert scene.statics.known
    first, last = scene.statics.states[0], scene.statics.states[-1]
    assert not last.grounded
    assert last.tensions["crane.main"] == pytest.approx((100e3 + FRAME * 1e3 + 12e3) * scene.plan.gravity, rel=1e-6)
    still = msgspec.structs.replace(scene.plan, actions=(), end=1.0)
    run = play(still)
    assert run.peaks["crane.main"].tension == pytest.approx(first.tensions["crane.main"], rel=1e-3), "it begins at rest"
    rows = {(use.limit.quantity, use.limit.subject) for use in scene.uses}
    assert {("loader load", "one"), ("sling tension", "one.sling-1"), ("bridle angle", "one.sling-2")} <= rows


def test_a_machine_that_stands_on_another_machine_can_hold_rigging() -> None:
    text = bundled()["floating"].read_text() + (
        "machines: {other: {bodies: {other.deck: {mass: 1 t, box: [1 m, 1 m, 1 m]}}, "
        "joints: {other.foot: {type: fixed, child: other.deck}}}}\n"
        "rig: {loaders: {one: {hook: crane main, sling: 3 m}}}\n"
    )
    with pytest.raises(
        SceneError, match=r"crane stands on other\.deck: hang `rigging` on its hooks, no frame of `rig`"
    ):
        parse(text.replace("on: barge, at: [0 m, 0 m, 4 m]", "on: other.deck"), "scene.yaml", passing=True)
