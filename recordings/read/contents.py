"""The contents of a recording, computed again from its messages: digest, peaks, numbers of events and rows.

Messages are taken one after the other, from a whole file or from the rest of a damaged one. The file contains the value
of an event as JSON, and the schema tells which texts were bytes. JSON does not preserve values that are not numbers
(nan), so the digest of a run with such an event cannot be computed again.

Also decoding of the messages of several channels into numbers in one pass through the file, some thousand at a time,
with the rows of single lifts that show the changes by events between the common samples.
"""

from base64 import b64decode
from collections.abc import Callable, Iterable, Iterator, Mapping
from typing import Any

import msgspec
import numpy as np
from heavylift.recordings.format.digest import Digest
from heavylift.recordings.format.samples import POSE, SAMPLER, Field, SampleChannel, SampleLayout
from heavylift.recordings.format.schema import RecordedEvent, Template, field_places, samples_template
from heavylift.recordings.format.viewer_messages import Log, frames_template
from heavylift.recordings.write.sink import Peak, note_peaks
from numpy.typing import NDArray

from .chunks import MessageTable
from .container import FileChannel
from .signal import Signal

Floats = NDArray[np.float64]
READ = ("/samples", "/poses", "/log")  # topics that are taken, beside those of events
BLOCK = 4096  # rows that are decoded together
EVENT = msgspec.json.Decoder(RecordedEvent).decode


class Unknown(ValueError):
    """Raised for a value that cannot be determined from the recording."""


class Contents:
    """Contents of a recording, computed from its messages in order: digest, peak tensions, numbers of events and rows.

    `peaks` of ropes from rounded rows; `unknown`, `torn`: sentences about values or rows that are missing, in which
    case there is no digest.
    """

    def __init__(self) -> None:
        self.peaks: dict[str, Peak] = {}
        self.events, self.unknown, self.torn = 0, "", ""
        self._digest = Digest()
        self._lifts = {"": _Lift()}
        self._schemas: dict[bytes, Any] = {}
        self._notes: list[tuple[int, int, str]] = []

    def take(self, topic: str, facts: Mapping[str, str], schema: bytes, t_ns: int, data: bytes) -> None:
        """Add the next message of a topic to the contents; raises an error for damaged bytes.

        `facts`: metadata of the topic; `t_ns`: time at which the message was published [ns].
        """
        kind, _, lift = topic.removeprefix("/").partition("/")
        if "port" in facts:
            self._event(schema, data)
        elif topic == "/log":
            if message := sampler_note(data):
                self._notes.append(message)
        elif kind in ("samples", "poses"):
            rows = self._lifts.setdefault(lift, _Lift(lift))
            rows.take(kind, facts, t_ns, data)
            if rows.full:
                self._add(rows)

    @property
    def rows(self) -> int:
        """Number of sample rows of the whole scene, without additional rows of single lifts."""
        return self._lifts[""].count

    @property
    def digest(self) -> str:
        """Digest of all messages; "" if the digest cannot be computed."""
        return "" if self.unknown or self.torn else self._digest.hexdigest()

    def agrees(self, result: Mapping[str, str]) -> bool:
        """Return whether the digest in a recorded result equals that of the messages."""
        return bool(self.digest) and self.digest == result.get("digest")

    def _event(self, schema: bytes, data: bytes) -> None:
        e, self.events = EVENT(data), self.events + 1
        value = e.value
        if b"base64" in schema or b"null" in data:
            found = self._schemas.setdefault(schema, None) or msgspec.json.decode(schema)
            self._schemas[schema] = found
            try:
                value = _written(value, found["properties"]["value"], found.get("$defs", {}))
            except Unknown as error:
                self.unknown = f"{e.source}.{e.port} at {e.t_ns / 1e9:.9g} s: {error}"
        self._digest.event(e.t_ns, e.microstep, e.source, e.port, e.index, e.type, msgspec.msgpack.encode(value))

    def end(self) -> None:
        """Add the last rows and all notes to the contents and their digest, after the last message."""
        for lift in self._lifts.values():
            self._add(lift)
        for number, (_, t_ns, sentence) in enumerate(sorted(self._notes, key=lambda note: note[0])):
            self._digest.note(number, t_ns, sentence)

    def _add(self, lift: "_Lift") -> None:
        """Add the pending rows of a lift to the digest and to the peaks."""
        times, numbers, rows = lift.joined()
        if rows is None:
            self.torn = self.torn or f"rows of /samples and /poses are not of the same times, from row {lift.count} on"
            rows = numbers
        for i, t_ns in enumerate(times):
            self._digest.samples(lift.count + i, t_ns, rows[i].tobytes(), lift.name)
        if not lift.name and times and lift.layout is not None:
            note_peaks(self.peaks, lift.layout, times, numbers)
        lift.count += len(times)


class _Lift:
    """Pending samples and poses of all lifts together, or of a single lift; `count`: number of rows before these."""

    def __init__(self, name: str = "") -> None:
        self.name, self.count = name, 0
        self.layout: SampleLayout | None = None  # of the numbers
        self._forms: dict[str, Template] = {}
        self._places: dict[str, slice] = {}
        self._waiting: dict[str, list[tuple[int, bytes]]] = {"samples": [], "poses": []}

    def take(self, kind: str, facts: Mapping[str, str], t_ns: int, data: bytes) -> None:
        if kind not in self._forms:
            if kind == "samples":
                fields = msgspec.json.decode(facts["signals"], type=list[Field])
                places = field_places(fields)
                self._forms[kind] = samples_template(fields)
                self._places[kind] = slice(0, sum(len(field.columns) for field in fields))
                at = [places[f.signal] for f in fields]
                found = zip(fields, at, strict=True)
                self.layout = SampleLayout(
                    [SampleChannel(f.signal, f.columns, f.unit, x.start, x.stop) for f, x in found]
                )
            else:
                bodies = msgspec.json.decode(facts["names"], type=list[str])
                self._forms[kind], self._places[kind] = frames_template(bodies), slice(0, 7 * len(bodies))
        self._waiting[kind].append((t_ns, data))

    @property
    def full(self) -> bool:
        """Whether enough messages wait to be decoded as a block."""
        return min(len(self._waiting[kind]) for kind in self._forms) >= BLOCK

    def joined(self) -> tuple[list[int], Floats, Floats | None]:
        """Return waiting sample rows: times [ns], numbers, and numbers with poses (None if poses have other times)."""
        at, parts = list[list[int]](), list[Floats]()
        for kind in sorted((kind for kind in self._forms if self._waiting[kind]), reverse=True):  # samples, then poses
            waiting, self._waiting[kind] = self._waiting[kind], []
            at.append([t for t, _ in waiting])
            parts.append(self._forms[kind].decode(_table([x for _, x in waiting]), self._places[kind])[0])
        if not at:
            return [], np.zeros((0, 0)), np.zeros((0, 0))
        return at[0], parts[0], np.hstack(parts) if at[-1] == at[0] else None


def _table(messages: list[bytes]) -> NDArray[np.uint8]:
    """Return messages as bytes (n, length); raises ValueError if their lengths differ."""
    lengths = {len(message) for message in messages}
    if len(lengths) > 1:
        raise ValueError("rows of one topic differ in length")
    return np.frombuffer(b"".join(messages), np.uint8).reshape(len(messages), *lengths)


def sampler_note(data: bytes) -> tuple[int, int, str] | None:
    """Return number, time [ns] and sentence of a note from the node that sends samples; None for other log lines."""
    line = Log.FromString(data)
    if line.name != SAMPLER or line.level != Log.Level.WARNING:
        return None
    return line.line, line.timestamp.ToNanoseconds(), line.message


def _written(value: Any, schema: Mapping[str, Any], defs: Mapping[str, Any]) -> Any:
    """Return a value read from JSON, with bytes where the schema has bytes; raises Unknown if a number is null."""
    while "$ref" in schema:
        schema = defs[schema["$ref"].rpartition("/")[2]]
    if "anyOf" in schema:
        schema = next((x for x in schema["anyOf"] if _fits(value, x, defs)), schema)
        return _written(value, schema, defs) if "anyOf" not in schema else value
    if value is None and schema.get("type") == "number":
        raise Unknown("a message contains NaN or infinity, which JSON cannot represent")
    if isinstance(value, str) and schema.get("contentEncoding") == "base64":
        return b64decode(value)
    if isinstance(value, dict):
        parts, rest = schema.get("properties", {}), schema.get("additionalProperties", {})
        return {key: _written(x, parts.get(key, rest if rest else {}), defs) for key, x in value.items()}
    if isinstance(value, list):
        parts, rest = schema.get("prefixItems", []), schema.get("items") or {}
        return [_written(x, parts[i] if i < len(parts) else rest, defs) for i, x in enumerate(value)]
    return value


KINDS: dict[str, type | tuple[type, ...]] = {
    "number": (int, float), "integer": int, "string": str, "boolean": bool, "null": type(None), "array": list,
}  # fmt: skip


def _fits(value: Any, schema: Mapping[str, Any], defs: Mapping[str, Any]) -> bool:
    """Return whether a value matches this member of a union."""
    while "$ref" in schema:
        schema = defs[schema["$ref"].rpartition("/")[2]]
    kind = schema.get("type")
    if isinstance(value, dict):
        return kind == "object" and {*schema.get("required", ())} <= value.keys() <= {*schema.get("properties", value)}
    return "enum" in schema or "const" in schema or isinstance(value, KINDS.get(str(kind), ()))


Form = tuple[Template, dict[str, slice]]  # of the messages of a channel, and where signals stand in their numbers
Rows = tuple[list[int], dict[str, NDArray[np.float64]]]  # times [ns] and signals


def decoded(tables: Iterable[MessageTable], forms: Mapping[int, Form]) -> Iterator[list[Rows]]:
    """Yield decoded rows of these channels in blocks; within a block, all channels have the same number of rows."""
    waiting: dict[int, list[MessageTable]] = {channel: [] for channel in forms}
    counts = dict.fromkeys(forms, 0)
    for table in tables:
        waiting[table.channel].append(table)
        counts[table.channel] += len(table.times)
        while min(counts.values()) >= BLOCK:
            yield [_rows(waiting[channel], *form) for channel, form in forms.items()]
            counts = {channel: n - BLOCK for channel, n in counts.items()}
    if all(counts.values()):
        yield [_rows(waiting[channel], *form) for channel, form in forms.items()]


def _rows(waiting: list[MessageTable], form: Template, places: dict[str, slice]) -> Rows:
    """Decode the first pending messages of a channel into rows."""
    times, rows = list[int](), list[NDArray[np.uint8]]()
    while waiting and len(times) < BLOCK:
        channel, t, data = waiting.pop(0)
        if len(t) > (left := BLOCK - len(times)):
            waiting.insert(0, MessageTable(channel, t[left:], data[left:]))
        times += t[:left].tolist()
        rows.append(data[:left])
    found = form.decode(np.concatenate(rows), *places.values())  # ValueError if their lengths differ
    return times, dict(zip(places, found, strict=True))


def with_own_rows(
    signal: Signal, topics: Iterable[FileChannel], decoded: Callable[[Mapping[str, Form]], Iterator[list[Rows]]]
) -> Signal:
    """Add to a signal the rows recorded for single lifts at their events; at equal times, these rows come last."""
    for topic in topics:
        found = _form(topic.name, topic.metadata, signal)
        if found is None:
            continue
        form, columns = found
        parts = [part for (part,) in decoded({topic.name: form})]
        t = np.array([x for times, _ in parts for x in times], np.float64) / 1e9
        own = np.concatenate([np.zeros((0, len(columns))), *(values[signal.name] for _, values in parts)])
        picked = own[:, [columns.index(name) for name in signal.names]]
        order = np.argsort(np.concatenate([signal.t, t]), kind="stable")
        values = np.concatenate([signal.values, picked])[order]
        return Signal(np.concatenate([signal.t, t])[order], values, signal.names, signal.unit, signal.name)
    return signal


def _form(topic: str, facts: dict[str, str], signal: Signal) -> tuple[Form, list[str]] | None:
    """Return the format of the rows of a single lift, and its columns of the signal; None if it lacks one of them."""
    if topic.startswith("/samples/"):
        fields = msgspec.json.decode(facts["signals"], type=list[Field])
        columns = next((x.columns for x in fields if x.signal == signal.name), [])
        if columns and {*signal.names} <= {*columns}:
            return (samples_template(fields), {signal.name: field_places(fields)[signal.name]}), columns
    if topic.startswith("/poses/") and signal.name.startswith(POSE):
        bodies = msgspec.json.decode(facts["names"], type=list[str])
        if (body := signal.name.removeprefix(POSE)) in bodies:
            at = 7 * bodies.index(body)
            return (frames_template(bodies), {signal.name: slice(at, at + 7)}), ["x", "y", "z", "qx", "qy", "qz", "qw"]
    return None
