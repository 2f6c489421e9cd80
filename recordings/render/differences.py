"""Differences of two recordings other than the values of signals: events, notes, rows, descriptions, facts,
attachments.

Rows are compared byte for byte, one by one; a missing row is reported by its time.
"""

from collections import Counter
from collections.abc import Collection, Iterator
from contextlib import suppress
from hashlib import sha256
from itertools import zip_longest

import msgspec
import numpy as np
from heavylift.kernel.errors import printable
from heavylift.recordings.format.samples import POSE
from heavylift.recordings.format.schema import RecordedEvent
from heavylift.recordings.read.reader import Recording
from numpy.typing import NDArray

CIRCUMSTANCES = frozenset(
    ("placement", "python", "platform", "wall_s", "grants", "lateness", "slack")  # facts that no two runs share
)
ROWED = ("/samples", "/poses", "/measured", "/scene", "/ropes", "/rig")  # topics whose messages are compared


def event(A: Recording, B: Recording) -> Iterator[tuple[float, str]]:
    """Yield the time [s] and a description of the first event that differs between two recordings; yield nothing if all
    events are equal."""
    for x, y in zip_longest(A.events(), B.events()):
        if x != y or msgspec.json.encode(x) != msgspec.json.encode(y):
            t = min(e.t_ns for e in (x, y) if e is not None) * 1e-9
            yield t, f"event at {t:.9f} s: {_described(x)} in {A.path.name}, {_described(y)} in {B.path.name}"
            return


def _described(event: RecordedEvent | None) -> str:
    return "nothing" if event is None else f"{event.source}.{event.port} {event.type} {event.value}"


def notes(A: Recording, B: Recording) -> Iterator[tuple[float, str]]:
    """Yield the time [s] and a description of the first kernel note that differs between two recordings; yield nothing
    if all notes are equal."""
    for x, y in zip_longest(A.notes(), B.notes()):
        if x != y:
            text = " and ".join(f"'{note[1]}'" if note else "nothing" for note in (x, y))
            yield min(note[0] for note in (x, y) if note), f"note of the kernel: {text}"
            return


def rows(A: Recording, B: Recording, topic: str) -> tuple[list[str], list[tuple[float, str]]]:
    """Return descriptions of rows of a topic that one recording lacks, and the first difference with its time [s]."""
    a, b = (hashes(rec, topic) for rec in (A, B))
    if np.array_equal(a, b):
        return [], []
    missing = []
    times = [Counter(x["t"].tolist()) for x in (a, b)]
    for there, here, rec in ((times[0], times[1], B), (times[1], times[0], A)):
        if lost := sorted((there - here).elements()):
            one = len(lost) == 1
            missing.append(
                f"{len(lost)} row{'s' * (not one)} of {topic} {'is' if one else 'are'} missing in {rec.path.name}, "
                f"{'' if one else 'the first '}at {lost[0] / 1e9:.9f} s"
            )
    n = min(len(a), len(b))
    off = np.flatnonzero(a[:n] != b[:n])
    row = int(off[0]) if len(off) else n
    t = min(int(x["t"][row]) for x in (a, b) if row < len(x)) / 1e9
    same = np.array_equal(np.sort(a), np.sort(b))
    what = f"{_column(A, B, topic, row)} at {t:.9f} s"
    if same:
        what += "; the rows are the same in another order"
    elif row == n:
        what += f"; {(A if len(a) == row else B).path.name} ends before"
    return missing, [(t, what)]


def hashes(rec: Recording, topic: str) -> NDArray[np.void]:
    """Return the time `t` [ns] and a content hash `x` of each message of a topic (n,), in the order of the file."""
    found = [(raw.publish_time, sha256(raw.data).digest()[:8]) for raw in rec.messages(topic)]
    return np.array(found, [("t", "<i8"), ("x", "S8")])


def _column(A: Recording, B: Recording, topic: str, row: int) -> str:
    """Return the first signal of a row that differs, or its topic."""
    names = {"/samples": lambda name: not name.startswith(POSE), "/poses": lambda name: name.startswith(POSE)}
    for name in filter(names.get(topic, lambda name: False), A.signals()):
        if name in B.signals():
            a, b = A.signal(name), B.signal(name)
            if row < min(len(a), len(b)) and a.values[row].tobytes() == b.values[row].tobytes():
                continue
            return name
    return f"row {row} of {topic}"


def channels(A: Recording, B: Recording, but: Collection[str] = ()) -> Iterator[str]:
    """Yield descriptions of the topics that differ in names, columns or schemas, except the topics in `but`."""
    for topic in sorted({*A.topics, *B.topics}):
        a, b = ((x[:4], x.form) if (x := rec.topics.get(topic)) else None for rec in (A, B))
        if a != b and not topic.startswith("/protocol/") and topic not in but:
            yield f"description of {topic}" if a and b else f"topics: {topic} is only in {(A if a else B).path.name}"


def facts(A: Recording, B: Recording, but: Collection[str] = ()) -> Iterator[str]:
    """Yield descriptions of facts that differ between two recordings, except those on computation and in `but`."""
    for kind, a, b in (("run", A.run, B.run), ("result", A.result, B.result)):
        for name in sorted(a.keys() | b.keys()):
            x, y = a.get(name), b.get(name)
            if x != y and name not in CIRCUMSTANCES and name not in but:
                yield f"{kind}.{name}: {_short(x)} in {A.path.name}, {_short(y)} in {B.path.name}"


def _short(text: str | None) -> str:
    """Return a fact in a few words; for a verdict its summary line."""
    with suppress(msgspec.MsgspecError, TypeError, KeyError):
        text = msgspec.json.decode(text or "")["line"]
    return "nothing" if text is None else printable(text, 60)


def attachments(A: Recording, B: Recording, but: Collection[str] = ()) -> Iterator[str]:
    """Yield descriptions of the attached files that differ between two recordings, except the files in `but`."""
    for name in sorted({*A.attachments, *B.attachments} - {*but}):
        if A.attachments.get(name) != B.attachments.get(name):
            yield f"attachment: {printable(name, 60)}"


def circumstances(A: Recording, B: Recording) -> Iterator[str]:
    """Yield the names of differing facts about where and how the two runs were computed."""
    for name in sorted(CIRCUMSTANCES):
        if (A.run.get(name), A.result.get(name)) != (B.run.get(name), B.result.get(name)):
            yield name
    if [(at, A.checkpoint(at)) for at in A.checkpoints] != [(at, B.checkpoint(at)) for at in B.checkpoints]:
        yield "checkpoints"
