"""A mechanism may refer to bodies and joints of a lift: wind, guides, ropes and frames act on them."""

from math import hypot

import pytest
from heavylift.kernel import SceneError
from heavylift.nodes.models import build, system
from heavylift.nodes.scene import LoadedScene, parse
from heavylift.nodes.statics import world
from lifting import hook_ropes

G = 9.80665
BLOCK, HANGING = 300e3, 3 * (25e3 + 10e3 + 10e3)  # the block; hook blocks and loaders [kg]
WIND = 0.5 * 1.225 * 1.3 * 160.0 * 15.0**2  # [N]


WAIT = "actions: [{wait: 1 s}]\n"
UP = "actions: [{all hooks: hoist 0.3 m/min until lifted}, {all hooks: hoist 3 m/min by 0.5 m}]\n"


def lift(parts: str, more: str = UP) -> LoadedScene:
    """The bundled lift with a mechanism beside it."""
    text = f"extends: lift\nname: lift\nend: 40 s\n{more}mechanism:\n  name: site\n{parts}"
    return parse(text, "scene.yaml", passing=True)


def pulls(scene: LoadedScene) -> tuple[float, float, float]:
    """What all hook ropes together pull at the end of the path at rest [N]."""
    end = scene.states[-1]
    total = [0.0, 0.0, 0.0]
    for rope in hook_ropes(scene.plan).values():
        for line in rope.lines:
            a, b = world(end, line.a.body, line.a.p), world(end, line.b.body, line.b.p)
            distance = [p - q for p, q in zip(a, b, strict=True)]
            length = hypot(*distance)
            for i in range(3):
                total[i] += line.share * end.tensions[rope.name] * distance[i] / length
    return total[0], total[1], total[2]


def test_wind_on_the_block_deflects_its_hook_ropes() -> None:
    blows = "{type: wind, body: block, area: 160 m2, drag: 1.3, direction: [0, 1, 0], speed: 15 m/s}"
    scene = lift(f"  forces: {{wind: {blows}}}\n")
    along, across, up = pulls(scene)
    assert along == pytest.approx(0.0, abs=1.0)
    assert across == pytest.approx(-WIND, rel=1e-6)
    assert up == pytest.approx((BLOCK + HANGING) * G, rel=1e-6)


def test_a_frame_bolted_to_the_block_hangs_with_it() -> None:
    bolted = "  bodies: {frame: {mass: 20 t}}\n  joints: {bolts: {type: fixed, parent: block, child: frame}}\n"
    assert pulls(lift(bolted))[2] == pytest.approx((BLOCK + HANGING + 20e3) * G, rel=1e-6)


def test_a_tag_line_pulls_the_block_until_the_block_meets_a_guide() -> None:
    """With what rigid contacts press no rest is followed: the lift is checked up to there, and a warning tells why."""
    line = "{start: {body: world, at: [40 m, 40 m, 0]}, end: {body: block, at: [0, -8 m, 0]}, EA: 1 MN, length: 27 m}"
    wall = "{body: block, at: [0, -8 m, 0], against: {at: [40 m, 66.9 m, 0], normal: [0, 1, 0]}}"
    pulled, guided = lift(f"  ropes: {{tag: {line}}}\n"), lift(f"  ropes: {{tag: {line}}}\n  contacts: {{w: {wall}}}\n")
    side = (0.0, -8.0, 0.0)
    end = pulled.states[-1]
    assert end.tensions["tag"] > 10e3
    assert world(end, "block", side)[1] < 66.89
    assert world(guided.states[-1], "block", side)[1] > 66.898
    message = [finding for finding in guided.checks if finding.quantity == "unfollowed"]
    assert [finding.word for finding in message] == ["not checked"]
    assert "'w' touches at" in message[0].sentence
    assert not [finding for finding in pulled.checks if finding.quantity == "unfollowed"]


def test_a_storm_brake_holds_the_crane_by_its_own_joint() -> None:
    brake = "{joint: crane.gantry, holds: 1 MN, stiffness: 100 MN/m, damping: 1 MN s/m}"
    scene = lift(f"  brakes: {{storm: {brake}}}\n", "actions: [{storm: engage}, {wait: 1 s}]\n")
    assert [brake.joint for brake in system(scene.plan).brakes if brake.name == "storm"] == ["crane.gantry"]
    assert list(build(scene.plan)["site"].children) == ["crane-gantry-acted-on"]


def test_a_contact_with_the_block_is_not_a_support() -> None:
    """The block is lifted when its supports are free, though it rubs along a wall."""
    wall = "{body: block, at: [0, 8 m, 0], against: {at: [40 m, 83 m, 0], normal: [0, -1, 0]}, friction: 0.2}"
    scene = lift(f"  contacts: {{wall: {wall}}}\n")
    assert scene.plan.machines[-1].closed == ("wall",)
    assert scene.statics.known
    assert [scene.states[i].grounded for i in (0, -1)] == [True, False]


@pytest.mark.parametrize(
    ("parts", "sentence"),
    [
        (
            "  forces: {push: {type: load, body: blok, force: [1 kN, 0, 0]}}\n",
            "mechanism.forces.push.body: there is no body 'blok'",
        ),
        (
            "  bodies: {block: {mass: 1 t}}\n  joints: {j: {type: fixed, child: block}}\n",
            "mechanism.bodies.block: the name 'block' is given twice: one of the machines has it, too",
        ),
        (
            "  ropes: {loader-1: {start: {body: world}, end: {body: block}, EA: 1 MN, length: 100 m}}\n",
            "mechanism.ropes.loader-1: the name 'loader-1' is given twice: one of the machines has it, too",
        ),
        (
            "  bodies: {mast: {mass: 1 t}}\n  joints: {j: {type: fixed, parent: mast, child: block}}\n",
            "mechanism.joints.j.child: the body 'block' belongs to the lift, which carries it: make it the 'parent'",
        ),
        (
            "  drives: {d: {joint: crane.gantry, type: prescribed, ramp: 1 m/s2}}\n",
            (
                "mechanism.drives.d.joint: the joint 'crane.gantry' belongs to the lift: a spring, stop, brake or "
                "force can act on it, no other"
            ),
        ),
        (
            "  locks: {d: {joint: loader-1.hinge}}\n",
            (
                "mechanism.locks.d.joint: the joint 'loader-1.hinge' belongs to the lift: a spring, stop, brake or "
                "force can act on it, no other"
            ),
        ),
        (
            "  springs: {s: {joint: block.free, stiffness: 1 kN/m}}\n",
            "mechanism.springs.s.joint: a free joint has no single coordinate to act on: 'block.free'",
        ),
        (
            "  springs: {s: {joint: crane.gantry, stiffness: 1 kN m/rad}}\n",
            "mechanism.springs.s.stiffness: '1 kN m/rad' is not a valid stiffness: "
            "'kN m/rad' is a unit of torsional stiffness",
        ),
    ],
)
def test_scene_elements_that_cannot_act_on_the_lift_are_reported_with_their_line_in_the_scene(
    parts: str, sentence: str
) -> None:
    with pytest.raises(SceneError) as refusal:
        lift(parts)
    first = str(refusal.value).splitlines()[0]
    assert first.startswith("scene.yaml:")
    assert sentence in first
