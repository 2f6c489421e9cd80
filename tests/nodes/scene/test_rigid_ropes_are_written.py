"""`rigid: true` in a rope of a scene makes a rigid rope; keys of elasticity are refused there."""

import re

import pytest
from heavylift.kernel import SceneError
from heavylift.kernel.description import Line, Point, RigidRope
from heavylift.nodes.plan import CrossingCondition
from heavylift.nodes.scene import parse

SCENE = """\
heavylift: 1
name: snatch
mechanism:
  bodies:
    load: {mass: 1 t}
  joints:
    guide: {type: prismatic, child: load, axis: [0, 0, 1], start: -10 m}
  ropes:
    fall:
      start: {body: world}
      over: [{body: load, at: [0, 0, 1 m]}]
      end: {body: world}
      rigid: true
      length: 18 m
      winch: {ramp: 1 m/s2, shortest: 5 m, longest: 80 m}
    spare: {start: {body: world}, end: {body: load}, length: 9 m, rigid: true, hooked: false}
actions:
  - fall: hoist 3 m/min by 1 m or until tension of fall >= 5 MN
"""


def test_a_rigid_rope_has_a_length_but_no_stiffness():
    parsed = parse(SCENE)
    (mechanism,) = parsed.plan.machines
    load = Point("load", (0.0, 0.0, 1.0))
    lines = (Line(Point("world"), load), Line(load, Point("world")))
    spare = RigidRope("spare", (Line(Point("world"), Point("load")),), 9.0, hooked=False)
    assert mechanism.system.rigid_ropes == (RigidRope("fall", lines, 18.0, winch=True), spare)
    assert mechanism.system.ropes == ()
    assert mechanism.taut == ("fall",)
    assert [(a.name, a.start, a.lower, a.upper) for a in mechanism.actuators] == [("fall", 18.0, 5.0, 80.0)]
    assert isinstance(parsed.plan.actions[0].orders[0].until, CrossingCondition)


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        (
            "      rigid: true",
            "      rigid: true\n      EA: 1 MN",
            "14:7: .*a rigid rope cannot stretch: remove 'EA' or",
        ),
        ("      rigid: true", "      rigid: true\n      damping: 1 kN s/m", "14:7: .*remove 'damping' or 'rigid'"),
        (
            "      rigid: true\n",
            "",
            "9:5: .*the key 'EA' is missing; for a rope that cannot stretch, write 'rigid: true'",
        ),
        ("at: [0, 0, 1 m]}", "at: [0, 0, 1 m], radius: 0.2 m}", "13:7: .*a rigid rope runs over points only"),
        ("length: 18 m", "length: 17.9 m", "14:15: .*rigid and 100 mm too short for its ends at the start"),
        ("length: 18 m", "length: 4 m", "14:15: .*4 m of rope is not between 5 and 80 m"),
    ],
)
def test_mistakes_in_rigid_ropes_are_reported_with_their_line_in_the_scene(old, new, told):
    assert SCENE.count(old) == 1
    with pytest.raises(SceneError) as e:
        parse(SCENE.replace(old, new))
    assert re.search(f"scene.yaml:{told}", str(e.value), re.DOTALL), str(e.value)
