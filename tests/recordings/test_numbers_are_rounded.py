"""What is recorded is rounded far below what a reader needs, and nothing stands in the file twice."""

from __future__ import annotations

from pathlib import Path

import msgspec
import numpy as np
from heavylift.recordings import Recorder, Recording, SampleChannel, SampleLayout
from heavylift.recordings.format import Rounding

POSE = ["x", "y", "z", "qx", "qy", "qz", "qw"]


def test_recorded_values_are_rounded_to_a_step_that_depends_on_their_unit() -> None:
    columns = {"m": 2.0**-38, "m/s": 2.0**-32, "N": 2.0**-14, "J": 2.0**-14, "s": 2.0**-20}
    rounded = Rounding([SampleChannel(f"x/{unit}", ["a"], unit, 0, 1) for unit in columns])
    x = np.random.default_rng(1).normal(scale=1e6, size=(200, len(columns)))
    x[0] = 1e9  # large enough for steps to be those of the units
    off = np.abs(rounded(x) - x)
    steps = np.array([*columns.values()])
    assert np.all(off <= steps / 2)
    assert np.all(off.max(axis=0) > 0.45 * steps)
    assert np.array_equal(rounded(rounded(x)), rounded(x)), "twice is once"


def test_rounding_of_recorded_values_keeps_the_significant_digits_of_small_values() -> None:
    rounded = Rounding([SampleChannel("rope/tension", ["toy"], "N", 0, 1)])
    x = np.array([[0.0], [1e-6], [3e-5], [9.80665e-3], [1e-6]])
    off = np.abs(np.vstack([rounded(x[:3]), rounded(x[3:])]) - x)[:, 0]
    largest = np.array([0.0, 1e-6, 3e-5, 9.80665e-3, 9.80665e-3])
    assert np.all(off <= 2.0**-30 * largest), "of the largest so far"


def test_rounding_of_recorded_values_does_not_depend_on_batches() -> None:
    channels = [SampleChannel("joint/velocity", ["a", "b"], "rad/s", 0, 2), SampleChannel("energy", ["c"], "J", 2, 3)]
    x = np.random.default_rng(2).normal(size=(60, 3)) * np.geomspace(1e-9, 1e3, 60)[:, None]
    x[7, 1], x[40, 2] = np.nan, np.inf
    once, twice = Rounding(channels), Rounding(channels)
    one_by_one = np.vstack([twice(row[None]) for row in x])
    assert np.array_equal(once(x), one_by_one, equal_nan=True)


def test_recorded_values_are_not_rounded_if_they_are_infinite_or_have_an_unlisted_unit() -> None:
    rounded = Rounding([SampleChannel("a", ["a"], "1/rad2", 0, 1), SampleChannel("b", ["b"], "N", 1, 2)])
    rows = np.array([[np.pi, np.inf], [1e-300, -np.inf], [0.1, 1e300], [-0.1, 1e308]])
    assert np.array_equal(rounded(rows), rows)
    assert np.isnan(rounded(np.array([[np.nan, np.nan]]))).all()


def test_the_coordinates_of_free_joints_are_recorded_only_as_poses_of_bodies(tmp_path: Path) -> None:
    names = ["rail.travel", *(f"float.{x}" for x in POSE), "float.angle"]
    layout = SampleLayout(
        [SampleChannel("joint/position", names, "m or rad", 0, 9), SampleChannel("pose/crate", POSE, "m", 9, 16)]
    )
    row = np.arange(16) / 16
    with Recorder(tmp_path / "run.mcap", {}) as rec:
        rec.layout(layout)
        rec.samples(msgspec.msgpack.encode([0, [0], row.tobytes()]))
    found = Recording(tmp_path / "run.mcap")
    assert found.columns("joint/position") == ["rail.travel", "float.angle"]
    assert found.signal("joint/position").values.tolist() == [[0.0, 8 / 16]]
    assert found.signal("pose/crate").values.tolist() == [list(row[9:])]


def test_signals_and_poses_of_a_sample_are_recorded_in_the_same_chunk(tmp_path: Path) -> None:
    """So a chunk that is lost or cut off takes both away."""
    layout = SampleLayout(
        [
            SampleChannel("x", [str(i) for i in range(3000)], "1", 0, 3000),
            SampleChannel("pose/b", POSE, "m", 3000, 3007),
        ]
    )
    rows = np.random.default_rng(4).normal(size=(40, 3007))
    with Recorder(tmp_path / "run.mcap", {}) as rec:
        rec.layout(layout)
        rec.samples(msgspec.msgpack.encode([0, [*range(40)], rows.tobytes()]))
    file = Recording(tmp_path / "run.mcap")._file
    numbers = {c.topic: c.id for c in file.summary.channels.values()}
    both = {numbers["/samples"], numbers["/poses"]}
    assert len(file.summary.chunk_indexes) > 2
    assert all(both <= set(index.message_index_offsets) for index in file.summary.chunk_indexes)
