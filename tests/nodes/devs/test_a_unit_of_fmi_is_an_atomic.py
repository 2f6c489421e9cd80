"""A co-simulation unit in a DEVS network: inputs held, a fixed step as lookahead, the same digest however it is run."""

from __future__ import annotations

import os
import shutil
import signal
import subprocess
import zipfile
from pathlib import Path

import fmpy
import pytest
from heavylift import run_models
from heavylift.coordinator.run import RunObserver
from heavylift.coordinator.supervision import failover
from heavylift.kernel import ModelError, allowed
from heavylift.nodes import Fmu, Signals, drive
from heavylift.nodes.devs import Event, Simulator, Tag, ms
from pythonfmu import FmuBuilder

HERE = Path(__file__).parent
STATE = ("canGetAndSetFMUstate", "canSerializeFMUstate")

SPRING = """<fmiModelDescription fmiVersion="3.0" modelName="Spring" instantiationToken="spring">
  <CoSimulation modelIdentifier="spring" canGetAndSetFMUState="true" canSerializeFMUState="true"/>
  <ModelVariables>
    <Float64 name="time" valueReference="9" causality="independent" variability="continuous"/>
    <Float64 name="f" valueReference="0" causality="input" start="0"/>
    <Float64 name="x" valueReference="1" causality="output"/>
    <Int32 name="steps" valueReference="4" causality="output"/>
    <Float64 name="m" valueReference="3" causality="parameter" variability="tunable" start="1"/>
    <Float64 name="row" valueReference="2" causality="local"><Dimension start="2"/></Float64>
  </ModelVariables>
  <ModelStructure><Output valueReference="1"/><Output valueReference="4"/></ModelStructure>
</fmiModelDescription>"""


def of_fmi_3(folder: Path) -> None:
    """The same spring, in C."""
    if not (compiler := shutil.which("cc")):
        pytest.skip("NO C COMPILER HERE: a unit of FMI 3.0 was neither built nor stepped")
    subprocess.run([compiler, "-shared", "-fPIC", "-w", HERE / "spring.c", "-o", folder / "spring.so"], check=True)
    with zipfile.ZipFile(folder / "Spring.fmu", "w") as archive:
        archive.writestr("modelDescription.xml", SPRING)
        archive.write(folder / "spring.so", f"binaries/{fmpy.platform_tuple}/spring.so")


@pytest.fixture(scope="module", params=["stateless", "with state", "FMI 3.0"])
def unit(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory):
    folder, keeps = tmp_path_factory.mktemp("units"), request.param != "stateless"
    if request.param == "FMI 3.0":
        of_fmi_3(folder)
    else:
        FmuBuilder.build_FMU(HERE / "spring.py", dest=folder, **dict.fromkeys(STATE, keeps))
    before = os.environ.get("HEAVYLIFT_CACHE")
    os.environ["HEAVYLIFT_CACHE"] = str(tmp_path_factory.mktemp("cache"))
    with allowed([str(folder)]):
        yield folder / "Spring.fmu", keeps
    os.environ.pop("HEAVYLIFT_CACHE")
    if before is not None:
        os.environ["HEAVYLIFT_CACHE"] = before


def stepped(file: Path, pushes: dict[int, float], steps: int) -> list[float]:
    """x after each step of FMPy alone, the input changed at the begin of these steps."""
    message = fmpy.read_model_description(str(file))
    number = {v.name: v.valueReference for v in message.modelVariables}
    one = fmpy.instantiate_fmu(fmpy.extract(str(file)), message, "CoSimulation")
    second = message.fmiVersion == "2.0"
    get, put = (one.getReal, one.setReal) if second else (one.getFloat64, one.setFloat64)
    if second:
        one.setupExperiment(startTime=0.0)
    put([number["m"]], [0.5])
    one.enterInitializationMode()
    one.exitInitializationMode()
    found = [get([number["x"]])[0]]
    for i in range(steps):
        if i in pushes:
            put([number["f"]], [pushes[i]])
        one.doStep(i * 0.01, 0.01)
        found.append(get([number["x"]])[0])
    return found


def test_an_input_to_an_fmu_acts_from_the_first_step_that_begins_at_or_after_it(unit) -> None:
    inputs = [(ms(20), "u", Signals((("f", 3.0),))), (ms(33), "u", Signals((("f", -1.0),)))]
    text = drive(Fmu("spring", unit[0], ms(10), ["x", "steps"], {"m": 0.5}), inputs, until=ms(101))
    assert [tag for tag, _, _ in text] == [Tag(ms(10 * i)) for i in range(11)]
    values = [dict(signals.values) for _, _, signals in text]
    assert [at["x"] for at in values] == stepped(unit[0], {2: 3.0, 4: -1.0}, 10)
    assert [at["steps"] for at in values] == list(range(11))


def test_the_communication_step_of_an_fmu_is_the_lookahead_of_the_model(unit) -> None:
    simulator = Simulator(Fmu("spring", unit[0], ms(10), ["x"]))
    simulator.start()
    assert simulator.lookahead == {"spring.y": ms(10)}


def test_an_fmu_continues_from_a_snapshot_or_reports_that_it_does_not_support_snapshots(unit) -> None:
    file, keeps = unit
    simulator = Simulator(Fmu("spring", file, ms(10), ["x"]))
    simulator.start()
    simulator.run(ms(55))
    if not keeps:
        with pytest.raises(
            ModelError, match=r"spring: no snapshot can be taken \(Spring.fmu does not support saving its state\)"
        ):
            simulator.snapshot()
        return
    kept = simulator.snapshot()
    simulator.run(ms(205))
    truth = simulator.outputs()
    other = Simulator(Fmu("spring", file, ms(10), ["x"]))
    other.start()
    other.restore(kept)
    other.run(ms(205))
    assert other.outputs() == truth


@pytest.mark.large(beyond=1)
@pytest.mark.parametrize("late", [0, ms(3)])
def test_the_digest_of_a_run_with_an_fmu_does_not_depend_on_its_processes_or_on_lost_processes(
    unit, monkeypatch, late: int
) -> None:
    monkeypatch.syspath_prepend(HERE)
    monkeypatch.setattr(failover, "KEEP_s", 0.0)
    monkeypatch.setattr(failover, "KEEP_GRANTS", 4)
    build = f"{HERE}/unit_network.py:network({str(unit[0])!r}, {late})"
    message: list[str] = []
    crews: list[dict[str, int]] = []

    class Killing(RunObserver):
        def say(self, sentence: str) -> None:
            message.append(sentence)

        def event(self, event: Event) -> None:
            if event.t >= ms(500) and crews:
                os.kill(crews.pop()["spring"], signal.SIGKILL)

    began = failover.Processes.start
    monkeypatch.setattr(
        failover.Processes, "start", lambda crew, *more: (began(crew, *more), crews.append(crew.pids))[0]
    )
    shared = run_models(build, until=1.001, watch=Killing())
    assert shared.digest == run_models(build, until=1.001, in_process=True).digest
    assert any(sentence.startswith("node spring is replaced") for sentence in message)
    assert any("replayed from the start if it were lost: " in sentence for sentence in message) is not unit[1]


def test_a_faulty_fmu_is_reported_with_the_name_of_its_file(unit, tmp_path: Path) -> None:
    other = tmp_path / "other.fmu"
    other.write_bytes(b"no archive")
    with pytest.raises(ModelError, match=rf"^p: '{other}' is code in a folder that you have not trusted"):
        Fmu("p", other, ms(1), ["x"])
    with allowed([str(tmp_path)]), pytest.raises(ModelError, match=r"^p: .* cannot be read as an FMU"):
        Fmu("p", other, ms(1), ["x"])
    with pytest.raises(ModelError, match=r"^p: Spring.fmu has no variable z; it has f, x, steps, m$"):
        Fmu("p", unit[0], ms(1), ["z"])
    with pytest.raises(ModelError, match="must be a positive int in ns"):
        Fmu("p", unit[0], 0.01, ["x"])  # type: ignore[arg-type]
    for name, sentence in {
        "g": "Spring.fmu has no variable g",
        "x": "x of Spring.fmu is not an input but out",
    }.items():
        with pytest.raises(ModelError, match=rf"^p at \(0.003 s, 0\): p: {sentence}"):
            drive(Fmu("p", unit[0], ms(1), ["x"]), [(ms(3), "u", Signals(((name, 1.0),)))], until=ms(9))
    with pytest.raises(
        ModelError, match=r"^p at \(0 s, 0\): p: steps of Spring.fmu is of type Int\w+, and cannot be 0.5$"
    ):
        drive(Fmu("p", unit[0], ms(1), ["x"], {"steps": 0.5}), [], until=ms(9))


def test_an_fmu_of_fmi_3_may_end_early_and_may_have_arrays(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("HEAVYLIFT_CACHE", str(tmp_path / "cache"))
    of_fmi_3(tmp_path)
    with allowed([str(tmp_path)]):
        with pytest.raises(ModelError, match=r"^p: variable row of Spring.fmu is an array, not a number$"):
            Fmu("p", tmp_path / "Spring.fmu", ms(1), ["row"])
        with pytest.raises(
            ModelError, match=r"^p at \(0.004 s, 0\): p: Spring.fmu asks for the end of the simulation at 0.005 s"
        ):
            drive(Fmu("p", tmp_path / "Spring.fmu", ms(1), ["x"]), [(ms(4), "u", Signals((("f", 101.0),)))], ms(9))
