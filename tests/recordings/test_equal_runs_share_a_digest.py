"""The digest: equal for equal runs in whatever order the parts arrive, different for any different byte."""

from __future__ import annotations

import gc
import random
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
import pytest
from heavylift.recordings import Digest, Recorder, Recording
from heavylift.recordings.format import digest as spool
from numpy.typing import NDArray

EVENTS: list[tuple[Any, ...]] = [
    (0, 0, "west", "report", 0, "Done", b"\x01"),
    (0, 0, "west", "report", 1, "Done", b"\x02"),
    (0, 1, "east", "report", 0, "Done", b"\x01"),
    (5, 0, "block", "report", 0, "Lifted", b""),
]
ROWS: list[tuple[int, int, bytes]] = [(0, 0, b"a" * 8), (1, 10, b"b" * 8), (2, 20, b"c" * 8)]


def digest(events: list[tuple[Any, ...]], rows: list[tuple[int, int, bytes]]) -> str:
    out = Digest()
    for event in events:
        out.event(*event)
    for row in rows:
        out.samples(*row)
    return out.hexdigest()


def test_the_digest_does_not_depend_on_the_order_in_which_events_and_samples_arrive() -> None:
    rng = random.Random(1)
    expected = digest(EVENTS, ROWS)
    for _ in range(20):
        events, rows = EVENTS[:], ROWS[:]
        rng.shuffle(events)
        rng.shuffle(rows)
        assert digest(events, rows) == expected


def test_the_digest_covers_every_field_of_an_event_and_of_a_sample_row() -> None:
    changed = [
        *(
            [(*EVENTS[0][:i], other, *EVENTS[0][i + 1 :]), *EVENTS[1:]]
            for i, other in enumerate((1, 1, "x", "x", 7, "x", b"x"))
        ),
        EVENTS[:-1],
        [*EVENTS, EVENTS[0]],
    ]
    others = [digest(events, ROWS) for events in changed]
    others += [
        digest(EVENTS, rows) for rows in (ROWS[:2], [(0, 1, b"a" * 8), *ROWS[1:]], [(0, 0, b"x" * 8), *ROWS[1:]])
    ]
    assert len({digest(EVENTS, ROWS), *others}) == 1 + len(others)


def test_the_digest_of_a_run_can_be_read_before_all_its_data_have_been_added() -> None:
    out = Digest()
    empty = out.hexdigest()
    out.event(*EVENTS[0])
    assert out.hexdigest() == digest(EVENTS[:1], []) != empty


def test_protocol_messages_and_log_entries_are_not_part_of_the_digest(
    begin: Callable[[], Recorder],
    batch: Callable[[int, int], bytes],
    stage: Callable[[Recorder, int, str], None],
    recorded: Path,
) -> None:
    first = Recording(recorded).result["digest"]
    with begin() as rec:
        rec.samples(batch(0, 6))
        for second, name in ((0, "take up"), (1, "hoist"), (3, "lower")):
            stage(rec, second, name)
    assert Recording(recorded).result["digest"] == first


def test_the_digest_can_be_computed_again_from_the_data_in_the_recording(
    recorded: Path, rows: NDArray[np.float64]
) -> None:
    rec = Recording(recorded)
    out = Digest()
    for e in rec.events():
        out.event(e.t_ns, e.microstep, e.source, e.port, e.index, e.type, msgspec.msgpack.encode(e.value))
    columns = np.hstack([rec.signal(name).values for name in rec.signals()])
    for number, (raw, row) in enumerate(zip(rec.messages("/samples"), columns, strict=True)):
        out.samples(number, raw.log_time, row.tobytes())
    assert out.hexdigest() == rec.result["digest"]


def test_a_long_run_whose_data_wait_in_a_file_has_the_same_digest(monkeypatch: pytest.MonkeyPatch) -> None:
    """Of a long run events wait on disk, and those that come late are put in their places."""
    events = [(t, k, "west", "report", 0, "Done", bytes(100)) for t in range(300) for k in range(3)]
    rows = [(n, n, bytes(8)) for n in range(1000)]
    late = [*events[100:], *events[:100]], [*rows[1:], rows[0]]
    expected = digest(events, rows)
    monkeypatch.setattr(spool, "IN_MEMORY", 1000)
    out = Digest()
    for event in events:
        out.event(*event)
    assert out._events._file._file._rolled  # type: ignore[attr-defined]
    assert (digest(events, rows), digest(*late)) == (expected, expected)


@pytest.mark.filterwarnings("error")
def test_computing_a_digest_leaves_no_file_open() -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        gc.collect()  # of what other tests left
    digest(EVENTS, ROWS)
    gc.collect()
