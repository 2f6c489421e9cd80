"""Types of machines are data: their values are arithmetic over parameters, whose faults name file, line and column."""

from __future__ import annotations

import re
from math import acos, atan2, cos, pi, sqrt
from pathlib import Path

import pytest
from heavylift.kernel import SceneError
from heavylift.nodes.plan import plan
from heavylift.nodes.scene import load, parse
from heavylift.nodes.scene.text import (
    ExpressionError,
    Value,
    evaluated,
    expand,
    library,
    machine_type,
    read,
    shown_as,
    value_of,
)
from lifting import cranes

PARAMETERS = {"boom": "42 m", "radius": "12 m", "counterweight": "80 t", "upper exit": "102 m", "at.x": "-3 m"}
EXACT = [
    ("0.7*upper exit", 0.7 * 102.0, "m"),
    ("boom/2 - 1 m", 42.0 / 2 - 1.0, "m"),
    ("-(2 + 3)*4 - -1", -19.0, ""),
    ("0.5 t/m*boom", 500.0 * 42.0, "kg"),
    ("-5 m*counterweight/(70 t + counterweight)", -5.0 * 80e3 / (70e3 + 80e3), "m"),
    ("acos((radius - 1.5 m)/boom)", acos(10.5 / 42.0), "rad"),
    ("2*boom*cos(60 deg)", 2 * 42.0 * cos(60 * pi / 180), "m"),
    ("sqrt(boom*boom + radius*radius)", sqrt(42.0 * 42.0 + 144.0), "m"),
    ("atan2(radius, boom)", atan2(12.0, 42.0), "rad"),
    ("max(at.x, min(boom, radius))", 12.0, "m"),
    ("counterweight*(2*pi*1 Hz)*(2*pi*1 Hz)", 80e3 * (2 * pi) * (2 * pi), "N/m"),
    ("3 MN m/rad*1 deg", 3e6 * (pi / 180), "N m"),
]
WRONG = [
    ("boom + counterweight", 7, "m and kg cannot be added"),
    ("boom*(radius", 12, "a closing bracket"),
    ("boom radius", 0, "there is no parameter 'boom radius'"),
    ("2*", 2, "is expected here"),
    ("boom/(radius - 12 m)", 5, "division by zero: this expression is zero"),
    ("acos(boom/radius)", 0, "needs a ratio from -1 to 1, not 3.5"),
    ("sqrt(boom)", 0, "this value has no square root: it is negative, or its unit is not a square"),
    ("sin(boom)", 0, "needs an angle, not m"),
    ("__import__(1)", 0, "there is no parameter '__import__'"),
    ("(" * 30 + "1" + ")" * 30, 21, "nested deeper"),
]
SCENE = """\
heavylift: 1
name: own
end: 1 s
cranes:
  crane: {type: crane.yaml, boom: 12 m}
"""
TYPE = """\
machine type: 1
name: small
parameters: {boom: 10 m, mass: =0.2 t/m*boom}
bodies:
  boom: {mass: =mass, com: [=boom/2, 0 m, 0 m], box: [=boom, 1 m, 1 m]}
joints:
  foot: {type: revolute, child: boom, axis: [0, -1, 0], start: 30 deg}
"""


def parameter(name: str) -> Value | None:
    return value_of(PARAMETERS[name]) if name in PARAMETERS else None


def own(folder: Path, type_text: str = TYPE, scene: str = SCENE) -> Path:
    (folder / "crane.yaml").write_text(type_text)
    (folder / "own.yaml").write_text(scene)
    return folder / "own.yaml"


@pytest.mark.parametrize(("text", "number", "unit"), EXACT)
def test_arithmetic_in_machine_types_equals_that_of_python_in_si_units(text: str, number: float, unit: str) -> None:
    value = evaluated(text, parameter)
    assert value.number == pytest.approx(number, rel=4e-16, abs=0.0)
    assert str(shown_as(value)) == f"{value.number!r} {unit}".strip()
    back = value_of(shown_as(value))
    assert back == value  # what a scene reads of it is the same to the last bit


@pytest.mark.parametrize(("text", "column", "told"), WRONG)
def test_invalid_arithmetic_in_a_machine_type_is_reported_with_its_column(text: str, column: int, told: str) -> None:
    with pytest.raises(ExpressionError, match="[" + told[0] + "]" + told[1:].replace("(", r"\(")) as error:
        evaluated(text, parameter)
    assert error.value.column == column


def test_a_type_file_in_the_folder_of_a_scene_defines_a_machine_type(tmp_path: Path) -> None:
    scene = load(own(tmp_path))
    (crane,) = scene.plan.machines
    (boom,) = crane.system.bodies
    assert (crane.name, boom.name, boom.mass, boom.com[0]) == ("crane", "crane.boom", 2400.0, 6.0)
    assert boom.inertia[1][1] == 2400.0 / 12 * (12.0 * 12.0 + 1.0)
    again = parse(scene.merged, "own.yaml")  # in a recording stands all that a run needs
    assert plan.encode(again.plan).replace(b"own.yaml", b"") != b""
    assert again.plan.machines[0].system == crane.system


def test_a_setting_overrides_a_parameter_of_a_machine_type(tmp_path: Path) -> None:
    scene = load(own(tmp_path), ["cranes.crane.boom=15 m"])
    assert scene.plan.machines[0].system.bodies[0].mass == 3000.0


@pytest.mark.parametrize(
    ("type_text", "scene", "told"),
    [
        (TYPE.replace("=boom/2,", "=boom/2 + mass,"), SCENE, "crane.yaml:5:39: error: machines.crane"),
        (TYPE.replace("com: [=boom/2", "con: [=boom/2"), SCENE, "crane.yaml:5:23: error"),
        (TYPE.replace("child: boom", "child: beam"), SCENE, "crane.yaml:7:33: error"),
        (TYPE.replace("mass: =mass", "mass: =boom"), SCENE, "own.yaml:5:35: error: cranes.crane.boom: '12 m'"),
        (TYPE.replace("=0.2 t/m*boom", "=2*mass"), SCENE, "the parameter 'mass' depends on itself"),
        (TYPE.replace("machine type: 1", "heavylift: 1"), SCENE, "own.yaml:5:17: error"),
        (
            TYPE,
            SCENE.replace("boom: 12 m", "boom: 12 t"),
            "own.yaml:5:35: error: cranes.crane.boom: '12 t' does not fit",
        ),
        (
            TYPE,
            SCENE.replace("boom: 12 m", "bom: 12 m"),
            "own.yaml:5:29: error: cranes.crane.bom: the type crane.yaml has",
        ),
        (TYPE, SCENE.replace("crane.yaml", "cran.yaml"), "the type file 'cran.yaml' cannot be read"),
        (TYPE, SCENE.replace("crane.yaml", "../crane.yaml"), "outside of the scene's folder"),
        (TYPE, SCENE.replace("crane.yaml", "jib-6"), "'jib-6' is not known here"),
    ],
)
def test_faults_of_a_machine_type_are_reported_with_the_line_of_the_type_or_the_scene(
    tmp_path: Path, type_text: str, scene: str, told: str
) -> None:
    with pytest.raises(SceneError) as refused:
        load(own(tmp_path, type_text, scene))
    assert told in str(refused.value)


@pytest.mark.parametrize("kind", [name for name, path in library().items() if "\n  radius:" in path.read_text()])
def test_a_radius_out_of_reach_is_reported_as_a_fault_of_the_scene_for_every_crane_type(kind: str) -> None:
    for radius, cause in (("1000 m", "'acos' needs a ratio from -1 to 1"), ("2 m", "deg, past the end of its range")):
        with pytest.raises(SceneError, match=re.escape(cause)) as refused:
            parse(f"heavylift: 1\nname: far\nend: 1 s\ncranes:\n  c: {{type: {kind}, radius: {radius}}}\n", "far.yaml")
        assert f"far.yaml:5:{23 + len(kind)}: error: cranes.c.radius: " in str(refused.value)


OLD = """\
machine type: 1
family: goliath
name: mine
parameters: {span: 120 m, main mass: 3900 t, girder: [10 m, 110 m]}
bodies:
  main: {mass: =main mass, com: [0 m, =span/2, =0.7*upper exit], box: [=width, =span, =upper exit]}
drives:
  gantry: {moves: [main, upper, lower], frequency: =servo frequency, damping: =servo damping}
hooks:
  H1: {on: upper, at: [=-hook spacing, 0 m, =upper exit]}
  H2: {on: upper, at: [=hook spacing, 0 m, =upper exit]}
  H4: {on: lower, at: [0 m, 0 m, =lower exit]}
"""
NEW = """\
machine type: 1
extends: goliath-900
name: mine
parameters: {span: 120 m, main mass: 3900 t, girder: [10 m, 110 m]}
hooks: {H3: {falls: 18}}
"""


@pytest.mark.parametrize(("text", "hook", "falls"), [(OLD, "H4", 20), (NEW, "H3", 18)])
def test_a_machine_type_overrides_values_of_the_type_that_it_extends(
    tmp_path: Path, text: str, hook: str, falls: int
) -> None:
    (tmp_path / "mine.yaml").write_text(text)
    (tmp_path / "scene.yaml").write_text(
        "extends: lift\nname: other\ncranes: {crane: {type: mine.yaml, main_mass: 4000 t}}\n"
        f"rig: {{loaders: {{loader-3: {{hook: crane {hook}}}}}}}\n"
    )
    (crane,) = cranes(load(tmp_path / "scene.yaml").plan)
    assert [(x.rope, x.falls) for x in crane.hooks] == [("crane.H1", 20), ("crane.H2", 20), (f"crane.{hook}", falls)]
    main = next(body for body in crane.system.bodies if body.name == "crane.main")
    assert (main.mass, main.com[1], crane.girders[0].span) == (4000e3, 60.0, 120.0)
    assert crane.system.drives[0].kp == (4000e3 + 300e3 + 150e3) * (2 * pi) * (2 * pi)


@pytest.mark.parametrize("name", sorted(library()))
def test_every_machine_type_states_its_kind_and_the_source_of_its_data(name: str) -> None:
    kind = machine_type(name)
    assert kind.data["name"] == name
    assert all(kind.about(key) for key in ("about", "capacity", "source"))


@pytest.mark.parametrize("name", ["lift", "edge", "jib", "emergency-stop", "tandem"])
def test_parts_of_a_type_that_were_made_before_are_those_made_first(name: str) -> None:
    text = load(name).text
    first, second = (read(text, name) for _ in range(2))
    assert expand(first)
    other = read(text, name)
    assert expand(other)
    for machine in other.data.get("machines", {}).values():
        machine.clear()  # whoever changes parts does not change those of others
    assert expand(second)
    for kind in ("data", "keys", "values", "given", "offered", "faults"):
        assert getattr(first, kind) == getattr(second, kind)
