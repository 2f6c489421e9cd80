"""A scene exported as a unit of FMI 2.0 and played by FMPy: at communication points it is the native run to the bit."""

from __future__ import annotations

from pathlib import Path

import fmpy
import numpy as np
import pytest
from fmpy.validation import validate_fmu
from heavylift.coordinator.commands import app
from heavylift.coordinator.live.commands import Given
from heavylift.coordinator.run.in_memory import Played, play
from heavylift.coordinator.run.unit import Stepped, export
from heavylift.nodes.devs import Tag, encode, seconds
from heavylift.nodes.models.parts.messages import OperatorCommand
from heavylift.nodes.scene import load
from heavylift.nodes.scene.operator_command import spoken
from msgspec import msgpack
from typer.testing import CliRunner

STEP, WORDS = 0.5, "loader-2: lock"
SETS = ("end=12 s", "samples=2 Hz")
OUTPUTS = {
    "tension.crane.H1": "rope/tension/crane.H1",
    "tension.loader-1.sling-1": "rope/tension/loader-1.sling-1",
    "pose.block.z": "pose/block/z",
    "pose.block.qw": "pose/block/qw",
    "pose.crane.upper.y": "pose/crane.upper/y",
}


def played(file: Path, orders: dict[int, str]) -> tuple[dict[str, list[float]], list[str]]:
    """Outputs after each step by FMPy, and the answers; a command is set before the step of its number."""
    told = fmpy.read_model_description(str(file))
    number = {v.name: v.valueReference for v in told.modelVariables}
    assert {v.name for v in told.modelVariables if v.causality == "input"} == {"command"}
    unit = fmpy.instantiate_fmu(fmpy.extract(str(file)), told, "CoSimulation")
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
    said = {k: encode(OperatorCommand(text, msgpack.encode(spoken(lift, text)))) for k, text in orders.items()}
    run = play(lift.plan, commands=[Given(Tag(seconds(k * STEP)), words) for k, words in said.items()])
    at = np.searchsorted(run.times, [seconds(k * STEP) for k in range(1, 24)])
    names = [f"{c.topic}/{name}" for c in run.layout.channels for name in c.names]
    return run, {name: run.rows[at, names.index(signal)] for name, signal in OUTPUTS.items()}


@pytest.mark.large
@pytest.mark.parametrize("orders", [{}, {5: WORDS}], ids=["undisturbed", "with a command"])
def test_it_is_the_native_run(tmp_path: Path, orders: dict[int, str]) -> None:
    file = tmp_path / "lift.fmu"
    sets = [word for setting in SETS for word in ("--set", setting)]
    told = CliRunner().invoke(app, ["export-fmu", "lift", "-o", str(file), *sets])
    assert told.output == f"wrote {file}\n", told.exception
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


def test_fmpy_finds_no_fault_with_it_and_has_one_after_the_other(tmp_path: Path) -> None:
    file = str(export(load("arm", ("end=1 s",)), tmp_path / "arm.fmu"))
    assert validate_fmu(file) == []
    told, folder = fmpy.read_model_description(file), fmpy.extract(file)
    z = next(v.valueReference for v in told.modelVariables if v.name == "pose.link-4.z")
    found = []
    for _ in range(3):
        unit = fmpy.instantiate_fmu(folder, told, "CoSimulation")
        unit.setupExperiment(startTime=0.0)
        unit.enterInitializationMode()
        unit.exitInitializationMode()
        unit.doStep(0.0, 0.5)
        found += unit.getReal([z])
        unit.terminate()
        unit.freeInstance()
    assert found == [found[0]] * 3 != [0.0] * 3


def test_it_stays_as_it_was_when_the_run_is_over() -> None:
    run = Stepped(load("pendulum", ("end=1 s",)).plan, lambda text: b"")
    run.go(seconds(1))
    last = run["pose/load/qy"]
    run.go(seconds(3))
    assert run["pose/load/qy"] == last
