"""Impossible orders are refused before a run on every crane: moves past an end, slings through a block."""

from __future__ import annotations

from functools import cache

import pytest
from heavylift.kernel import SceneError
from heavylift.kernel.description import Point
from heavylift.nodes.scene import LoadedScene, parse
from heavylift.nodes.scene.keys.parts import place, poses
from heavylift.nodes.scene.text import library

BARE = "heavylift: 1\nname: bare\nend: 1 s\ncranes: {{crane: {{type: {}{}}}}}\n"
NEAR = {"rough-terrain-59": ", radius: 6 m"}  # so that its chart allows it
SCENE = """
heavylift: 1
name: ends
block:
  mass: 4 t
  size: [8 m, 6 m, 2 m]
  at: [{x} m, {y} m, 2 m]
  lugs: {{L: [0 m, 0 m, {lug} m]}}
  supports: {{height: 1 m, at: [[-3 m, -2 m], [3 m, -2 m], [-3 m, 2 m], [3 m, 2 m]]}}
cranes: {{crane: {{type: {type}{more}}}}}
rigging: {{leg: {{on: {hook}, to: [L], length: 5 m}}}}
actions:
  - {target}: {order}
"""
FAR = 3000.0  # [m] beyond all ends


@cache
def bare(name: str) -> LoadedScene:
    """The crane alone."""
    return parse(BARE.format(name, NEAR.get(name, "")), "bare.yaml", passing=True)


def scene(name: str, target: str, order: str, lug: float = 1.0) -> LoadedScene:
    """A block below the first hook of a type, and an order."""
    found = bare(name)
    hook, given = next(iter(found.scene.machines["crane"].hooks.items()))
    (machine,) = found.plan.machines
    x, y, _ = place(Point(given.on, given.at), poses(machine.system)).tolist()
    own = {"x": x, "y": y, "lug": lug, "hook": hook.replace(".", " ", 1), "target": target, "order": order}
    return parse(SCENE.format(type=name, more=NEAR.get(name, ""), **own), "ends.yaml", passing=True)


def sliding() -> list[tuple[str, str, str]]:
    """Type, drive and verb of everything that slides between ends."""
    found = []
    for name in sorted(library()):
        keys = bare(name).scene.machines["crane"]
        kinds = {joint: x.type for joint, x in keys.joints.items()}
        turned = {x.child for x in keys.joints.values() if x.type == "revolute"}
        of = ((drive, x, keys.joints[x.joint].parent) for drive, x in keys.drives.items())
        found += [
            (name, drive, x.verb)
            for drive, x, on in of
            if kinds[x.joint] == "prismatic" and x.range and x.verb and on not in turned
        ]
    return found


@pytest.mark.parametrize(("name", "drive", "verb"), sliding())
@pytest.mark.large(beyond=4)
def test_a_move_beyond_an_end_position_is_refused_on_every_crane_type(name: str, drive: str, verb: str) -> None:
    with pytest.raises(SceneError, match=r"past the end of its|would be"):
        scene(name, drive, f"{verb} 1 m/min by {FAR:g} m")


@pytest.mark.parametrize("order", ["hoist", "lower"])
@pytest.mark.parametrize("name", sorted(library()))
@pytest.mark.large(beyond=3)
def test_a_hook_move_beyond_its_rope_length_is_refused_on_every_crane_type(name: str, order: str) -> None:
    hook = next(iter(bare(name).scene.machines["crane"].hooks))
    with pytest.raises(SceneError, match=r"would be|its drum holds|its upper limit is"):
        scene(name, hook.replace(".", " ", 1), f"{order} 1 m/min by {FAR:g} m")


@pytest.mark.parametrize("name", sorted(library()))
@pytest.mark.large(beyond=3)
def test_a_sling_through_the_block_is_refused_on_every_crane_type(name: str) -> None:
    hook = next(iter(bare(name).scene.machines["crane"].hooks)).replace(".", " ", 1)
    scene(name, hook, "hoist 1 m/min by 0.1 m")
    with pytest.raises(SceneError, match=r"rigging\.leg: leg\.sling-1 would go through 2 m of the block"):
        scene(name, hook, "hoist 1 m/min by 0.1 m", lug=-1.0)
