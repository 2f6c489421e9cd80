"""A small run to record: two loaders and a block, six samples, three events; all numbers are multiples of the steps
in which they are recorded."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import msgspec
import numpy as np
import pytest
from heavylift.recordings import Recorder, SampleChannel, SampleLayout
from numpy.typing import NDArray
from small_run import NAMES, POSE, SECOND, TIMES, Stage


@pytest.fixture
def layout() -> SampleLayout:
    return SampleLayout(
        [
            SampleChannel("rope/tension", NAMES, "N", 0, 2),
            SampleChannel("rope/peak", NAMES, "N", 2, 4),
            SampleChannel("rope/peak_time", NAMES, "s", 4, 6),
            SampleChannel("pose/block", POSE, "m", 6, 13),
            SampleChannel("pose/hook", POSE, "m", 13, 20),
        ]
    )


@pytest.fixture
def rows() -> NDArray[np.float64]:
    rows = np.random.default_rng(7).normal(size=(6, 20))
    rows[:, 0:2] = [[1e5, 2e5], [3e5, 2e5], [4e5, 1e5], [4.5e5, 0.0], [2e5, 0.0], [1e5, 0.0]]
    rows[:, 2:4] = rows[:, 0:2] + 1e3
    rows[:, 4:6] = np.maximum(0.0, np.array(TIMES)[:, None] / 1e9 - 0.125)
    for start in (9, 16):
        rows[:, start : start + 4] /= np.linalg.norm(rows[:, start : start + 4], axis=1)[:, None]
    return np.rint(rows * 2.0**38) / 2.0**38


@pytest.fixture
def batch(rows: NDArray[np.float64]) -> Callable[[int, int], bytes]:
    """The samples from one number up to another as the kernel sends them."""
    return lambda first, stop: msgspec.msgpack.encode([first, TIMES[first:stop], rows[first:stop].tobytes()])


@pytest.fixture
def stage() -> Callable[[Recorder, int, str], None]:
    """Record a stage event at so many seconds."""

    def event(rec: Recorder, second: int, name: str) -> None:
        payload = msgspec.msgpack.encode(Stage(name, second))
        rec.event(second * SECOND, 1, "commander", "stage", 0, "Stage", payload)

    return event


@pytest.fixture
def begin(tmp_path: Path, layout: SampleLayout) -> Callable[[], Recorder]:
    """A recorder of run.mcap with its ports and columns announced."""

    def make() -> Recorder:
        rec = Recorder(
            tmp_path / "run.mcap",
            {"scene": "lift", "seed": 7, "rated": {"west.H1": 9e5}, "loaders": {"loader-1": "west.H1"}},
            {"lift.yaml": b"heavylift: 1\n"},
        )
        rec.add_port("commander", "stage", msgspec.json.schema(Stage), "heavylift/r/event/commander/stage")
        rec.layout(layout)
        return rec

    return make


@pytest.fixture
def recorded(
    begin: Callable[[], Recorder],
    batch: Callable[[int, int], bytes],
    stage: Callable[[Recorder, int, str], None],
) -> Path:
    """The finished recording of the whole small run."""
    with begin() as rec:
        rec.protocol(0, "west", "to node", "GRANT", {"until": SECOND}, b"\x01\x02")
        stage(rec, 0, "take up")
        rec.samples(batch(0, 4))
        stage(rec, 1, "hoist")
        stage(rec, 3, "lower")
        rec.samples(batch(4, 6))
        rec.log(4 * SECOND, "info", "west", "all down")
        return rec.close("finished", result={"energy": {"closes": 1e-7}})
