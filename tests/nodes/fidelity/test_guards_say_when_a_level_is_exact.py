"""A coarser model level is called exact if the motion it fixes does not occur; runs on both levels are then equal."""

from __future__ import annotations

import msgspec
import numpy as np
import pytest
from heavylift.coordinator.ladder import at_level
from heavylift.coordinator.record import play
from heavylift.kernel.description import Point
from heavylift.nodes.models.levels import exact, left_out
from heavylift.nodes.plan import Fidelity, Plan, planar
from heavylift.nodes.scene import parse
from heavylift.nodes.scene.keys.parts import place, poses

SCENE = """
heavylift: 1
name: mirrored
{wind}
block:
  mass: 4 t
  size: [8 m, 6 m, 2 m]
  at: [{x} m, {y} m, 2 m]
  com: [0 m, 0 m, {com} m]
  lugs: {{A: [-2 m, -1 m, 1 m], B: [2 m, -1 m, 1 m], C: [-2 m, 1 m, 1 m], D: [2 m, 1 m, 1 m]}}
  supports: {{height: 1 m, at: [[-3 m, -2 m], [3 m, -2 m], [-3 m, 2 m], [3 m, 2 m]]}}
cranes: {{crane: {{type: {type}{more}}}}}
rigging: {{legs: {{on: {hook}, to: [A, B, C, D], length: {length}, slack: 0.1 m}}}}
actions:
  - {hook}: hoist 0.5 m/min until all slings taut
  - {hook}: hoist 0.5 m/min until lifted
  - {hook}: hoist 2 m/min by 0.2 m
  - {order}
  - wait: 5 s
"""
PLAIN = {"wind": "", "com": "0.1", "length": "4 m", "order": "wait: 1 s"}
IN_PLANE = {
    "crawler-250": ("along", "crane main", "crane: luff 0.1 deg/s by 0.5 deg"),
    "jib-60": ("along", "crane main", "crane: luff 0.1 deg/s by 0.5 deg"),
    "pedestal-400": ("along", "crane main", "crane: luff 0.1 deg/s by 0.5 deg"),
    "rough-terrain-59": ("along", "crane main", "crane: luff 0.1 deg/s by 0.5 deg"),
    "overhead-100": ("across", "crane main", "crane: traverse 10 m/min by 0.5 m"),
    "goliath-900": ("across", "crane H3", "crane lower trolley: traverse 10 m/min by 0.5 m"),
}
OUT = {"along": "crane: slew 0.1 deg/s by 0.5 deg", "across": "crane: travel 10 m/min by 0.5 m"}
WINDS = {"along": "[1, 0, 0]", "across": "[0, 1, 0]"}
HZ = 2.0  # of samples, between which there are rows of events
STEPS = 1e-4  # relative, of peaks of two runs with steps of their own
UNEVEN = {"along": "[4 m, 4 m, 4 m, 3.9 m]", "across": "[4 m, 4 m, 4 m, 3.9 m]"}


def plan(name: str, **changes: str) -> Plan:
    """Four slings on a hook in the plane of a crane, which its drive moves in that plane."""
    motion, hook, order = IN_PLANE[name]
    more = ", radius: 6 m" if name == "rough-terrain-59" else ""
    bare = parse(f"heavylift: 1\nname: bare\nend: 1 s\ncranes: {{crane: {{type: {name}{more}}}}}\n", passing=True)
    given = bare.scene.machines["crane"].hooks[hook.replace(" ", ".")]
    x, y, _ = place(Point(given.on, given.at), poses(bare.plan.machines[0].system)).tolist()
    words = PLAIN | {"order": order, "hook": hook} | changes
    text = SCENE.format(x=x, y=y, type=name, more=more, **words)
    found = msgspec.structs.replace(parse(text, "mirrored.yaml", passing=True).plan, tolerance=1e-8)
    return at_level(found, Fidelity(motion=motion))


@pytest.mark.parametrize("name", sorted(IN_PLANE))
@pytest.mark.large(beyond=2)
def test_a_mirror_symmetric_lift_stays_in_its_plane_of_symmetry(name: str) -> None:
    given = plan(name, wind=f"wind: {{speed: 6 m/s, direction: {WINDS[IN_PLANE[name][0]]}}}")
    assert exact(given)["motion"] == "by symmetry"
    assert not [word for word in left_out(given) if "motion" in word]
    flat, free = play(given), play(at_level(given, Fidelity()))
    a, b = (run.past.part(0, len(run.t)).poses["block"][run.t * HZ % 1.0 == 0.0] for run in (flat, free))
    assert np.abs(a - b).max() < 1e-5
    for rope, peak in flat.peaks.items():
        assert peak.tension == pytest.approx(free.peaks[rope].tension, rel=STEPS)


@pytest.mark.parametrize("name", sorted(IN_PLANE))
@pytest.mark.parametrize("broken", ["wind", "order", "length"])
@pytest.mark.large(beyond=3)
def test_a_planar_model_of_an_asymmetric_lift_is_not_called_exact(name: str, broken: str) -> None:
    motion = IN_PLANE[name][0]
    other = "across" if motion == "along" else "along"
    change = {
        "wind": f"wind: {{speed: 6 m/s, direction: {WINDS[other]}}}",
        "order": OUT[motion],
        "length": UNEVEN[motion],
    }[broken]
    given = plan(name, **{broken: change})
    assert "motion" not in exact(given)
    assert [word for word in left_out(given) if "motion" in word]


def test_locking_a_joint_is_called_exact_if_a_drive_holds_it_and_no_order_moves_it() -> None:
    given = plan("overhead-100", order=OUT["across"])
    for joint, drive, held in (("crane.runway", "crane.travelling", False), ("crane.girder", "crane.traversing", True)):
        locked = at_level(given, planar(Fidelity(locked=(joint,)), given.machines))
        assert any(x.name == drive for machine in given.machines for x in machine.system.drives)
        assert (exact(locked).get("locked") == "nothing moves it") is held
        assert ("1 joint locked" in left_out(locked)) is not held


def test_supports_for_the_other_face_of_the_block_are_left_out_unless_the_block_turns() -> None:
    given = plan("overhead-100")
    assert exact(given)["supports"] == "nothing is turned"
    assert not {"slings", "ropes"} & {*exact(given)}
    assert exact(given)["beams"] == "there is none"
