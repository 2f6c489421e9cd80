"""A run that nobody records passes values from model to model: rows, events, notes and end are those of a recorded one,
whose messages are bytes."""

from __future__ import annotations

from pathlib import Path

import msgspec
import numpy as np
import pytest
from heavylift.coordinator.record import play
from heavylift.coordinator.run import run
from heavylift.nodes.devs import Message
from heavylift.nodes.scene import load
from heavylift.nodes.scenes import bundled
from heavylift.recordings import Recording
from heavylift.recordings.format import Columns
from without_bytes import without_bytes

FIRST = ("gust", "girder", "damper")  # forces alone, a beam that bends, a model of a user's own


def _plain(value: Message) -> object:
    return msgspec.msgpack.decode(msgspec.msgpack.encode(value))


@pytest.mark.large(beyond=len(FIRST))
@pytest.mark.parametrize("name", [*FIRST, *sorted({*bundled()} - {*FIRST})])
def test_a_bundled_scene_gives_the_same_run_in_memory_and_through_the_protocol(name: str, tmp_path: Path) -> None:
    scene = load(name)
    with without_bytes():
        played = play(scene.plan)
    recorded = run(scene, tmp_path / "run.mcap", in_process=True)
    rec = Recording(recorded.recording)
    assert [(e.t, e.k, e.source, e.port, e.index, e.type, _plain(e.value)) for e in played.events] == [
        (e.t_ns, e.microstep, e.source, e.port, e.index, e.type, e.value) for e in rec.events()
    ]
    columns = Columns(played.layout)
    rows = columns(played.rows)
    assert columns.signals
    for signal, place in columns.signals.items():
        assert rec[signal].t.tolist() == played.t.tolist()
        assert np.ascontiguousarray(rows[:, place]).tobytes() == np.ascontiguousarray(rec[signal].values).tobytes()
    assert played.digest == recorded.digest
    assert play(scene.plan).digest == played.digest  # by models that have run before
    assert played.end_ns == round(recorded.sim_s * 1e9)
