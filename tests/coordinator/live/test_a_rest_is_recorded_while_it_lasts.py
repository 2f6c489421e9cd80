"""What rests sends no samples until something happens; those that are sure to come are recorded all the same."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from threading import Event as Alarm

import pytest
from heavylift.coordinator.live import RealTime
from heavylift.coordinator.record import scene
from heavylift.coordinator.run import run
from heavylift.nodes.scene import parse
from heavylift.recordings import Recording
from sledge import SLEDGE

LONG = SLEDGE.replace("wait: 2 s", "wait: 90 s").replace("0.4 MN s/m", "0.05 MN s/m")  # it swings out
TWO = LONG.replace("    cart: {mass: 4 t}", "    cart: {mass: 4 t}\n    other: {mass: 1 t}").replace(
    "  drives:", "    shelf: {type: prismatic, child: other, axis: [1, 0, 0]}\n  drives:"
)
LATE = LONG.replace("actions:\n", "actions:\n  - wait: 60 s\n")


class Clock(RealTime):
    """A clock that moves when the run rests."""

    def __init__(self) -> None:
        super().__init__(1.0, lambda: self.time)
        self.time = 0.0

    def rest(self, alarm: Alarm, seconds: float) -> None:
        self.time += seconds


@pytest.mark.parametrize(("text", "in_process"), [(LONG, True), (TWO, True), (LATE, True), (LONG, False)])
def test_samples_are_recorded_even_while_no_part_moves(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, text: str, in_process: bool
) -> None:
    plain = run(parse(text), tmp_path / "plain.mcap", True)
    clock, ahead = Clock(), list[float]()
    take: Callable[..., None] = scene.Record._take_foretold

    def taken(self: scene.Record, times: list[int], row: object) -> None:
        ahead.extend(clock.time - t * 1e-9 for t in times)
        take(self, times, row)

    monkeypatch.setattr(scene, "SILENT_s", -1.0)
    monkeypatch.setattr(scene.Record, "_take_foretold", taken)
    paced = run(parse(text), tmp_path / "paced.mcap", in_process, pace=clock)
    assert (paced.digest, paced.sim_s, paced.peaks) == (plain.digest, plain.sim_s, plain.peaks)
    assert len(ahead) > (250 if text == LATE else 100)  # of all rows, two in a second
    assert min(ahead) > 0.0
    assert max(ahead) < 1.0
    assert Recording(paced.recording).result["samples"] == Recording(plain.recording).result["samples"]
