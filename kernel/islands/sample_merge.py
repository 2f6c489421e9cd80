"""Merging of the islands' samples into samples of the scene: one row of all columns per time, in order of time.

Islands compute samples at different moments of the run but for the same simulation times; a row is complete when all
moving islands have given their part; an island at rest gives the row in which it rests. The effect of an event or
command has a row of its own: of the affected lift, if the scene has several lifts, else of the whole scene.
"""

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from heavylift.kernel.algebra.dense import norm
from heavylift.kernel.algebra.spatial import exact
from heavylift.kernel.constraints.row_structure import RigidAt
from heavylift.kernel.description.findings import Note
from heavylift.kernel.description.mechanics import RigidRope, Rope, System, merge
from heavylift.kernel.forces.ropes import ROPE_HEAD, ROPE_LINE
from heavylift.kernel.model.program import Program
from heavylift.kernel.model.switching import StateChange
from heavylift.kernel.simulation.native.native_functions import Stepping
from heavylift.kernel.simulation.native.sample_row import labels, row_layout

from .components import islands_of
from .island import Island

Rows = list[tuple[int, np.ndarray]]


@dataclass(frozen=True)
class _Loose:
    """An unhooked rope: columns of its length and of the distance between its ends, sign of their difference, numbers
    of its lines, links at their ends."""

    length: int
    apart: int
    sign: float
    lines: np.ndarray
    ends: list[tuple[int, int]]

    def span(self, frames: np.ndarray) -> float:
        """Return the length of a rope [m], the sum of its straight lines, at poses `frames` (n, 12) of the bodies."""
        out = 0.0
        for line, ends in zip(self.lines.reshape(-1, ROPE_LINE), self.ends, strict=True):
            places = [
                p if i < 0 else (exact(frames[i, :3]) + exact(frames[i, 3:].reshape(3, 3)) @ exact(p)).astype(float)
                for i, p in zip(ends, (line[:3], line[3:6]), strict=True)
            ]
            out += float(line[6]) * norm((places[0] - places[1]).tolist())
        return out


class Merge:
    """Places simultaneous sample rows of the islands in one row of the scene."""

    def __init__(self, program: Program) -> None:
        self._place = {label: i for i, label in enumerate(labels(program))}
        self._program, self._at = program, row_layout(program).at
        self._places = np.zeros(0, dtype=int)

    def cut(self, parts: Sequence[Island], loose: frozenset[str]) -> None:
        """Set the islands of which the scene now consists, and the unhooked ropes that couple no bodies."""
        self._places = np.array([self._place[x] for p in parts for x in labels(p.program)], dtype=int)
        at, s, number = self._at, self._program.system, self._program.graph.number
        self._loose: list[_Loose] = []
        elastic, rigid = (
            ("rope", ROPE_HEAD, "length", "elongation", 1.0),
            ("rigid", RigidAt.LINES, "span", "slack", -1.0),
        )
        ropes: list[tuple[int, Rope | RigidRope]] = [*enumerate(s.ropes), *enumerate(s.rigid_ropes)]
        for i, r in ropes:
            if r.name in loose:
                kind, first, length, apart, sign = elastic if isinstance(r, Rope) else rigid
                owner = next(p for p in parts if (kind, r.name) in p.program.parameters.at)
                lines = owner.P[owner.program.parameters.at[kind, r.name]][first:]
                ends = [(number(x.a.body), number(x.b.body)) for x in r.lines]
                self._loose.append(_Loose(at[length].start + i, at[apart].start + i, sign, lines, ends))

    def whole(self, parts: Sequence[np.ndarray]) -> np.ndarray:
        """Combine simultaneous rows of all islands into one row of the scene.

        Energies and step counts are summed; every other column, except those of loose ropes, belongs to one island.
        """
        row = np.bincount(self._places, np.concatenate(parts), len(self._place))  # sums in the order of the islands
        frames = row[self._at["poses"]].reshape(-1, 12)
        for rope in self._loose:
            row[rope.apart] = rope.sign * (rope.span(frames) - row[rope.length])
        return row


class LiftRows(Merge):
    """Sample rows of one lift after its events and commands, with the columns of this lift only."""

    def __init__(self, name: str, method: Stepping) -> None:
        super().__init__(method.program)
        self.name, self.method = name, method
        self.bodies = frozenset(b.name for b in method.program.system.bodies)
        self.rows: Rows = []
        self.parts: list[Island] = []

    def cut(self, parts: Sequence[Island], loose: frozenset[str]) -> None:
        """Set the islands of which the lift now consists, and the unhooked ropes that couple no bodies."""
        self.parts = [p for p in parts if p.given.bodies[0].name in self.bodies]
        super().cut(self.parts, frozenset(r.name for r in self._program.system.straight_ropes if r.name in loose))

    def take(self, t_ns: int, stopped: Sequence[Island]) -> None:
        """Record a sample row of the lift at a time at which events or commands have stopped some of its islands."""
        self.rows.append((t_ns, self.whole([p.struck if p in stopped else p.shown_at(t_ns) for p in self.parts])))


def untied(system: System, lifts: Mapping[str, Collection[str]]) -> dict[str, System]:
    """Group the bodies of lifts (by name) into independent systems; coupled lifts become one system, `a+b`."""
    of = {body: name for name, bodies in lifts.items() for body in bodies}
    found = dict[str, System]()
    pieces = islands_of(system) if lifts else []
    names = [sorted({of[b.name] for b in piece.bodies if b.name in of}) for piece in pieces]
    groups: list[set[str]] = []
    for some in map(set, names):
        groups = [g for g in groups if not g & some] + [some.union(*(g for g in groups if g & some))]
    for group in groups if len(groups) > 1 else ():
        own = [piece for piece, some in zip(pieces, names, strict=True) if group.issuperset(some)]
        whole = merge(own, system.gravity)
        found["+".join(sorted(group))] = replace(whole, masters=tuple(dict.fromkeys(whole.masters)))
    return found


class Joining(Merge):
    """Collects sample rows of islands and returns complete rows of the scene; `period`: sample period [ns]."""

    def __init__(self, program: Program, period: int) -> None:
        super().__init__(program)
        self._period = period
        self.number = 1  # of the next periodic sample
        self.struck: Rows = []  # rows of events that wait for samples before them
        self._before: tuple[list[np.ndarray], np.ndarray] = [], np.zeros(0)

    @property
    def next_ns(self) -> int:
        """The time of the next periodic sample [ns]."""
        return self.number * self._period

    def take(self, samples: Sequence[Rows], resting: Sequence[np.ndarray | None], end_ns: int) -> Rows:
        """Return the complete sample rows of the scene before a time, made of the islands' samples and rows at rest."""
        out: Rows = []
        for rows in samples:
            while rows and rows[0][0] < self.next_ns:  # of steps that were taken again
                rows.pop(0)
        while (t := self.next_ns) < end_ns:
            ready = [bool(rows) and rows[0][0] == t for rows in samples]
            if not any(ready) or not all(r or x is not None for r, x in zip(ready, resting, strict=True)):
                break
            out += self._struck(t)
            now = [rows.pop(0)[1] if r else x for r, rows, x in zip(ready, samples, resting, strict=True)]
            parts, (before, row) = [x for x in now if x is not None], self._before
            if len(parts) != len(before) or any(a is not b for a, b in zip(parts, before, strict=True)):
                row = self.whole(parts)
                self._before = parts, row
            out.append((t, row))  # the same one as long as all rest
            self.number += 1
        return out

    def ready(self) -> Rows:
        """Return the sample rows of events and commands before the next periodic sample."""
        return self._struck(self.next_ns)

    def _struck(self, before: int) -> Rows:
        if not self.struck:
            return []
        out = [x for x in self.struck if x[0] < before]
        self.struck = self.struck[len(out) :]
        return out


def logged(parts: Sequence[Island]) -> Iterator[tuple[int, StateChange]]:
    """Yield the log entries that islands have added since the last call."""
    for p in parts:
        entries, noted = p.merged
        if len(p.log) > entries:
            yield from p.log[entries:]
            p.merged = len(p.log), noted


def noted(parts: Sequence[Island], until_ns: int) -> list[Note]:
    """Return the islands' notes for the user that are new and not later than `until_ns` [ns], in order of time."""
    out: list[Note] = []
    for p in parts:
        entries, before = p.merged
        if len(p.notes) > before:
            fresh = [note for note in p.notes[before:] if note.t_ns <= until_ns]
            p.merged = entries, before + len(fresh)
            out += fresh
    return sorted(out, key=lambda note: note.t_ns)
