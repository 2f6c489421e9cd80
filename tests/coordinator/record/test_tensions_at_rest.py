"""Tensions at rest at the times of a run: those of the run swing about them, whatever the pace of its stages."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from heavylift.coordinator.record import at_rest
from heavylift.coordinator.run import run
from heavylift.nodes.scene import load
from heavylift.recordings import Recording, plot


@pytest.fixture(scope="module", params=["lift", "hall"])
def recording(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Recording:
    path = tmp_path_factory.mktemp("rest") / "run.mcap"
    run(load(request.param), path, in_process=True)
    return Recording(path)


def test_the_tension_of_a_loaded_rope_oscillates_about_its_static_tension(recording: Recording) -> None:
    """Hooks of a slow lift: the mean over a run is that at rest to 1 %, and no instant is a sixth off."""
    found, tension = at_rest(recording), recording["rope/tension"]
    hooks = [name for name in found if name in tension.names and found[name][1].min() > 0.0]
    assert hooks
    for name in hooks:
        over = tension[name] / np.interp(tension.t, *found[name])
        assert over.mean() == pytest.approx(1.0, abs=1e-2), name
        assert abs(over - 1.0).max() < 1.0 / 6.0, name


def test_the_equilibrium_path_has_the_same_times_as_the_run(recording: Recording) -> None:
    (t, _), *_ = at_rest(recording).values()
    stages = [start for start, _ in recording.stages()]
    assert np.all(np.diff(t) >= 0.0)
    assert all(np.abs(t - start).min() < 1e-6 for start in stages), "a point of the path where each stage begins"


def test_the_plot_has_a_panel_of_the_ratio_of_dynamic_to_static_tensions(recording: Recording, tmp_path: Path) -> None:
    plain = plot(recording, tmp_path / "plain.svg").read_text()
    assert "over its static value" not in plain
    assert "over its static value" in plot(recording, tmp_path / "over.svg", rest=at_rest(recording)).read_text()


def test_a_recording_without_a_plan_has_no_static_tensions(tmp_path: Path) -> None:
    path = tmp_path / "run.mcap"
    run(load("pendulum", ["end=1 s"]), path, in_process=True)
    rec = Recording(path)
    del rec.attachments["resolved.json"]
    assert at_rest(rec) == {}
