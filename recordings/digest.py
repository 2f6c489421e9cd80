"""What two equal runs share to the last byte: SHA-256 over the sorted events, the sample rows and the sampler's notes.

Events are the ones on the ports of coupled models, keyed (t, microstep, source path, port, index), with
type and canonical bytes; rows are keyed by their number and are what stands in the file, the numbers of `/samples`
and then those of `/poses`, notes are those of `/log`, so that a reader can compute the digest again.  The order in
which they are added does not matter: events are kept and sorted at the end, a row is hashed at once and only its hash
is kept.  Attachments, facts and whatever is derived from samples (verdicts, clearances, collisions) stay outside; no
message holds a file name or a line (DIGEST.md has the table).
"""

from __future__ import annotations

import hashlib
import struct

import msgspec

__all__ = ["Digest"]


class Digest:
    """Incremental and independent of the order of its calls."""

    def __init__(self) -> None:
        self._events: list[tuple[int, int, str, str, int, str, bytes]] = []
        self._rows: dict[int, bytes] = {}
        self._notes: dict[int, bytes] = {}

    def event(self, t_ns: int, k: int, source: str, port: str, index: int, type: str, payload: bytes) -> None:
        """Add one event with its canonical bytes."""
        self._events.append((t_ns, k, source, port, index, type, payload))

    def samples(self, number: int, t_ns: int, row: bytes) -> None:
        """Add the sample row of this number: simulation time [ns] and its float64 bytes."""
        self._rows[number] = hashlib.sha256(struct.pack("<qq", number, t_ns) + row).digest()

    def note(self, number: int, t_ns: int, sentence: str) -> None:
        """Add the sampler's note of this number."""
        self._notes[number] = hashlib.sha256(msgspec.msgpack.encode((number, t_ns, sentence))).digest()

    def hexdigest(self) -> str:
        """SHA-256 of all that was added so far, in hexadecimal."""
        total = hashlib.sha256(struct.pack("<qq", len(self._events), len(self._rows)))
        for event in sorted(self._events):
            total.update(msgspec.msgpack.encode(event))
        for number in sorted(self._rows):
            total.update(self._rows[number])
        for number in sorted(self._notes):
            total.update(self._notes[number])
        return total.hexdigest()
