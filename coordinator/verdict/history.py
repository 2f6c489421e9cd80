"""History of a run as columns: times, poses, tensions, and rope lines with their times.

Taken from the samples while they are recorded (`Collector`), or from a recording (`history_of`). A run may be long:
checks read it part by part, and a collector keeps its rows in a temporary file.
"""

from array import array
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from typing import Protocol

import numpy as np
from heavylift.kernel.algebra.attitudes import quaternions
from heavylift.nodes.plan.connections import lug_places
from heavylift.nodes.plan.plan import Plan
from heavylift.nodes.statics.state import REEVING, StaticState, reeved
from heavylift.recordings import Recording, SampleLayout
from heavylift.recordings.format.digest import Spool
from heavylift.recordings.format.samples import POSE, SampleChannel
from heavylift.recordings.format.viewer_messages import Rig, RopeLine
from numpy.typing import NDArray

Floats = NDArray[np.float64]
SPEED = "joint/velocity"
PADS = "support/force"
NUMBERS = (
    "rope/tension",
    "rope/length",
    REEVING,
    PADS,
    "contact/force",
    SPEED,
    "deflection",
    "edge/force",
    "edge/place",
)
BLOCK = 4096  # samples that are looked at together
KEPT = 3  # blocks of them: an hour and a half of usual samples


class RunHistory(Protocol):
    """Interface of the recorded history of a run, as a whole or in parts."""

    @property
    def t(self) -> Floats:
        """Sample times (n,) [s], in order."""

    def part(self, first: int, end: int) -> "History":
        """Return the part of the history that begins at sample `first` and ends before sample `end`."""


@dataclass(frozen=True)
class History:
    """Recorded columns of a run, or of a part of one, over its sample times t (n,) [s].

    Poses: body -> (n, 7) [m, quaternion x y z w]; tensions: rope (most loaded part), support or contact -> (n,) [N];
    unstretched lengths: rope -> (n,) [m]; rope lines with their times; joint speeds: joint.component -> (n,) [m/s,
    rad/s]; deflections `bent`: body.place.axis -> (n,) [m]; edge forces and places: rope.edge -> (n,) [N], [m].
    """

    t: Floats
    poses: Mapping[str, Floats]
    tensions: Mapping[str, Floats]
    lengths: Mapping[str, Floats]
    rigs: Sequence[Rig]
    speeds: Mapping[str, Floats] = field(default_factory=dict)
    bent: Mapping[str, Floats] = field(default_factory=dict)
    borne: Mapping[str, Floats] = field(default_factory=dict)
    places: Mapping[str, Floats] = field(default_factory=dict)
    straight: bool = field(default=False, kw_only=True)  # between the samples, which are as near as that asks for

    def part(self, first: int, end: int) -> "History":
        """Return the part of the history that begins at sample `first` and ends before sample `end`."""
        return self.of(np.arange(first, min(end, len(self.t))))

    def of(self, kept: NDArray[np.intp]) -> "History":
        """Return the history reduced to the samples with these indices."""
        if len(kept) == len(self.t):
            return self
        columns = self.poses, self.tensions, self.lengths, self.speeds, self.bent, self.borne, self.places
        poses, tensions, lengths, *more = (
            {name: np.take(x.T, kept, axis=-1).T for name, x in each.items()} for each in columns
        )
        return History(self.t[kept], poses, tensions, lengths, self.rigs, *more, straight=self.straight)


def blocks(past: RunHistory) -> Iterator[History]:
    """Yield consecutive parts of a history, at least one, that overlap by one sample."""
    for first in range(0, max(1, len(past.t)), BLOCK):
        yield past.part(max(0, first - 1), first + BLOCK)


class Collector:
    """Collects sample rows of a run in progress as the history that its verdict needs."""

    def __init__(self, layout: SampleLayout) -> None:
        self._bodies = [c.topic.removeprefix(POSE) for c in layout.channels if c.topic.startswith(POSE)]
        columns = [i for c in layout.channels if c.topic.startswith(POSE) for i in range(c.start, c.stop)]
        self._names: list[list[str]] = []
        for topic in NUMBERS:
            channel = layout.find(topic)
            self._names.append(list(channel.names) if channel else [])
            columns += range(channel.start, channel.stop) if channel else []
        self._columns = np.array(columns, np.intp)
        self._times = array("q")
        self._rows = Spool("what the verdict is made of")
        self._parts: dict[tuple[int, int], History] = {}  # the last ones: all judges look at the same
        self.rigs: list[Rig] = []

    def samples(self, first: int, times: Sequence[int], rows: Floats) -> None:
        """Add rows (m, width) at these times [ns], numbered from `first`; rows that were added before are skipped."""
        skip = len(self._times) - first
        if skip < len(times):
            self._parts.clear()
            self._times.extend(times[skip:])
            self._rows.write(rows[skip:, self._columns].tobytes())

    def ropes(self, t_ns: int, lines: Sequence[RopeLine]) -> None:
        """Add the rope lines that are valid from this time [ns] on."""
        self.rigs.append(Rig(t_ns, list(lines)))

    @property
    def t(self) -> Floats:
        """Sample times (n,) [s]."""
        return np.array(self._times, np.float64) * 1e-9

    def part(self, first: int, end: int) -> History:
        """Return the part of the history that begins at sample `first` and ends before sample `end`."""
        if (first, end) not in self._parts:
            while len(self._parts) >= KEPT:
                del self._parts[next(iter(self._parts))]
            self._parts[first, end] = self._part(first, end)
        return self._parts[first, end]

    def _part(self, first: int, end: int) -> History:
        t = np.array(self._times[first:end], np.float64) * 1e-9
        width = len(self._columns)
        rows = np.frombuffer(self._rows.read(8 * width * len(t), 8 * width * first)).reshape(len(t), width)
        table = np.ascontiguousarray(rows.T)  # a column is one piece of memory, as all sums run along it
        columns = iter(table[7 * len(self._bodies) :])
        poses = {body: table[7 * i : 7 * i + 7].T for i, body in enumerate(self._bodies)}
        tensions, lengths, parts, pads, pressed, *more = [
            {name: next(columns) for name in names} for names in self._names
        ]
        return History(t, poses, tensions | _most(parts) | pads | pressed, _whole(lengths), self.rigs, *more)


@dataclass(frozen=True)
class Every:
    """The history of a run reduced to every n-th sample, n = `every`."""

    past: RunHistory
    every: int

    @property
    def t(self) -> Floats:
        """Sample times (n,) [s], in order."""
        return self.past.t[:: self.every]

    def part(self, first: int, end: int) -> History:
        """Return the part of the history that begins at sample `first` and ends before sample `end`."""
        whole = self.past.part(first * self.every, end * self.every)
        return whole.of(np.arange(0, len(whole.t), self.every))


def history_of(rec: Recording) -> Collector:
    """Read the history of a run from its recording."""
    names = [name for name in rec.signals() if name.startswith(POSE) or name in NUMBERS]
    ends = np.cumsum([0, *(len(rec.columns(name)) for name in names)]).tolist()
    columns = [(name, rec.columns(name), rec.unit(name)) for name in names]
    layout = SampleLayout([SampleChannel(*x, *place) for x, place in zip(columns, pairwise(ends), strict=True)])
    found, number = Collector(layout), 0
    for times, values in rec.blocks(names):
        found.samples(number, times, np.hstack(values))
        number += len(times)
    found.rigs = rec.rigs()
    return found


def rests(plan: Plan, states: Sequence[StaticState]) -> Iterator[tuple[History, Sequence[StaticState]]]:
    """Yield the equilibrium path of each action list as a history, with each sling drawn to its present lug."""
    known, ends = plan.machines, [i for i, (a, b) in enumerate(pairwise(states), 1) if b.t < a.t]
    lugs, lines = lug_places(known), {r.name: r.lines for m in known for r in m.system.ropes}
    for first, end in pairwise([0, *ends, len(states)]):
        part, rigs = states[first:end], list[Rig]()
        for i, x in enumerate(part):
            if not i or x.hooked != part[i - 1].hooked:
                ends_now = {name: lugs.get(x.hooked.get(name, "")) for name in lines}
                drawn = [(name, a.a, ends_now[name] or a.b) for name, some in lines.items() for a in some]
                rigs.append(Rig(round(x.t * 1e9), [RopeLine(name, p.body, p.p, q.body, q.p) for name, p, q in drawn]))
        at = {name: [np.array([x.poses[name][k] for x in part]) for k in (0, 1)] for name in sorted(part[0].poses)}
        poses = {name: np.hstack([p, quaternions(R)]) for name, (p, R) in at.items()}
        tensions = {name: np.array([x.tensions[name] for x in part]) for name in sorted(part[0].tensions)}
        yield History(np.array([x.t for x in part]), poses, tensions, {}, rigs, straight=True), part


def _most(parts: Mapping[str, Floats]) -> dict[str, Floats]:
    """Return the tension of the most loaded part of each rope over sheaves."""
    found: dict[str, Floats] = {}
    for part, tension in parts.items():
        rope = reeved(part)
        found[rope] = np.maximum(found[rope], tension) if rope in found else tension
    return found


def _whole(lengths: Mapping[str, Floats]) -> dict[str, Floats]:
    """Return the total length of ropes with mass, which consist of pieces `rope~1`, ..., `rope`."""
    found: dict[str, Floats] = {}
    for piece, length in lengths.items():
        rope = piece.partition("~")[0]
        found[rope] = found[rope] + length if rope in found else length
    return found
