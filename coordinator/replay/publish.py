"""Publish a recording over Zenoh: its committed events and its samples, in real time or any multiple of it.

To observers a replay is a run: it has a run id, a private socket, and the keys of a run,
    heavylift/<run>/event/<model path>/<port>      canonical bytes of the message, as in the run
    heavylift/<run>/sample/<topic>                 the recorded protobuf message: samples, poses, rope lines
Items of one time are published together: events in their total order, then samples. The live page receives the same
data as from a run.
"""

import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack
from dataclasses import dataclass, field
from fnmatch import fnmatchcase
from itertools import groupby
from math import isfinite
from pathlib import Path
from types import TracebackType
from typing import NamedTuple, Self

import msgspec
import numpy as np
from heavylift.coordinator.live import shown
from heavylift.coordinator.live.keys import Keyboard
from heavylift.coordinator.transport.hub import Hub
from heavylift.kernel.errors import RecordingError
from heavylift.nodes.devs import Event, seconds
from heavylift.recordings import RecordedEvent, Spectator
from heavylift.recordings.read.verdict import recorded_peaks
from heavylift.recordings.render.view import sample_rows

from .recorded import RecordedRun, plain

FASTER = 2.0  # what one press of + or - does to the rate


class PublishedItem(NamedTuple):
    """An item to publish: an event, or an encoded message on a topic of sample data."""

    t_ns: int
    event: Event | None
    topic: str
    data: bytes
    schema: str = ""


class Replay:
    """The messages of a recording to replay: those in a time range [s] and on topics that match patterns."""

    def __init__(
        self, run: RecordedRun, topics: Sequence[str] = (), start: float | None = None, end: float | None = None
    ) -> None:
        self._run, rec = run, run.recording
        data = {t.name for t in rec.topics.values() if t.encoding == "protobuf" and t.name not in ("/scene", "/log")}
        ports = {t.name for t in rec.topics.values() if "port" in t.metadata}
        self.topics = sorted(t for t in ports | data if _wanted(t, topics))
        if not self.topics:
            raise RecordingError(
                f"{run.path}: no topic matches {', '.join(topics)}; it has {', '.join(sorted(ports | data))}"
            )
        if not all(t is None or isfinite(t) for t in (start, end)):
            raise RecordingError(
                f"{run.path}: --from and --to must be numbers, in seconds of the run, such as --from 30"
            )
        self._data = data
        self.start = 0 if start is None else seconds(start)
        self.end = seconds(end) + 1 if end is not None else 2**63 - 1
        if self.start >= self.end:
            raise RecordingError(f"{run.path}: nothing lies between {start} s and {end} s; give --from before --to")

    def __iter__(self) -> Iterator[tuple[int, list[PublishedItem]]]:
        """Yield each time [ns] with all items at it, in order."""
        text = (x for x in self._said() if self.start <= x.t_ns < self.end)
        for t, group in groupby(text, lambda x: x.t_ns):
            yield t, sorted(group, key=lambda x: (x.event is None, x.event.order if x.event else (), x.topic))

    def _said(self) -> Iterator[PublishedItem]:
        decode = msgspec.json.Decoder(RecordedEvent).decode
        rec = self._run.recording
        for topic, raw in rec.stream(*self.topics):
            if topic in self._data:
                schema = rec.topics[topic].schema
                yield PublishedItem(raw.log_time, None, topic.removeprefix("/"), raw.data, schema)
            else:
                with rec.reading():
                    event = decode(raw.data)
                yield PublishedItem(raw.log_time, plain(event), topic, b"")


def _wanted(topic: str, patterns: Sequence[str]) -> bool:
    names = (topic, topic.removeprefix("/"))
    return not patterns or any(fnmatchcase(name, pattern) for name in names for pattern in patterns)


class Publisher:
    """A run without nodes that publishes the items of a replay to observers; a context manager."""

    def __init__(self, name: str, recording: Path) -> None:
        self._name, self._recording = name, recording
        self._stack = ExitStack()

    def say(self, text: PublishedItem) -> None:
        """Publish one event or one message of data to observers."""
        if text.event is not None:
            self._publisher.last_ns = max(self._publisher.last_ns, text.t_ns)
            self._publisher.event(text.event)
            self._publisher.show()
        else:
            self._hub.publish_data(text.topic, text.data, text.schema, text.t_ns)

    def __enter__(self) -> Self:
        self._hub = self._stack.enter_context(Hub(()))
        self.run, self.directory = self._hub.run, self._hub.directory.path
        publisher = self._stack.enter_context(shown(self._hub, self._name, self._recording))
        assert publisher is not None, "a hub of processes can be watched"
        self._publisher = publisher
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._stack.__exit__(kind, error, trace)


@dataclass
class Player:
    """Publishes a replay in real time: `rate` simulated seconds per wall second; keys pause, step and change the rate.

    space: pause and continue    s or .: the next instant, then pause    + and -: twice and half the rate    q: end
    """

    say: Callable[[PublishedItem], None]
    rate: float = 1.0
    paused: bool = False
    keyboard: Keyboard = field(default_factory=Keyboard)
    clock: Callable[[], float] = time.monotonic
    on_time: Callable[[int], None] = lambda t_ns: None
    over: bool = False

    def play(self, replay: Replay) -> int:
        """Play the replay once from start to end; returns the number of published items."""
        count, self._sim_ns, self._wall = 0, replay.start, self.clock()
        for t, group in replay:
            self._wait(t)
            if self.over:
                break
            for one in group:
                self.say(one)
            count += len(group)
            self.on_time(t)
        return count

    def _wait(self, t: int) -> None:
        """Wait until `t` [ns] is due, a key skips the wait, or the replay ends."""
        while not self.over:
            left = None if self.paused else self._wall + (t - self._sim_ns) * 1e-9 / self.rate - self.clock()
            if left is not None and left <= 0.0 and not self.keyboard.there:
                return
            key = self.keyboard.wait(left if left is None else max(0.0, left))
            if key in ("s", "."):
                self.paused, self._sim_ns = True, t
                return
            if key:
                self._execute(key)
            elif left is not None:
                return
            else:  # paused, and no key can come any more
                self.over = not self.keyboard.there

    def _execute(self, key: str) -> None:
        if not self.paused:  # what follows counts from here
            now = self.clock()
            self._sim_ns += round((now - self._wall) * self.rate * 1e9)
        self._wall = self.clock()
        match key:
            case " ":
                self.paused = not self.paused
            case "+":
                self.rate *= FASTER
            case "-":
                self.rate /= FASTER
            case "q":
                self.over = True


class ReplayPage:
    """Sends a replay to the page, from simulation time `start` [ns] on; `end` closes it."""

    def __init__(self, run: RecordedRun, page: Spectator, start: int = 0) -> None:
        self._page, self._recording = page, run.recording
        rec = self._recording
        layout, t, self._rows = sample_rows(rec)
        self._times = np.rint(t * 1e9).astype(np.int64)
        self._next = int(np.searchsorted(self._times, start))
        rigs = rec.rigs()
        self._rigs = [rig for rig in rigs if rig.t_ns > start]
        self._rated = rec.fact("rated", {})
        before = [rig.lines for rig in rigs if rig.t_ns <= start]
        facts = {**rec.run, "rated": self._rated, "supports": rec.fact("supports", [])}
        page.begin(facts, layout, rec.boxes(), before[-1] if before else [])

    def event(self, e: Event) -> None:
        """Send an event of the replay to the page."""
        self._page.event(e.t, e.source, e.port, e.type, e.payload)

    def reached(self, t_ns: int) -> None:
        """Send to the page the samples up to this simulation time [ns], and the rope lines at that time."""
        end = int(np.searchsorted(self._times, t_ns, side="right"))
        if end > self._next:
            part = slice(self._next, end)
            self._page.samples(self._times[part].tolist(), self._rows[part])
            self._next = end
        while self._rigs and self._rigs[0].t_ns <= t_ns:
            rig = self._rigs.pop(0)
            self._page.ropes(rig.t_ns, rig.lines)

    def end(self) -> None:
        """Send the end of the replay to the page, with the peaks of the whole run."""
        peaks = recorded_peaks(self._recording)
        rows = [{"name": name, **x._asdict(), "rated": self._rated.get(name)} for name, x in peaks.items()]
        self._page.end("replayed", {}, rows, str(self._recording.path))
