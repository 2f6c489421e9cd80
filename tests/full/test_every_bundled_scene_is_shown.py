"""Each bundled scene has its page, its figures and, if it lifts a load, its report."""

from pathlib import Path

import pytest
from heavylift.coordinator.run import run
from heavylift.nodes.scene import bundled, load
from heavylift.recordings import Recording, plot, report, view


@pytest.mark.parametrize("name", bundled())
def test_every_bundled_scene_runs_and_is_drawn_and_plotted(name: str, tmp_path: Path) -> None:
    scene = load(name)
    recording = run(scene, tmp_path / "run.mcap", in_process=True).recording
    view(recording, tmp_path / "page.html")
    rec = Recording(recording)
    if any(rec.columns(x) for x in {"rope/tension", "joint/position"} & {*rec.signals()}):  # not of one free body
        plot(recording, tmp_path / "plot.png")
    report(recording, tmp_path / "report.html")
    message = (tmp_path / "report.html").read_text()
    assert [rope for rope in Recording(recording).fact("peaks", {}) if rope not in message] == []
