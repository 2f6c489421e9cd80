"""A unit of FMI 3 with event mode in a DEVS network: each event is sent when it occurs, by closed form and by FMPy."""

import shutil
import subprocess
import zipfile
from itertools import accumulate
from math import ceil, sqrt
from pathlib import Path

import fmpy
import pytest
from heavylift.kernel import allowed
from heavylift.nodes import Fmu, drive
from heavylift.nodes.devs import Simulator, ms, seconds

HERE = Path(__file__).parent
G, E, UNTIL = 9.81, 0.8, 2.6
MECHANICS = ["height", "speed", "bounces"]
OUTPUTS = ["seconds", *MECHANICS]
BALL = """<fmiModelDescription fmiVersion="3.0" modelName="Ball" instantiationToken="ball">
  <CoSimulation modelIdentifier="ball" canGetAndSetFMUState="true" canSerializeFMUState="true" hasEventMode="true"
    canHandleVariableCommunicationStepSize="true" mightReturnEarlyFromDoStep="true"/>
  <ModelVariables>
    <Float64 name="time" valueReference="9" causality="independent" variability="continuous"/>
    <Float64 name="seconds" valueReference="0" causality="output" variability="discrete"/>
    <Float64 name="height" valueReference="1" causality="output"/>
    <Float64 name="speed" valueReference="2" causality="output"/>
    <Int32 name="bounces" valueReference="4" causality="output"/>
  </ModelVariables>
  <ModelStructure/>
</fmiModelDescription>"""


@pytest.fixture(scope="module")
def ball(tmp_path_factory: pytest.TempPathFactory) -> Path:
    if not (compiler := shutil.which("cc")):
        pytest.skip("NO C COMPILER HERE: a unit of FMI 3.0 was neither built nor stepped")
    folder = tmp_path_factory.mktemp("ball")
    library = folder / "ball.so"
    subprocess.run([compiler, "-shared", "-fPIC", "-w", HERE / "ball.c", "-o", library, "-lm"], check=True)
    with zipfile.ZipFile(folder / "Ball.fmu", "w") as archive:
        archive.writestr("modelDescription.xml", BALL)
        archive.write(library, f"binaries/{fmpy.platform_tuple}/ball.so")
    return folder / "Ball.fmu"


@pytest.fixture(autouse=True)
def trusted(ball, tmp_path, monkeypatch):
    monkeypatch.setenv("HEAVYLIFT_CACHE", str(tmp_path / "cache"))
    with allowed([str(ball.parent)]):
        yield


def bounces() -> list[float]:
    """Their times [s], by closed form."""
    first = sqrt(2.0 / G)
    return list(accumulate([first, *(2.0 * first * E**n for n in range(1, 5))]))


@pytest.mark.parametrize("step", [0.8, 0.05])
def test_an_fmu_sends_outputs_at_every_event_even_if_several_lie_in_one_step(ball, step):
    sent = drive(Fmu("ball", ball, seconds(step), OUTPUTS), [], until=seconds(UNTIL))
    ours = {tag.t: dict(message.values) for tag, _, message in sent}
    grid = {seconds(step) * n for n in range(ceil(UNTIL / step))}
    want = [ceil(t * 1e9 - 1e-3) for t in bounces() if t < UNTIL]
    assert sorted(ours) == sorted({*grid, *want, seconds(1.0), seconds(2.0)})
    for n, t in enumerate(want, 1):
        assert ours[t]["bounces"] == n
        assert ours[t]["height"] == 0.0
        assert ours[t]["speed"] == pytest.approx(sqrt(2.0 * G) * E**n, rel=1e-12)
    assert [ours[seconds(t)]["seconds"] for t in (1.0, 2.0)] == [1.0, 2.0]


def test_an_fmu_with_events_gives_the_outputs_that_fmpy_computes(ball):
    sent = drive(Fmu("ball", ball, ms(500), MECHANICS), [], until=seconds(UNTIL))
    rows = fmpy.simulate_fmu(
        str(ball), fmi_type="CoSimulation", stop_time=3.0, output_interval=0.5, output=MECHANICS,
        use_event_mode=True, early_return_allowed=True, record_events=True,
    )  # fmt: skip
    theirs = {ceil(float(row["time"]) * 1e9 - 1e-3): [float(row[name]) for name in MECHANICS] for row in rows}
    assert len(sent) > 8
    for tag, _, message in sent:
        assert [x for _, x in message.values] == pytest.approx(theirs[tag.t], abs=1e-12)


def test_an_fmu_continues_from_a_snapshot_between_an_event_and_the_end_of_its_step(ball):
    def played(kept: bytes | None = None):
        simulator = Simulator(Fmu("ball", ball, ms(500), OUTPUTS))
        simulator.start()
        if kept is not None:
            simulator.restore(kept)
        return simulator

    first = played()
    first.run(ms(460))
    kept = first.snapshot()
    first.run(ms(2300))
    other = played(kept)
    other.run(ms(2300))
    assert other.outputs() == first.outputs()
