"""Ten thousand corrupted recordings: every reading command gives a result or one sentence, within seconds."""

from __future__ import annotations

import random
import sys
from pathlib import Path

import msgspec
import numpy as np
import pytest
from heavylift.recordings import Recorder, SampleChannel, SampleLayout

sys.path.insert(0, str(Path(__file__).parents[1] / "recordings"))
from small_run import NAMES, POSE, SECOND, TIMES, Stage
from spoiled_recordings import read_in_all_ways, spoiled

FILES, SHARDS = 10_000, 20


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("whole") / "run.mcap"
    layout = [SampleChannel("rope/tension", NAMES, "N", 0, 2), SampleChannel("rope/peak", NAMES, "N", 2, 4)]
    layout += [SampleChannel("rope/peak_time", NAMES, "s", 4, 6), SampleChannel("pose/block", POSE, "m", 6, 13)]
    rows = np.random.default_rng(7).normal(size=(len(TIMES), 13))
    with Recorder(path, {"scene": "lift", "rated": {"west.H1": 9e5}}, {"lift.yaml": b"heavylift: 1\n"}) as rec:
        rec.add_port("commander", "stage", msgspec.json.schema(Stage), "key")
        rec.layout(SampleLayout(layout))
        rec.samples(msgspec.msgpack.encode([0, TIMES, rows.tobytes()]))
        rec.event(SECOND, 1, "commander", "stage", 0, "Stage", msgspec.msgpack.encode(Stage("hoist", 1)))
    return path


@pytest.mark.parametrize("shard", range(SHARDS))
def test_a_corrupted_recording_is_read_or_refused_with_a_clear_message(whole: Path, tmp_path: Path, shard: int) -> None:
    data, rng = whole.read_bytes(), random.Random(1000 + shard)
    path = tmp_path / "spoiled.mcap"
    for number in range(FILES // SHARDS):
        path.write_bytes(spoiled(data, rng))
        for sentence in read_in_all_ways(path, whole, tmp_path, pictures=number % 100 == 0):
            assert "\n" not in sentence
