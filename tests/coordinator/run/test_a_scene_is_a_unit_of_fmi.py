"""A scene exported as a unit of FMI 2.0 and played by FMPy: at communication points it is the native run to the bit."""

from __future__ import annotations

from pathlib import Path

import fmpy
import numpy as np
import pytest
from fmpy.fmi1 import FMICallException
from fmpy.fmi2 import fmi2LastSuccessfulTime
from fmpy.validation import validate_fmu
from heavylift.coordinator.commands import app
from heavylift.coordinator.live import TimedCommand
from heavylift.coordinator.record import Played, play
from heavylift.coordinator.run.units import SteppableRun, export
from heavylift.kernel import ModelError
from heavylift.nodes.devs import Tag, encode, seconds
from heavylift.nodes.models.parts import OperatorCommand
from heavylift.nodes.scene import load, spoken
from msgspec import msgpack
from typer.testing import CliRunner

STEP, WORDS = 0.5, "loader-2: lock"
SETS = ("end=12 s", "samples=2 Hz")
ENDLESS = """heavylift: 1
name: slider
mechanism:
  bodies: {sledge: {mass: 1 t}}
  joints: {rail: {type: prismatic, child: sledge, axis: [1, 0, 0]}}
  drives: {motor: {joint: rail, type: speed, damping: 50 kN s/m, ramp: 1 m/s2}}
actions:
  - motor: drive 1 m/s by 2 m
"""
OUTPUTS = {
    "tension.crane.H1": "rope/tension/crane.H1",
    "tension.loader-1.sling-1": "rope/tension/loader-1.sling-1",
    "pose.block.z": "pose/block/z",
    "pose.block.qw": "pose/block/qw",
    "pose.crane.upper.y": "pose/crane.upper/y",
}


def played(file: Path, orders: dict[int, str]) -> tuple[dict[str, list[float]], list[str]]:
    """Outputs after each step by FMPy, and the answers; a command is set before the step of its number."""
    message = fmpy.read_model_description(str(file))
    number = {v.name: v.valueReference for v in message.modelVariables}
    assert {v.name for v in message.modelVariables if v.causality == "input"} == {"command"}
    unit = fmpy.instantiate_fmu(fmpy.extract(str(file)), message, "CoSimulation")
    unit.setupExperiment(startTime=0.0)
    unit.enterInitializationMode()
    unit.exitInitializationMode()
    found: dict[str, list[float]] = {name: [] for name in (*OUTPUTS, "peak.crane.H1")}
    answers = []
    for k in range(24):
        unit.setString([number["command"]], [orders.get(k, "")])
        unit.doStep(k * STEP, STEP)
        for name, values in found.items():
            values.append(unit.getReal([number[name]])[0])
        answers.append(unit.getString([number["answer"]])[0].decode())
    unit.terminate()
    unit.freeInstance()
    return found, answers


def native(orders: dict[int, str]) -> tuple[Played, dict[str, np.ndarray]]:
    """The run, and its columns at the ends of all steps but the last, before what happens there."""
    lift = load("lift", SETS)
    answer = {k: encode(OperatorCommand(text, msgpack.encode(spoken(lift, text)))) for k, text in orders.items()}
    run = play(lift.plan, commands=[TimedCommand(Tag(seconds(k * STEP)), words) for k, words in answer.items()])
    at = np.searchsorted(run.times, [seconds(k * STEP) for k in range(1, 24)])
    names = [f"{c.topic}/{name}" for c in run.layout.channels for name in c.names]
    return run, {name: run.rows[at, names.index(signal)] for name, signal in OUTPUTS.items()}


@pytest.mark.large
@pytest.mark.parametrize("orders", [{}, {5: WORDS}], ids=["undisturbed", "with a command"])
def test_a_native_run_and_its_fmu_give_the_same_values(tmp_path: Path, orders: dict[int, str]) -> None:
    file = tmp_path / "lift.fmu"
    sets = [word for setting in SETS for word in ("--set", setting)]
    message = CliRunner().invoke(app, ["export-fmu", "lift", "-o", str(file), *sets])
    assert message.output == f"wrote {file}\n", message.exception
    assert validate_fmu(str(file)) == []
    found, answers = played(file, {**orders, 9: "crane H9: hoist 3 m/min by 1 m"})
    run, wanted = native(orders)
    for name, values in wanted.items():
        apart = [k + 1 for k in range(23) if found[name][k] != values[k]]
        assert {*apart} <= {*orders}, "the native run ends a step where a command is given"
        assert found[name][:-1] == pytest.approx(values.tolist(), rel=1e-9, abs=1e-9)
    assert found["peak.crane.H1"][-1] == run.peaks["crane.H1"].tension
    assert not any(answers[:9])
    assert answers[9].startswith("command: there is no 'crane H9' to give an order to")


def test_fmpy_validates_the_fmu_and_simulates_it_twice(tmp_path: Path) -> None:
    file = str(export(load("arm", ("end=1 s",)), tmp_path / "arm.fmu"))
    assert validate_fmu(file) == []
    message, folder = fmpy.read_model_description(file), fmpy.extract(file)
    z = next(v.valueReference for v in message.modelVariables if v.name == "pose.link-4.z")
    found = []
    for _ in range(3):
        unit = fmpy.instantiate_fmu(folder, message, "CoSimulation")
        unit.setupExperiment(startTime=0.0)
        unit.enterInitializationMode()
        unit.exitInitializationMode()
        unit.doStep(0.0, 0.5)
        found += unit.getReal([z])
        unit.terminate()
        unit.freeInstance()
    assert found == [found[0]] * 3 != [0.0] * 3


def test_an_fmu_keeps_its_last_values_after_the_run() -> None:
    run = SteppableRun(load("pendulum", ("end=1 s",)).plan, lambda text: b"")
    run.go(seconds(1))
    last = run["pose/load/qy"]
    for late in seconds(1) + 1, seconds(3):
        with pytest.raises(ModelError, match=r"s is too long: the scene ends at 1 s"):
            run.go(late)
    run.go(seconds(1))
    assert run["pose/load/qy"] == last


@pytest.mark.large(beyond=4)
@pytest.mark.parametrize("name", ["damper", "lift", "girder", "sling-break", "jib", "in-turn", "floating", "tandem"])
def test_communication_steps_that_end_at_events_change_no_bit_of_an_fmu_run(name: str) -> None:
    """Also where models sample signals, and where islands run ahead of each other."""
    plan, r = load(name, ("end=15 s",)).plan, np.random.default_rng(len(name))
    whole, stepped = SteppableRun(plan, lambda text: b""), SteppableRun(plan, lambda text: b"")
    whole.go(seconds(15))
    met: list[int] = []
    ends = sorted({*(seconds(t) for t in r.uniform(0.0, 15.0, 9)), *(seconds(0.5 * k) for k in range(1, 31))})
    while ends:
        if stepped.go(ends[0], events=True):
            stepped.settle()
            met.append(stepped.now)
        else:
            ends.pop(0)
    assert met == sorted({event.t for event in play(plan).events} - {0})
    assert stepped.events == whole.events
    assert [stepped[name] for name in stepped.columns] == [whole[name] for name in whole.columns]


def test_an_fmu_of_a_scene_without_a_stated_end_ends_with_its_actions(tmp_path: Path) -> None:
    (tmp_path / "arm.yaml").write_text(ENDLESS)
    scene = load(tmp_path / "arm.yaml")
    assert scene.plan.end is None
    end = int(max(play(scene.plan).times))
    run = SteppableRun(scene.plan, lambda text: b"")
    run.go(end)
    with pytest.raises(ModelError, match=rf"the scene ends at {end / 1e9:g} s"):
        run.go(end + seconds(1))
    with pytest.raises(ModelError, match="the scene ends"):
        SteppableRun(scene.plan, lambda text: b"").go(2 * end)


@pytest.mark.parametrize("stop", [None, 0.7, 5.0])
def test_an_fmu_discards_communication_steps_beyond_its_end_or_back_in_time(tmp_path: Path, stop: float | None) -> None:
    file = str(export(load("pendulum", ("end=1 s",)), tmp_path / "pendulum.fmu"))
    message = fmpy.read_model_description(file)
    default = message.defaultExperiment
    assert (float(default.startTime), float(default.stopTime)) == (0.0, 1.0)
    assert float(default.tolerance) == load("pendulum").plan.tolerance
    unit = fmpy.instantiate_fmu(fmpy.extract(file), message, "CoSimulation")
    unit.setupExperiment(startTime=0.0, stopTime=stop)
    unit.enterInitializationMode()
    unit.exitInitializationMode()
    end = min(1.0, stop or 1.0)
    x, angles, t = next(v.valueReference for v in message.modelVariables if v.name == "pose.load.qy"), [], 0.0
    for h in [0.01] * round(end / 0.01):
        unit.doStep(t, h)
        angles += unit.getReal([x])
        t += h
    assert len({*angles}) == len(angles)
    for start, h, done in (t, 0.0, True), (t, 0.1, False), (t, 1e-6, False), (0.2, 0.1, False), (t, 0.0, True):
        if done:
            unit.doStep(start, h)
        else:
            with pytest.raises(FMICallException, match="discard"):
                unit.doStep(start, h)
            assert unit.getRealStatus(fmi2LastSuccessfulTime) == start
        assert unit.getReal([x]) == angles[-1:]
    unit.terminate()
    unit.freeInstance()


def test_fmpy_simulates_an_fmu_up_to_its_default_end(tmp_path: Path) -> None:
    found = fmpy.simulate_fmu(str(export(load("pendulum", ("end=1 s",)), tmp_path / "pendulum.fmu")))
    assert (found["time"][0], found["time"][-1], len(found)) == (0.0, 1.0, 21)
    run = play(load("pendulum", ("end=1 s", "samples=20 Hz")).plan)
    names = [f"{c.topic}/{name}" for c in run.layout.channels for name in c.names]
    assert found["pose.load.qy"] == pytest.approx(run.rows[:, names.index("pose/load/qy")], rel=1e-8)
