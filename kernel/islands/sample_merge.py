"""Samples of a scene from those of its islands: one row of all columns per time, in the order of time.

Islands step as they like, so their samples come at different moments of the run, but at the same times; a row is
complete when all islands that move have given their part, and one that rests gives the row in which it rests.  What an
event or a command has changed is shown in a row of its own.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from heavylift.kernel.algebra.dense import norm
from heavylift.kernel.algebra.spatial import exact
from heavylift.kernel.constraints.rigid_ropes import RigidAt
from heavylift.kernel.description.mechanics import RigidRope, Rope
from heavylift.kernel.forces.ropes import ROPE_HEAD, ROPE_LINE
from heavylift.kernel.model.program import Program
from heavylift.kernel.simulation.native.sample_row import row_layout

if TYPE_CHECKING:
    from heavylift.kernel.simulation.simulation import Simulation

__all__ = ["Joining", "labels"]

Label = tuple[str, str, int]  # group of columns, whose, which of its own
Rows = list[tuple[int, np.ndarray]]


def labels(program: Program) -> list[Label]:
    """What stands in each column of a program's rows."""
    s, links = program.system, sorted(program.graph.links, key=lambda k: k.q.start)
    names: dict[str, list[str]] = {
        "q": [k.body.name for k in links for _ in range(k.q.start, k.q_modes.stop)],
        "v": [k.body.name for k in sorted(links, key=lambda k: k.v.start) for _ in range(k.v.start, k.v_modes.stop)],
        "accounts": [f"{what} {name}" for what, name in program.accounts],
        "turned": [f"{kind} {name} {i}" for kind, name, i in program.angles],
        "stored": [name for _, name in program.stores],
        **{group: [name for (_, name), _, _ in columns] for group, columns in program.columns.items()},
        "poses": [k.body.name for k in program.graph.links for _ in range(12)],
        "kinetic": [""],
        "potential": [""],
        "steps": [""],
        "loop": [j.name for j in program.graph.loops for _ in range(6)],
        "pressing": [c.name for c in s.contacts],
        "axial": [program.graph.links[i].body.name for i in program.axial],
    }
    names |= {key: [r.name for r in s.ropes] for key in ("length", "length_rate")}
    names |= {key: [r.name for r in s.rigid_ropes] for key in ("pull", "slack", "span")}
    names |= {key: [r.name for r in s.straight_ropes] for key in ("peak", "peak_time")}
    out: list[Label] = []
    for group in row_layout(program).at:
        own = names[group]
        out += [(group, name, own[:i].count(name)) for i, name in enumerate(own)]
    return out


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

    def cut(self, parts: Sequence[Simulation], loose: frozenset[str]) -> None:
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
