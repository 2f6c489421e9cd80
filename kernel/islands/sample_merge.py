"""Samples of a scene from those of its islands: one row of all columns per time, in the order of time.

Islands step as they like, so their samples come at different moments of the run, but at the same times; a row is
complete when all islands that move have given their part, and one that rests gives the row in which it rests.  What an
event or a command has changed is shown in a row of its own.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from heavylift.kernel.algebra.dense import norm
from heavylift.kernel.algebra.spatial import exact
from heavylift.kernel.constraints.rigid_ropes import RigidAt
from heavylift.kernel.description.mechanics import RigidRope, Rope
from heavylift.kernel.description.notes import Note
from heavylift.kernel.forces.ropes import ROPE_HEAD, ROPE_LINE
from heavylift.kernel.model.program import Program
from heavylift.kernel.model.switching import StateEvent
from heavylift.kernel.simulation.native.sample_row import labels, row_layout

from .island import Island

__all__ = ["Joining", "news"]

Rows = list[tuple[int, np.ndarray]]


@dataclass(frozen=True)
class _Loose:
    """A rope that nobody has hooked: columns of its length and of what its ends are apart from that, the sign of the
    latter, numbers of its lines, links at their ends."""

    length: int
    apart: int
    sign: float
    lines: np.ndarray
    ends: list[tuple[int, int]]

    def span(self, frames: np.ndarray) -> float:
        """Length of the way along its lines [m]; frames (n, 12): origin and rotation of each link."""
        out = 0.0
        for line, ends in zip(self.lines.reshape(-1, ROPE_LINE), self.ends, strict=True):
            places = [
                p if i < 0 else (exact(frames[i, :3]) + exact(frames[i, 3:].reshape(3, 3)) @ exact(p)).astype(float)
                for i, p in zip(ends, (line[:3], line[3:6]), strict=True)
            ]
            out += float(line[6]) * norm((places[0] - places[1]).tolist())
        return out


class Joining:
    """Rows of the whole scene; `period`: of samples [ns]."""

    def __init__(self, program: Program, period: int) -> None:
        self._place = {label: i for i, label in enumerate(labels(program))}
        self._period = period
        self._program, self._at = program, row_layout(program).at
        self._places: list[np.ndarray] = []
        self.number = 1  # of the next periodic sample
        self.struck: Rows = []  # rows of events that wait for samples before them

    def cut(self, parts: Sequence[Island], loose: frozenset[str]) -> None:
        """These are the islands from here on, and the ropes that tie nothing."""
        self._places = [np.array([self._place[x] for x in labels(p.program)], dtype=int) for p in parts]
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
        """One row of all: energies and steps add up, all else is of one island but what loose ropes span."""
        row = np.zeros(len(self._place))
        for at, part in zip(self._places, parts, strict=True):
            row[at] += part
        frames = row[self._at["poses"]].reshape(-1, 12)
        for rope in self._loose:
            row[rope.apart] = rope.sign * (rope.span(frames) - row[rope.length])
        return row

    @property
    def next_ns(self) -> int:
        """Time of the next periodic sample [ns]."""
        return self.number * self._period

    def take(self, samples: Sequence[Rows], resting: Sequence[np.ndarray | None]) -> Rows:
        """Rows that are complete; taken from `samples` of each island, and from the row in which it rests, if so."""
        out: Rows = []
        before: list[np.ndarray] = []
        while True:
            t = self.next_ns
            ready = [bool(rows) and rows[0][0] == t for rows in samples]
            if not any(ready) or not all(r or x is not None for r, x in zip(ready, resting, strict=True)):
                break
            out += self._struck(t)
            now = [rows.pop(0)[1] if r else x for r, rows, x in zip(ready, samples, resting, strict=True)]
            parts = [x for x in now if x is not None]
            if len(parts) != len(before) or any(a is not b for a, b in zip(parts, before, strict=True)):
                row, before = self.whole(parts), parts
            out.append((t, row))  # the same one as long as all rest
            self.number += 1
        return out + self._struck(self.next_ns)

    def _struck(self, before: int) -> Rows:
        out = [x for x in self.struck if x[0] < before]
        self.struck = self.struck[len(out) :]
        return out


def news(parts: Sequence[Island]) -> tuple[list[tuple[int, StateEvent]], list[Note]]:
    """What islands have logged and noted since it was asked last, in the order of time."""
    log: list[tuple[int, int, StateEvent]] = []
    notes: list[Note] = []
    for k, p in enumerate(parts):
        entries, noted = p.told
        log += [(t, k, e) for t, e in p.log[entries:]]
        notes += p.notes[noted:]
        p.told = len(p.log), len(p.notes)
    return [(t, e) for t, _, e in sorted(log, key=lambda x: x[:2])], sorted(notes, key=lambda note: note.t_ns)
