"""The `forces:` of a mechanism: every kind with its units, and each fault reported at its place."""

from math import radians
from pathlib import Path

import pytest
from heavylift.kernel import SceneError
from heavylift.kernel.description import (
    Bushing,
    Characteristic,
    InputSignal,
    Load,
    Point,
    Spring,
    Torsion,
    UserLaw,
    Wind,
)
from heavylift.nodes.plan import decode, encode
from heavylift.nodes.scene import load, parse

SCENE = """\
heavylift: 1
name: bench
end: 1 s
mechanism:
  bodies:
    cart: {mass: 4 t}
    jib: {mass: 1 t, com: [5 m, 0, 0], inertia: [0, 8000 kg m2, 8000 kg m2]}
  joints:
    rail: {type: prismatic, child: cart, axis: [0, 1, 0]}
    slew: {type: revolute, parent: cart, child: jib, axis: [0, 0, 1]}
  forces:
    tug:
      {type: load, body: jib, at: [5 m, 0, 0], force: [0, 3 kN, 0], moment: [0, 0, -2 kN m], axes: body, factor: 50 %}
    gale:
      {type: wind, body: jib, area: 12 m2, drag: 1.2, direction: [0, -2, 0], gusts: [[0 s, 5 m/s], [2 s, 60 m/min]]}
    stay: {type: spring, start: {body: world, at: [0, 9 m, 0]}, end: {body: cart}, rest: 9 m, stiffness: 2 kN/m}
    bar: {type: torsion, start: cart, end: jib, axis: [0, 0, 3], stiffness: 4 kN m/rad, damping: 1 kN m s/rad,
      rest: 90 deg}
    mount:
      type: bushing
      start: {body: cart}
      end: {body: jib}
      stiffness: [1 kN/m, 1 kN/m, 5 kN/m]
      turning stiffness: [0, 0, 7 N m/rad]
      damping: [1 N s/m, 0, 0]
    motor: {type: characteristic, joint: slew, over: speed, curve: [[10 deg/s, 8 kN m], [20 deg/s, 0]]}
    own: {type: law, function: "FILE:push", joint: rail, parameters: [3], history: [[0 s, 0], [1 s, 1]]}
"""
LAW = "def push(x):\n    return x.parameters[0] * x.signal - x.dq\n"


@pytest.fixture
def written(tmp_path, code_allowed):
    """A function that writes the scene with changes and returns its path."""
    (tmp_path / "mine.py").write_text(LAW)

    def write(*changes: tuple[str, str]) -> Path:
        text = SCENE.replace("FILE", "mine.py")
        for old, new in changes:
            assert text.count(old) == 1, old
            text = text.replace(old, new)
        path = tmp_path / "bench.yaml"
        path.write_text(text)
        return path

    return write


def test_every_type_of_force_can_be_written_in_a_scene(written, tmp_path):
    forces = {force.name: force for force in load(str(written())).plan.machines[0].system.forces}
    jib, cart, k6 = Point("jib"), Point("cart"), (1e3, 1e3, 5e3, 0.0, 0.0, 7.0)
    K, D = (
        tuple(tuple(x if i == j else 0.0 for j in range(6)) for i, x in enumerate(d)) for d in (k6, (1.0, *(0.0,) * 5))
    )
    described = (
        Load("tug", Point("jib", (5.0, 0.0, 0.0)), (0.0, 3e3, 0.0), (0.0, 0.0, -2e3), "body", InputSignal(0.5)),
        Wind("gale", jib, 12.0, 1.2, (0.0, -1.0, 0.0), InputSignal(0.0, (0.0, 2.0), (5.0, 1.0))),
        Spring("stay", Point("world", (0.0, 9.0, 0.0)), cart, 9.0, 2e3),
        Torsion("bar", "cart", "jib", (0.0, 0.0, 1.0), 4e3, 1e3, radians(90)),
        Bushing("mount", cart, jib, K, D),
        Characteristic("motor", "slew", "speed", (radians(10), radians(20)), (8e3, 0.0)),
        UserLaw(
            "own",
            f"{tmp_path / 'mine.py'}:push",
            "rail",
            parameters=(3.0,),
            signal=InputSignal(1.0, (0.0, 1.0), (0.0, 1.0)),
        ),
    )
    assert forces == {force.name: force for force in described}
    assert list(forces) == ["bar", "gale", "motor", "mount", "own", "stay", "tug"]


def test_forces_of_a_scene_reach_node_processes_unchanged(written):
    plan = load(str(written())).plan
    assert decode(encode(plan)) == plan


BAD = [
    ("type: load,", "type: lode,", "'lode' is not known here"),
    ("force: [0, 3 kN, 0]", "force: [0, 3 kg, 0]", "'3 kg' is not a valid force"),
    ("area: 12 m2", "area: 12 m", "'12 m' is not a valid area"),
    ("gusts: [[0 s, 5 m/s]", "gusts: [[5 s, 5 m/s]", "wind 'gale': signal goes back to 2.0 s; its times must not fall"),
    ("end: {body: cart}, rest", "end: {body: card}, rest", "there is no body 'card'"),
    ("axis: [0, 0, 3]", "axis: [0, 0, 0]", "torsion 'bar': axis has length 0; it must be a unit vector"),
    ("joint: slew, over", "joint: slow, over", "there is no joint 'slow'"),
    ("[[10 deg/s, 8 kN m]", "[[10 m/s, 8 kN m]", "'10 m/s' is not a valid angular rate"),
    ("[20 deg/s, 0]", "[20 deg/s, 3 kN]", "'3 kN' is not a valid moment"),
    ("mine.py:push", "mine.py:pull", "law 'own': there is no function 'pull'"),
    ("mine.py:push", "yours.py:push", "cannot be imported"),
    ("    own:", "    bar2:\n      type: law\n    own:", "the key 'function' is missing"),
    ("    own:", "    rail:", "the name 'rail' is given twice"),
]


@pytest.mark.parametrize(("old", "new", "told"), BAD)
def test_faults_of_forces_are_reported_with_their_line_in_the_scene(written, old, new, told):
    with pytest.raises(SceneError) as e:
        load(str(written((old, new))))
    sentence = str(e.value)
    assert told in sentence
    line = int(sentence.split("bench.yaml:")[1].split(":")[0])
    text = SCENE.replace("FILE", "mine.py")
    expected = text[: text.index(old)].count("\n") + 1
    assert abs(line - expected) <= 2


def test_a_user_law_with_a_python_branch_on_its_inputs_is_refused_when_the_scene_is_read(written, tmp_path):
    path = written()
    (tmp_path / "mine.py").write_text("def push(x):\n    if x.q > 0:\n        return 1.0\n    return 0.0\n")
    with pytest.raises(SceneError, match=r"law 'own': .*mine.py:push' at mine.py:2: traced code cannot branch"):
        load(str(path))


def test_a_scene_given_as_text_needs_no_folder():
    text = SCENE[: SCENE.index("    own:")]
    assert len(parse(text).plan.machines[0].system.forces) == 6
