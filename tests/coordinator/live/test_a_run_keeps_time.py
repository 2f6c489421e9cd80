"""By the clock nothing is granted early, what is late is reported, and the run is the same run at any rate.

The clock is ours: it moves when the run rests, and by what a test adds to it.
"""

from pathlib import Path
from threading import Event as Alarm

import pytest
from heavylift.coordinator.live import Lateness, Pace, RealTime
from heavylift.coordinator.run import run
from heavylift.kernel import ProtocolError
from heavylift.nodes.devs import FOREVER, Event, Tag, seconds
from heavylift.nodes.scene import parse
from heavylift.recordings import Recording
from running import said
from sledge import SLEDGE

ROUNDING_s = 1e-5  # of sums of rests, of which none is shorter than a microsecond


class Clock(RealTime):
    """Real time by a clock of our own, which oversleeps a little."""

    def __init__(self, rate: float, oversleeps: float = 0.0) -> None:
        super().__init__(rate, lambda: self.time)
        self.time, self.oversleeps = 100.0, oversleeps
        self.granted_at: list[tuple[float, int]] = []

    def rest(self, alarm: Alarm, seconds: float) -> None:
        self.time += seconds + self.oversleeps

    def granted(self, first: Tag) -> None:
        super().granted(first)
        self.granted_at.append((self.time - 100.0, first.t))


def test_a_run_in_real_time_waits_until_the_clock_has_passed_the_time_of_an_event() -> None:
    clock = Clock(2.0)
    assert clock.horizon(Tag(0)) == Tag(0)
    assert clock.wait(Tag(seconds(3.0) - 1)) == pytest.approx(1.5, abs=1e-12)
    clock.time += 1.5
    assert clock.horizon(Tag(0)) == Tag(seconds(3.0))
    assert clock.wait(Tag(seconds(3.0) - 1)) == 0.0
    assert clock.wait(FOREVER) == float("inf")


def test_the_lateness_of_a_real_time_run_is_measured_and_a_pause_stops_its_clock() -> None:
    clock = Clock(1.0)
    clock.horizon(Tag(0))
    for late in (0.0, 0.002, 0.1):
        clock.time = 101.0 + late
        clock.granted(Tag(seconds(1.0) - 1))
    clock.hold()
    clock.time += 1000.0
    clock.go_on(Tag(seconds(1.0)))
    assert clock.horizon(Tag(0)) == Tag(seconds(1.0))
    clock.go_on(Tag(seconds(7.0)))  # it goes on already
    assert clock.horizon(Tag(0)) == Tag(seconds(1.0))
    message = clock.lateness
    assert message is not None
    assert message == pytest.approx(Lateness(3, 0.1, 0.034, 1 / 3), abs=ROUNDING_s)
    assert str(message) == "latest 100 ms late, 34 ms in the mean, 33.3% of 3 rounds more than 10 ms"


@pytest.mark.parametrize("rate", [0.0, -1.0, float("nan"), float("inf")])
def test_a_real_time_rate_must_be_positive_and_finite(rate: float) -> None:
    with pytest.raises(ProtocolError, match=f"^--rate {rate:g}: a rate must be positive and finite; 1 is real time$"):
        RealTime(rate)


def test_the_rate_of_a_real_time_run_changes_no_event_and_no_event_is_sent_before_its_time(tmp_path: Path) -> None:
    plain = run(parse(SLEDGE), tmp_path / "plain.mcap", True)
    assert plain.lateness is None
    for rate, oversleeps in ((1.0, 0.0), (4.0, 0.025)):
        clock = Clock(rate, oversleeps)
        paced = run(parse(SLEDGE), tmp_path / "paced.mcap", True, pace=clock)
        assert (paced.digest, paced.sim_s) == (plain.digest, plain.sim_s)
        assert all(at >= t * 1e-9 / rate - ROUNDING_s for at, t in clock.granted_at)
        assert paced.lateness is not None
        assert paced.lateness.max == pytest.approx(oversleeps, abs=ROUNDING_s)
        assert clock.time - 100.0 == pytest.approx(plain.sim_s / rate, abs=oversleeps + ROUNDING_s)
        message = Recording(paced.recording).fact("lateness")
        assert message == pytest.approx(paced.lateness._asdict())


def test_short_time_grants_do_not_change_the_events_of_a_run(tmp_path: Path) -> None:
    results = {
        run(parse(SLEDGE), tmp_path / "x.mcap", True, pace=Pace(ahead)).digest
        for ahead in (1, seconds(0.3), seconds(10))
    }
    assert len(results) == 1


def test_an_event_is_published_with_the_wall_clock_time_at_which_it_occurred(tmp_path: Path) -> None:
    from heavylift.coordinator.run import RunObserver

    clock, message = Clock(1.0), list[tuple[float, int]]()

    class Hears(RunObserver):
        def event(self, event: Event) -> None:
            message.append((clock.time - 100.0, event.t))

    run(parse(SLEDGE), tmp_path / "x.mcap", True, Hears(), pace=clock)
    assert len(message) > 5
    assert all(at >= t * 1e-9 - ROUNDING_s for at, t in message)


@pytest.mark.large
def test_a_run_in_real_time_reports_its_lateness(tmp_path: Path) -> None:
    (tmp_path / "sledge.yaml").write_text(SLEDGE)
    code, out, error = said(tmp_path, "run", "sledge.yaml", "--in-process", "--rate", "100")
    assert (code, error.count("heavylift:")) == (0, 0)
    assert "by the clock: latest " in out
    code, _, error = said(tmp_path, "run", "sledge.yaml", "--rate", "-3")
    assert (code, error) == (1, "heavylift: --rate -3: a rate must be positive and finite; 1 is real time\n")
