"""Reading a finished recording: facts, events in order, signals as arrays.

    rec = Recording("turnover.mcap")
    t, tension, names, unit = rec.signal("rope/tension")     # s, (n, m), ["west.H1", ...], "N"
    rec["block"].pose, rec["rope/tension/west.*"]            # by names of parts or patterns; see READING.md

`pose/<body>` is read back from the frame transforms, every other signal from its field of `/samples`, or for a log of a
real machine of `/measured`, at times of its own; only requested signals are read. Columns of a single lift include the
rows of this lift alone.
"""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager, suppress
from functools import cached_property
from math import isfinite
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
import zstandard
from heavylift.kernel.errors import SignalError, printable
from heavylift.kernel.version import __version__, again, install
from heavylift.recordings.format.samples import POSE, POSE_COLUMNS, POSE_UNIT, Field
from heavylift.recordings.format.schema import RecordedEvent, field_places, samples_template
from heavylift.recordings.format.text import GENERATOR, meant, shown
from heavylift.recordings.format.viewer_messages import DrawnBox, Rig, boxes_of, frames_template
from heavylift.recordings.write.sink import CHECKPOINT, FORMAT, OLDEST
from numpy.typing import NDArray

from .chunks import LIMIT, RawMessage
from .container import Container
from .contents import Contents, Form, Rows, decoded, sampler_note, with_own_rows
from .signal import RecordedPart, Signal, chosen, drawing, only, recording_html

SHOWN = 60  # characters of a version that a file names
Floats = NDArray[np.float64]
NUMBERS, BESIDE = "/samples", "/measured"  # topics of numbers


class Recording:
    """A finished recording, opened for reading.

    Raises RecordingError for a file that is missing, cut off, damaged, or not a recording of heavylift.
    """

    def __init__(self, path: str | Path) -> None:
        self._file = Container(path)
        self.path, self.damage = self._file.path, self._file.damage
        self.size, self.library = self._file.size, shown(self._file.library)  # [bytes], who has made it
        self._signals: dict[str, Signal] = {}  # what was loaded so far
        self.contents: Contents | None = None  # once somebody has looked
        self.complaints: list[str] | None = None
        metadata = {name: shown(facts) for name, facts in self._file.metadata().items()}
        if "run" not in metadata and not self.library.startswith(GENERATOR):
            raise self._file.error("this is an MCAP file of another program; give a file made by `heavylift run`")
        with self.reading():
            self.run = metadata["run"]
        self._check_format()
        self.result = metadata.get("result", {})
        self.attachments = shown(self._file.attachments(lambda name: not name.startswith(CHECKPOINT)))
        self._channels = {shown(channel.topic): channel.id for channel in self._file.summary.channels.values()}
        self.topics = self._file.topics()

    def _check_format(self) -> None:
        """Raise RecordingError if the file was written in an incompatible format."""
        found = self.run.get("format", "1")
        if found not in map(str, range(OLDEST, FORMAT + 1)):
            with self.reading():
                if why := self._file.damage():
                    raise ValueError(why)
            newer = found.isdecimal() and len(found) < 10 and int(found) > FORMAT
            to = f"{install(self.version)}, or a later one" if newer else again(self.version)
            raise self._file.error(
                f"the recording has format {found[:20]}, but this is heavylift {__version__}, which reads format "
                f"{FORMAT}; {to}"
            )

    @property
    def version(self) -> str:
        """The version of heavylift that wrote the recording."""
        return printable(self.library.removeprefix("heavylift ").partition(" ")[0], SHOWN)

    def fact(self, name: str, default: Any = None) -> Any:
        """Return a recorded fact, read from JSON; raises RecordingError if its type differs from that of `default`."""
        found = text = self.result.get(name, self.run.get(name))
        if text is None or isinstance(default, str):
            return default if text is None else text
        with self.reading():
            with suppress(msgspec.DecodeError):
                found = shown(msgspec.json.decode(text))
            kind = (int, float) if isinstance(default, int | float) else type(default)
            if default is not None and (not isinstance(found, kind) or (type(found) is float and not isfinite(found))):
                raise ValueError(f"the fact '{name[:40]}' has the invalid value {text[:40]}")
        return found

    @property
    def checkpoints(self) -> dict[tuple[int, int], int]:
        """Sizes [bytes] of the mechanics' checkpoints (for `heavylift branch`), by logical time (ns, microstep)."""
        with self.reading():
            found = self._file.summary.attachment_indexes
            sizes = {x.name.removeprefix(CHECKPOINT): x.data_size for x in found if x.name.startswith(CHECKPOINT)}
            tags = {name: name.partition(".") for name in sizes}
            return dict(sorted(((int(t), int(k)), sizes[name]) for name, (t, _, k) in tags.items()))

    def checkpoint(self, at: tuple[int, int]) -> bytes:
        """Return the checkpoint of the mechanics at a logical time."""
        with self.reading():
            name = "{}{}.{}".format(CHECKPOINT, *at)
            packed = self._file.attachments(name.__eq__)[name]
            if zstandard.get_frame_parameters(packed).content_size > LIMIT:
                raise ValueError("a checkpoint exceeds the size limit")
            return zstandard.decompress(packed)

    def messages(self, *topics: str) -> Iterator[RawMessage]:
        """Yield the undecoded messages of these topics in the order of the file."""
        return self._file.messages({self._channels[topic] for topic in topics if topic in self._channels})

    def stream(self, *topics: str) -> Iterator[tuple[str, RawMessage]]:
        """Yield the undecoded messages of these topics, each together with its topic."""
        names = {number: topic for topic, number in self._channels.items()}
        return ((names[raw.channel], raw) for raw in self.messages(*topics))

    def numbers(self, forms: Mapping[str, Form], only: Sequence[int] | None = None) -> Iterator[list[Rows]]:
        """Yield decoded rows of these topics in blocks. `only`: numbers of the wanted rows (None: all)."""
        numbers = {self._channels[topic]: form for topic, form in forms.items()}
        return decoded(self._file.tables(set(numbers), only), numbers)

    def reading(self) -> AbstractContextManager[None]:
        """Return a context that converts decoding errors into a RecordingError about this file."""
        return self._file.reading()

    def events(self, source: str | None = None, port: str | None = None) -> list[RecordedEvent]:
        """Return all events in total order, or only the events of one model or port."""
        wanted = [
            topic.name
            for topic in self.topics.values()
            if "port" in topic.metadata
            and source in (None, topic.metadata.get("model"))
            and port in (None, topic.metadata["port"])
        ]
        decode = msgspec.json.Decoder(RecordedEvent).decode
        with self._file.reading():
            found = [decode(raw.data) for raw in self.messages(*wanted)]
        return sorted(found, key=lambda e: (e.t_ns, e.microstep, e.source, e.port, e.index))

    def stages(self) -> list[tuple[float, str]]:
        """Return the begin [s] and the name of each stage of the run."""
        text = ((e.t_ns / 1e9, e.value) for e in self.events(port="stage"))
        return [(t, shown(str(value["name"]))) for t, value in text if isinstance(value, dict) and value.get("name")]

    def notes(self) -> list[tuple[float, str]]:
        """Return the notes that the kernel made about the run: simulation time [s] and text."""
        with self._file.reading():
            found = [note for raw in self.messages("/log") if (note := sampler_note(raw.data))]
        return [(t_ns * 1e-9, shown(sentence)) for _, t_ns, sentence in sorted(found, key=lambda note: note[0])]

    def __getitem__(self, name: str) -> Any:
        """Return a signal, some of its columns selected by a pattern, or all data of a part of the scene; raises
        SignalError if there is none.

        rec["rope/tension"], rec["rope/tension/west.*"], rec["block"].pose, rec["legs/1"].tension

        Use `signal` or `part` to get only one kind of data.
        """
        if name in self.signals():
            return self.signal(name)
        found: dict[str, list[str]] = {}
        for signal, column in chosen(self, name):
            found.setdefault(signal, []).append(column)
        if len(found) == 1:
            ((signal, columns),) = found.items()
            with self.reading():
                return with_own_rows(only(self.signal(signal), columns), self.topics.values(), self.numbers)
        return RecordedPart(self, name, found) if found else self.part(name)

    def part(self, name: str) -> RecordedPart:
        """Return the signals and events of a crane, rope, joint or body of the scene.

        A name such as "legs/1" stands for legs-1. Raises SignalError if there is no part with this name.
        """
        return RecordedPart.of(self, name)

    def _repr_html_(self) -> str:
        """Return HTML for notebooks with facts, tensions, stages and the available signals."""
        with self.reading():
            signals = [[name, field.unit, ", ".join(field.columns)] for name, field in self._fields.items()]
            signals += [[f"{POSE}*", "m, quaternion", ", ".join(self._bodies)]] if self._bodies else []
            shown = [self.signal("rope/tension")] if "rope/tension" in self._fields else []
            state = "".join(drawing(x.name, x.unit, x.t, x.values) for x in shown)
            return recording_html(str(self.path), self.run, self.result, self.stages(), signals, state)

    def __repr__(self) -> str:
        status = self.result.get("status", "cut off")
        return f"<Recording {self.path}: {self.run.get('scene', '')}, {status}, {len(self.signals())} signals>"

    def message(self, fact: str) -> list[str]:
        """Return the recorded sentences about a comparison with a real lift (`measured`) or errors (`certified`)."""
        return [str(x) for x in self.fact(fact, {}).get("told", "")]

    def results(self) -> dict[str, dict[str, Any]]:
        """Return the final results of the atomic models of a DEVS run by path: class `type`, and fields as `value`."""
        return dict(self.fact("results", {}))

    def rigs(self) -> list[Rig]:
        """Return the recorded sets of rope lines, each with the time from which it is valid."""
        with self._file.reading():
            return [msgspec.json.decode(raw.data, type=Rig) for raw in self.messages("/rig")]

    def boxes(self) -> list[DrawnBox]:
        """Return the shapes drawn on the bodies."""
        with self._file.reading():
            return [box for raw in self.messages("/scene") for box in boxes_of(raw.data)]

    def signals(self) -> list[str]:
        """Return the names of all signals, as `signal` accepts them."""
        return [*self._fields, *(POSE + body for body in self._bodies)]

    def columns(self, name: str) -> list[str]:
        """Return the names of a signal's columns."""
        return list(POSE_COLUMNS) if name.startswith(POSE) else self._fields[name].columns

    def unit(self, name: str) -> str:
        """Return the unit of a signal's columns."""
        return POSE_UNIT if name.startswith(POSE) else self._fields[name].unit

    def signal(self, name: str) -> Signal:
        """Return a sampled signal such as "rope/tension" over the whole run."""
        self.load([name])
        return self._signals[name]

    def load(self, names: Sequence[str]) -> None:
        """Read several signals in a single pass through the file, and store them for later calls of `signal`."""
        for name in names:
            if name not in self._fields and name.removeprefix(POSE) not in self._bodies:
                raise SignalError(f"{self.path}: the recording has no signal {name}; {meant(name, self.signals())}")
        with self._file.reading():
            for topic, form in self._forms([name for name in names if name not in self._signals]).items():
                parts = [part for (part,) in self.numbers({topic: form})]
                t = np.array([x for times, _ in parts for x in times], np.float64) / 1e9
                for name in form[1]:
                    self._signals[name] = self._joined(name, t, (values.pop(name) for _, values in parts))

    def blocks(
        self, names: Sequence[str], only: Sequence[int] | None = None
    ) -> Iterator[tuple[list[int], list[Floats]]]:
        """Yield times [ns] and values of these signals in blocks of some thousand rows, until one signal ends.

        Measured signals that are requested together with simulated signals are interpolated at the times of the
        simulation (`Signal.at`). `only`: numbers of the wanted samples, in ascending order.
        """
        topic = BESIDE if all(name in self._tables.get(BESIDE, {}) for name in names) else NUMBERS
        numbers = [name for name in names if name in self._tables.get(topic, {})]
        poses = [name for name in names if name not in self._fields]
        others = [name for name in names if name in self._fields and name not in numbers]
        self.load(others)
        with self._file.reading():
            for found in self.numbers(self._forms([*numbers, *poses]), only):
                n = min(len(times) for times, _ in found)
                if any(times[:n] != found[0][0][:n] for times, _ in found):
                    raise ValueError("its signals do not have the same times")
                values = {name: x[:n] for _, part in found for name, x in part.items()}
                t = np.array(found[0][0][:n]) / 1e9
                values |= {name: self._signals[name].at(t).values for name in others}
                yield found[0][0][:n], [values[name] for name in names]

    def picked(self, names: Sequence[str], numbers: NDArray[np.intp]) -> dict[str, Signal]:
        """Return these signals at the samples with the given numbers."""
        parts = list(self.blocks(names, numbers.tolist()))
        t = np.array([x for times, _ in parts for x in times], np.float64) / 1e9
        return {name: self._joined(name, t, (values[i] for _, values in parts)) for i, name in enumerate(names)}

    def _joined(self, name: str, t: Floats, parts: Iterable[Floats]) -> Signal:
        """Return a signal made from its blocks."""
        columns = self.columns(name)
        return Signal(t, np.concatenate([np.zeros((0, len(columns))), *parts]), columns, self.unit(name), name)

    def _forms(self, names: Sequence[str]) -> dict[str, Form]:
        """Return the topics that contain these signals, with the formats of their messages."""
        forms: dict[str, Form] = {}
        for topic, fields in self._tables.items():
            if any(name in fields for name in names):
                places = field_places(list(fields.values()))
                template = samples_template(list(fields.values()))
                forms[topic] = template, {name: places[name] for name in names if name in fields}
        poses = {POSE + body: slice(7 * i, 7 * i + 7) for i, body in enumerate(self._bodies)}
        if wanted := {name: poses[name] for name in names if name not in self._fields}:
            forms["/poses"] = frames_template(self._bodies), wanted
        return forms

    @cached_property
    def _tables(self) -> dict[str, dict[str, Field]]:
        """The message fields by signal, for each topic."""
        with self._file.reading():
            texts = {name: self.topics[name].metadata["signals"] for name in (NUMBERS, BESIDE) if name in self.topics}
            tables = {name: msgspec.convert(shown(msgspec.json.decode(x)), list[Field]) for name, x in texts.items()}
            return {name: {field.signal: field for field in fields} for name, fields in tables.items()}

    @cached_property
    def _fields(self) -> dict[str, Field]:
        return {name: field for fields in self._tables.values() for name, field in fields.items()}

    @cached_property
    def _bodies(self) -> list[str]:
        with self._file.reading():
            facts = self.topics["/poses"].metadata if "/poses" in self.topics else {"names": "[]"}
            return msgspec.convert(shown(msgspec.json.decode(facts["names"])), list[str])
