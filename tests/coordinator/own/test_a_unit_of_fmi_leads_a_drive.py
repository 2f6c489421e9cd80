"""A unit of FMI as a model of a scene: signals are its inputs, set-points its outputs, its step is the period."""

from __future__ import annotations

import sys
from pathlib import Path

import fmpy
import pytest
from heavylift.coordinator.record import play
from heavylift.coordinator.run import run
from heavylift.kernel import SceneError
from heavylift.nodes.devs import Simulator, ms
from heavylift.nodes.models import build_one
from heavylift.nodes.models.parts import Sample, SetPoint
from heavylift.nodes.scene import LoadedScene
from pythonfmu import FmuBuilder
from scenes import SLEDGE, scene

GOVERNOR = """\
models:
  governor:
    model: Governor.fmu
    period: 20 ms
    signals: {x: position of rail}
    orders: {speed: pusher}
    parameters: {goal: 300 mm}
"""


@pytest.fixture(scope="module")
def governed(folder: Path, tmp_path_factory: pytest.TempPathFactory) -> LoadedScene:
    FmuBuilder.build_FMU(Path(__file__).with_name("governor.py"), dest=folder)
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("HEAVYLIFT_CACHE", str(tmp_path_factory.mktemp("cache")))
        yield scene(folder, SLEDGE, GOVERNOR, sets=("end=3 s",))


def stepped(file: Path, heard: list[float]) -> list[float]:
    """What FMPy alone gets of the unit, which hears these values, one before each step of 20 ms."""
    message = fmpy.read_model_description(str(file))
    number = {v.name: v.valueReference for v in message.modelVariables}
    one = fmpy.instantiate_fmu(fmpy.extract(str(file)), message, "CoSimulation")
    one.setupExperiment(startTime=0.0)
    one.setReal([number["goal"]], [0.3])
    one.enterInitializationMode()
    one.exitInitializationMode()
    found = [one.getReal([number["speed"]])[0]]
    for i, x in enumerate(heard):
        one.setReal([number["x"]], [x])
        one.doStep(i * 0.02, 0.02)
        found.append(one.getReal([number["speed"]])[0])
    return found


def test_an_fmu_gives_the_same_results_in_heavylift_and_in_fmpy(governed: LoadedScene, folder: Path) -> None:
    found = play(governed.plan)
    heard = [(e.t, e.value.value) for e in found.events if isinstance(e.value, Sample)]
    text = [(e.t, e.value.value) for e in found.events if isinstance(e.value, SetPoint)]
    assert [t for t, _ in heard] == [t for t, _ in text] == [ms(20) * i for i in range(150)]
    assert [x for _, x in text] == stepped(folder / "Governor.fmu", [x for _, x in heard[:-1]])
    assert heard[-1][1] == pytest.approx(0.3 * (1 - 2.718281828 ** (-0.5 * 2.98)), abs=0.02), "x' = (goal - x) / 2"


def test_the_communication_step_of_an_fmu_is_the_lookahead_of_its_ports(governed: LoadedScene) -> None:
    simulator = Simulator(build_one(governed.plan, "governor"))
    simulator.start()
    assert simulator.lookahead == {"governor.speed": ms(20)}


@pytest.mark.large
def test_a_run_with_an_fmu_in_a_process_of_its_own_has_the_same_digest(governed: LoadedScene, tmp_path: Path) -> None:
    assert run(governed, tmp_path / "apart.mcap").digest == play(governed.plan).digest


def test_missing_capabilities_of_an_fmu_are_reported_by_name(
    governed: LoadedScene, folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for sets, sentence in (
        (
            "models.governor.signals={y: position of rail}",
            "Governor.fmu has no variable y; it has x, goal, gain, speed",
        ),
        ("models.governor.orders={pace: pusher}", "Governor.fmu has no variable pace; it has x, goal, gain, speed"),
        ("models.governor.parameters={goal: high}", "the parameter 'goal' of an FMU must be a number, true or false"),
    ):
        with pytest.raises(SceneError, match=sentence):
            scene(folder, SLEDGE, GOVERNOR, sets=(sets,))
    monkeypatch.setitem(sys.modules, "fmpy", None)
    with pytest.raises(SceneError, match=r"an FMU needs FMPy: pip install 'heavylift\[fmi\]'"):
        scene(folder, SLEDGE, GOVERNOR)
