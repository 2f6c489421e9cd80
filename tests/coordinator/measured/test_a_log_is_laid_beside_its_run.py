"""A log becomes channels of a new recording, at the time that it tells itself; the old recording stays as it is."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from heavylift.coordinator.measured import aligned, measure
from heavylift.recordings import Recording, compare, curves, export, info, plot
from heavylift.recordings.render import panels_of
from heavylift.recordings.render.view import content
from small_lift import TIMES, log, recorded, tension

MAPS = ["cell=rope/tension/west.H1 [kN] +- 4 kN", "wind=measured/wind [m/s]"]


@pytest.fixture(scope="module")
def beside(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("beside")
    run, rng = recorded(folder / "run.mcap"), np.random.default_rng(1)
    t = np.arange(0.0, 30.0, 0.1)
    cell = tension(t + 5.0, 1e6, 0.6)[:, 0] / 1e3 + 2.0 * rng.standard_normal(len(t))
    made = log(folder / "log.csv", {"time [s]": t + 700.0, "cell": cell, "wind": np.full(len(t), 6.0)})
    before = run.read_bytes()
    found = measure(run, made, MAPS)
    assert run.read_bytes() == before
    assert found.recording == folder / "run-measured.mcap"
    return found.recording


def test_a_measured_log_is_compared_with_the_run_at_the_times_of_the_log(beside: Path) -> None:
    at = Recording(beside).fact("measured")["at"]
    assert abs(at["offset"] + 695.0) < 3.0 * at["sigma"] < 0.1


def test_the_deviation_of_a_measured_channel_from_the_run_is_compared_with_its_uncertainty(beside: Path) -> None:
    (found,) = Recording(beside).fact("measured")["comparisons"]
    assert found["u_D"] == pytest.approx(2000.0, rel=0.1)  # half of what the map states, and the time
    assert found["u_num"] < 100.0
    assert found["u_input"] == 0.0
    assert found["rms"] == pytest.approx(2000.0, rel=0.15)
    assert found["within"] == pytest.approx(0.95, abs=0.04)
    assert found["u_val"] == pytest.approx(np.hypot(found["u_D"], found["u_num"]), rel=1e-3)


def test_measured_channels_are_recorded_next_to_the_simulated_ones(beside: Path) -> None:
    rec = Recording(beside)
    real, off = rec.signal("measured/rope/tension"), rec.signal("error/rope/tension")
    assert rec["measured/wind"].unit == "m/s"
    assert rec["west"].measured_tension.names == ["west.H1"]
    assert rec["west"].tension.names == ["west.H1", "west.H2"]
    own = np.interp(real.t, rec.signal("rope/tension").t, rec.signal("rope/tension")["west.H1"])
    np.testing.assert_allclose(own - real["west.H1"], off["west.H1"], atol=1e-3)
    assert compare(beside, beside).equal
    assert {"log.csv", "map.yaml"} <= set(rec.attachments)
    assert "measured  rope/tension/west.H1: E " in info(beside)


def test_adding_another_measured_log_to_a_recording_replaces_the_first_log(beside: Path, tmp_path: Path) -> None:
    t = np.arange(0.0, 39.0, 0.1)
    made = log(tmp_path / "log.csv", {"time [s]": t, "cell [t]": tension(t, 1e6, 0.6)[:, 1] / 9806.65})
    found = measure(beside, made, ["cell=rope/tension/west.H2"], 0.0, out=tmp_path / "again.mcap")
    rec = Recording(found.recording)
    assert rec.columns("measured/rope/tension") == ["west.H2"]
    assert abs(rec.signal("error/rope/tension").values).max() < 500.0  # straight lines between samples
    assert found.message[0] == "time 0 of the log is 0 s of the run, as given"
    assert "u_val lacks the uncertainty of the sensor and inputs, which is not stated" in found.message[1]


def test_a_measured_curve_is_dashed_in_the_colour_of_the_simulated_one(beside: Path, tmp_path: Path) -> None:
    (panel,) = panels_of(Recording(beside), ["rope/tension/*"])
    assert [curve.dashed for curve in panel.curves] == [False, False, True]
    assert [curve.colour for curve in panel.curves] == [0, 1, 0]
    for draw in (lambda out: plot(beside, out), lambda out: curves(beside, ["rope/tension/*"], out)):
        assert draw(tmp_path / "drawn.png").stat().st_size > 10_000
    groups = {(s["group"], s["name"]) for s in content(Recording(beside))["signals"]}
    assert ("measured/rope/tension", "west.H1") in groups


def test_measured_values_are_exported_at_the_sample_times_of_the_run(beside: Path, tmp_path: Path) -> None:
    rows = export(beside, tmp_path / "all.csv").read_text().splitlines()
    assert len(rows) == 1 + len(TIMES)
    assert rows[1].split(",")[3] == "nan"  # before the log begins


def test_estimated_time_offsets_are_within_their_uncertainty_on_random_logs() -> None:
    rng, missed = np.random.default_rng(5), 0
    for _ in range(8):
        start, t = rng.uniform(-3.0, 3.0), np.arange(0.0, rng.uniform(15.0, 50.0), rng.choice([0.1, 0.2]))
        noise = rng.standard_normal((len(t), 2))
        if rng.random() < 0.5:  # that hangs together
            noise = np.apply_along_axis(lambda x: np.convolve(x, np.ones(4) / 2.0, "same"), 0, noise)
        true = rng.uniform(-200.0, 200.0)
        D = tension(t, rng.uniform(0.8e6, 1.2e6), 0.6, 8.0 + start) + 3e3 + 4e3 * noise
        model = tension(TIMES, 1e6, 0.6)
        found = aligned([(TIMES, model[:, 0]), (TIMES, model[:, 1])], t + true, [*D.T])
        missed += abs(found.offset - (-true - start)) > 2.0 * found.sigma
    assert missed <= 2  # of 8
