"""A quantity of a scene can say how uncertain it is; the run takes its nominal value, and is the same to the bit."""

from __future__ import annotations

import math
from pathlib import Path

import pytest
from heavylift.coordinator.run import run
from heavylift.kernel import SceneError
from heavylift.nodes.plan import Plan
from heavylift.nodes.scene import load, uncertain_inputs, varied
from heavylift.nodes.scene.inputs import inputs
from lifting import cargo
from msgspec.structs import replace

MASS = "block.mass"
TOLD = [
    ("block.mass=300 t +- 3 %", "block.mass", 300e3, "normal", 4.5e3),
    ("block.mass=300 t +/- 10 t", "block.mass", 300e3, "normal", 5e3),
    ("block.mass=300 t ± 4000 kg", "block.mass", 300e3, "normal", 2e3),
    ("block.mass=300 t sd 5 t", "block.mass", 300e3, "normal", 5e3),
    ("block.mass=300 t sigma 1 %", "block.mass", 300e3, "normal", 3e3),
    ("block.mass=294..306 t", "block.mass", 300e3, "uniform", 6e3 / math.sqrt(3.0)),
    ("block.mass=294 t .. 306 t", "block.mass", 300e3, "uniform", 6e3 / math.sqrt(3.0)),
    ("block.com=[0.1 m, 0 m +- 0.2 m, 0 m]", "block.com.y", 0.0, "normal", 0.1),
    ("block.com=[-0.2..0.2 m, 0 m, 0 m]", "block.com.x", 0.0, "uniform", 0.2 / math.sqrt(3.0)),
    ("cranes.crane.sheave efficiency=97 % +- 1 %", "cranes.crane.sheave efficiency", 0.97, "normal", 0.005),
    ("cranes.crane.sheave efficiency=0.97 +- 1 %", "cranes.crane.sheave efficiency", 0.97, "normal", 0.00485),
    ("cranes.crane.sheave efficiency=0.96..0.98", "cranes.crane.sheave efficiency", 0.97, "uniform", 0.01 / 3**0.5),
    ("block.inertia=[3e7..4e7 kg m2, 1e8 kg m2, 1e8 kg m2]", "block.inertia.x", 3.5e7, "uniform", 5e6 / 3**0.5),
    ("rig.sling.EA=445 MN +- 5 %", "rig.sling.EA", 445e6, "normal", 445e6 * 0.025),
    ("rig.loaders.loader-1.sling=10 m +- 5 mm", "rig.loaders.loader-1.sling", 10.0, "normal", 2.5e-3),
]
REFUSED = [
    ("block.mass=300 t +- -3 %", "'+- -3 %' is not a valid uncertainty"),
    ("block.mass=300 t +- nan t", "'+- nan t' is not a valid uncertainty"),
    ("block.mass=300 t +- 1e999 t", "'+- 1e999 t' is not a valid uncertainty"),
    ("block.mass=300 t +-", "'+-' is not a valid uncertainty"),
    ("block.mass=300 t +- 10", "'+- 10': the unit is missing; use %, t, kg"),
    ("block.mass=300 t sd 3 kN", "'sd 3 kN': 'kN' is not a unit of this quantity; use %, t, kg"),
    ("block.mass=300 t +- 120 %", "the range reaches down to -60 t, but a mass must be greater than zero here"),
    ("block.mass=300 t sd 60 %", "reaches down to -60 t"),
    ("block.mass=306..294 t", "'306..294 t': the first number must be less than the second one"),
    ("block.mass=300 kg..0.5 t", "'300 kg..0.5 t': write both ends in one unit"),
    ("block.mass=nan t +- 3 %", "'nan t +- 3 %' is not a valid mass"),
    ("block.com=[0 m +- 3 %, 0 m, 0 m]", "'+- 3 %' of a value of 0 is 0: write the uncertainty with a unit"),
    ("cranes.crane.sheave efficiency=99 % +- 2 %", "the range from 0.97 to 1.01 is not within 50 % to 100 %"),
    ("cranes.crane.falls=20 +- 1", "this value cannot be uncertain"),
    ("name=lift +- 3 %", "a name has letters"),
    ("samples=2 Hz +- 1 %", "a frequency is a setting of the run, not an input"),
    ("end=60 s +- 1 s", "a time is a setting of the run, not an input"),
    ("tolerance=1e-6 +- 3 %", "this value cannot be uncertain"),
]


@pytest.mark.parametrize(("setting", "name", "value", "kind", "sd"), TOLD)
def test_uncertainties_of_inputs_are_read_from_the_scene_file(
    setting: str, name: str, value: float, kind: str, sd: float
) -> None:
    (found,) = uncertain_inputs(load("lift", [setting]))
    assert (found.name, found.kind) == (name, kind)
    assert found.value == pytest.approx(value, rel=1e-15)
    assert found.sd == pytest.approx(sd, rel=1e-12)
    assert inputs(load("lift", [setting]), [name])[0].path == found.path


@pytest.mark.parametrize(("setting", "sentence"), REFUSED)
def test_invalid_uncertainties_are_refused_with_their_place(setting: str, sentence: str, tmp_path: Path) -> None:
    with pytest.raises(SceneError) as message:
        load("lift", [setting])
    assert sentence in str(message.value)
    key, _, value = setting.partition("=")
    if key == MASS:
        scene = tmp_path / "mine.yaml"
        scene.write_text(f"extends: lift\nblock:\n  mass: {value}\n")
        with pytest.raises(SceneError, match=r"mine.yaml:3:9: error: block.mass: ") as message:
            load(scene)
        assert sentence in str(message.value)


def test_a_run_uses_the_nominal_values_of_uncertain_inputs(tmp_path: Path) -> None:
    sets = ["end=3 s", "mechanism.bodies.load.mass=40 t", "mechanism.ropes.fall.length=40.5 m"]
    stated = ["end=3 s", "mechanism.bodies.load.mass=38..42 t", "mechanism.ropes.fall.length=40.5 m +- 20 mm"]
    plain, uncertain = load("tackle", sets), load("tackle", stated)
    assert [x.name for x in uncertain_inputs(uncertain)] == [s.partition("=")[0] for s in stated[1:]]
    first, second = (
        run(scene, tmp_path / f"{i}.mcap", in_process=True).digest for i, scene in enumerate((plain, uncertain))
    )
    assert first == second


def without_uncertainty(plan: Plan) -> Plan:
    limits = (replace(x, spread=0.0, adds=False, inputs="") for x in plan.limits)
    rows = (replace(x, factors=tuple(f for f in x.factors if f.name != "inputs")) for x in limits)
    return replace(plan, limits=tuple(rows))


def test_stating_the_uncertainties_of_inputs_changes_only_the_limits_of_the_plan() -> None:
    plain = load("lift", ["block.mass=300 t", "rig.sling.EA=445 MN"])
    for text in ("300 t +- 3 %", "290..310 t", "300 t sd 5000 kg"):
        stated = load("lift", [f"block.mass={text}", "rig.sling.EA=445 MN ± 10 %"])
        assert without_uncertainty(stated.plan) == without_uncertainty(plain.plan)


def test_uncertainties_that_appear_only_in_comments_or_free_text_are_not_read() -> None:
    stage = "actions.0.stage=20..30 t on the hooks"
    source = "limits={ropes: {crane.H1: {tension: 4 MN, source: 3 +- 1 tests}}}"
    scene = load("lift", [stage, source])
    assert scene.plan.actions[0].stage == "20..30 t on the hooks"
    assert scene.scene.limits.ropes["crane.H1"].source == "3 +- 1 tests"
    assert uncertain_inputs(scene) == []


def test_an_uncertainty_on_the_command_line_replaces_that_of_the_file() -> None:
    scene = load("lift", ["block.mass=300 t +- 3 %"])
    mass, com = uncertain_inputs(scene, ["block.mass sd 2 t", "block.com.x +- 0.2 m"])
    assert (mass.sd, com.sd, com.value) == (2e3, 0.1, 0.0)
    assert str(com) == "block.com.x 0.00 m +- 0.20 m"
    moved = varied(scene, [mass, com], [mass.value + mass.sd, com.sd])
    assert (cargo(moved.plan).mass, cargo(moved.plan).com) == (302e3, (0.1, 0.0, 0.0))
    assert [x.name for x in uncertain_inputs(moved)] == []  # what is varied is known


@pytest.mark.parametrize(
    ("given", "sentence"),
    [
        (["block.mass"], "write its uncertainty after it"),
        (["block.mass +- 3 kN"], "input block.mass: '+- 3 kN': 'kN' is not a unit of this quantity"),
        (["block.weight +- 3 %"], "input block.weight: there is no 'weight'"),
        (["block.mass +- 3 %", "block.mass +- 2 %"], "input block.mass: it is given twice"),
        (["block.com.x +- 3 %"], "'+- 3 %' of a value of 0 is 0"),
        (["samples +- 3 %"], "a frequency is a setting of the run"),
    ],
)
def test_invalid_uncertainties_on_the_command_line_are_refused(given: list[str], sentence: str) -> None:
    with pytest.raises(SceneError) as message:
        uncertain_inputs(load("lift"), given)
    assert sentence in str(message.value)
