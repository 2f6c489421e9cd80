"""A frame of `rig` hangs on the hooks of every type, lifts a block there, and its crane moves it; statics by hand."""

from __future__ import annotations

import pytest
from heavylift.coordinator.ladder import play
from heavylift.kernel import SceneError
from heavylift.kernel.description import Point
from heavylift.nodes.scene import parse
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
def test_a_frame_hangs_on_every_type_of_crane(name: str) -> None:
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


def test_a_machine_standing_on_another_one_can_hold_rigging() -> None:
    text = bundled()["floating"].read_text() + "rig: {loaders: {one: {hook: crane main, sling: 3 m}}}\n"
    with pytest.raises(SceneError, match="crane stands on barge: hang `rigging` on its hooks, no frame of `rig`"):
        parse(text, "scene.yaml", passing=True)
