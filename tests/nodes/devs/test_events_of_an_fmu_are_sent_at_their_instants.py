"""Reference FMUs of FMI 3 with event mode in a DEVS network: each event is sent when it occurs, as FMPy plays it."""

from pathlib import Path

import fmpy
import pytest
from heavylift.kernel import allowed
from heavylift.nodes import Fmu, drive
from heavylift.nodes.devs import Simulator, Tag, ms, seconds

FMUS = Path(__file__).parents[2] / "data" / "fmus"
UNTIL = 2.6
OUTPUTS = {"BouncingBall": ["h", "v"], "Stair": ["counter"]}
pytestmark = pytest.mark.skipif(fmpy.platform != "linux64", reason="the reference FMUs are built for 64-bit Linux")


@pytest.fixture(autouse=True)
def trusted(tmp_path, monkeypatch):
    monkeypatch.setenv("HEAVYLIFT_CACHE", str(tmp_path / "cache"))
    with allowed([str(FMUS)]):
        yield


def by_fmpy(name: str, step: float) -> dict[Tag, tuple[float, ...]]:
    """The outputs at each instant, after its events."""
    rows = fmpy.simulate_fmu(
        str(FMUS / f"{name}.fmu"), fmi_type="CoSimulation", stop_time=3.0, output_interval=step,
        use_event_mode=True, early_return_allowed=True, record_events=True, output=OUTPUTS[name],
    )  # fmt: skip
    return {Tag(seconds(float(t))): tuple(map(float, values)) for t, *values in rows.tolist() if t < UNTIL}


@pytest.mark.parametrize("name", ["BouncingBall", "Stair"])
@pytest.mark.parametrize("step", [0.5, 0.05])
def test_outputs_are_sent_at_every_event_however_many_lie_in_one_step(name, step):
    model = Fmu("unit", FMUS / f"{name}.fmu", seconds(step), OUTPUTS[name])
    ours = {tag: tuple(x for _, x in sent.values) for tag, _, sent in drive(model, [], until=seconds(UNTIL))}
    theirs = by_fmpy(name, step)
    assert ours.keys() == theirs.keys()
    assert all(ours[tag] == pytest.approx(theirs[tag], abs=1e-12) for tag in theirs)


def test_an_fmu_continues_from_a_snapshot_between_an_event_and_the_end_of_its_step():
    def played(kept: bytes | None = None):
        simulator = Simulator(Fmu("ball", FMUS / "BouncingBall.fmu", ms(500), ["h", "v"]))
        simulator.start()
        if kept is not None:
            simulator.restore(kept)
        return simulator

    first = played()
    first.run(ms(460))
    kept = first.snapshot()
    first.run(ms(2500))
    other = played(kept)
    other.run(ms(2500))
    assert other.outputs() == first.outputs()
