"""Dormand-Prince 5(4) with error control, dense output, located guards and sampling, as branch-free functions of one
state block X; loops around them make one native call (Hairer, Norsett, Wanner, Solving ODEs I, II.4-II.6).

The last accepted step stays *tentative*: its samples and peaks count only when the next call commits it, so that an
input inside it can discard it.  A guard that falls below zero in a step is located in the dense output to a quarter of
a nanosecond; what then happens is not decided here.
"""

from __future__ import annotations

from collections.abc import Callable
from types import SimpleNamespace
from typing import Any

import numpy as np

from .elementary import power
from .emit import While
from .evaluation import Evaluation
from .function import Function, flatten
from .layout import Layout
from .rate import Program
from .symbol import any_of, maximum, minimum, select, sqrt

__all__ = ["BREAK", "EVENT", "FAILED", "RUNNING", "STILL", "Dopri5"]

C = [0, 1 / 5, 3 / 10, 4 / 5, 8 / 9, 1, 1]
A: list[list[float]] = [
    [],
    [1 / 5],
    [3 / 40, 9 / 40],
    [44 / 45, -56 / 15, 32 / 9],
    [19372 / 6561, -25360 / 2187, 64448 / 6561, -212 / 729],
    [9017 / 3168, -355 / 33, 46732 / 5247, 49 / 176, -5103 / 18656],
    [35 / 384, 0, 500 / 1113, 125 / 192, -2187 / 6784, 11 / 84],
]
E = [71 / 57600, 0, -71 / 16695, 71 / 1920, -17253 / 339200, 22 / 525, -1 / 40]
D = [
    -12715105075 / 11282082432, 0, 87487479700 / 32700410799, -10690763975 / 1880347072,
    701980252875 / 199316789632, -1453857185 / 822651844, 69997945 / 29380423,
]  # fmt: skip

RUNNING, BREAK, EVENT, STILL, FAILED = 0.0, 1.0, 2.0, 3.0, 4.0  # why a native call returned
LOCATED = 2.5e-10  # [s] width to which a guard's root is bracketed
STILL_SQUARE = 1e-14  # |v|^2 and |dv/dt|^2 of a scene at rest [SI]

Rate = Callable[[Any, Any, Any], Any]  # (t, a time inside the step, y) -> dy, T, G

_SCALARS = (
    # control: loop flags, then why it stopped, attempts left in this call
    "run", "due", "locate", "status", "budget",
    # time: now, proposed step, step boundary that no step crosses, horizon behind which steps stay tentative
    "t", "h", "t_stop", "until",
    # tolerance and step control, earliest time at which a scene may count as still
    "tol", "h_min", "h_max", "error", "forced", "t_rest",
    "accepted", "rejected", "tentative", "still",
    # last step: start, length, bracket of a root, whether only a stage has seen it, status and loop without it
    "t0", "h0", "lo", "hi", "doubt", "calm", "more",
    # samples: next, period, local time of sample 0 of this stretch, number within the stretch, row, rows allowed
    "t_out", "dt_out", "t_base", "count", "row", "rows",
)  # fmt: skip


def combine(c: list[float], k: list[Any]) -> Any:
    return sum(a * x for a, x in zip(c, k, strict=False) if a)


def dense(s: SimpleNamespace, x: Any) -> Any:
    """Fourth-order solution at t0 + x h0 inside the last step."""
    return s.d0 + x * (s.d1 + (1.0 - x) * (s.d2 + x * (s.d3 + (1.0 - x) * s.d4)))


def inside(s: SimpleNamespace) -> Any:
    """A time in the piece of the profiles that begins at t: no step crosses t_stop, where the next one begins."""
    return s.t + 0.5 * minimum(1.0, s.t_stop - s.t)


def step(s: SimpleNamespace, rate: Rate, n_error: float) -> None:
    """One attempt from (t, y, f); f is the derivative at y (first same as last).  `forced` accepts whatever comes.

    Guards are looked at in every stage, so that one that falls and recovers within the step is not missed.
    """
    room = s.t_stop - s.t
    last = s.h >= room
    h = select(last, room, s.h)
    k, among = [s.f], inside(s)
    y, r = s.y, s
    below, earliest = False, 1.0
    for c, a in zip(C[1:], A[1:], strict=True):
        y = s.y + h * combine(a, k)
        r = rate(s.t + c * h, among, y)
        k.append(r.dy)
        fell = any_of(g < 0.0 for g in r.G)
        below, earliest = any_of([below, fell]), select(below, earliest, select(fell, c, earliest))
    e = h * combine(E, k) * (1.0 / (s.tol * (1.0 + maximum(abs(s.y), abs(y)))))
    error = sqrt(e @ e * (1.0 / n_error))
    good = error <= 1.0
    ok = good | (s.forced > 0.0)
    down = select(error > 1.0, maximum(0.2, 0.9 * power(maximum(error, 1.0), -0.2)), 0.1)  # 0.1: not a number
    up = minimum(5.0, maximum(0.2, 0.9 * power(maximum(error, 1e-10), -0.14) * power(s.error, 0.04)))
    s.t0, s.h0, s.f0, s.d0, s.d1 = s.t, h, s.f, s.y, y - s.y
    s.d2 = h * k[0] - s.d1
    s.d3, s.d4 = s.d1 - h * k[6] - s.d2, h * combine(D, k)
    s.t = select(ok, select(last, s.t_stop, s.t + h), s.t)
    s.y, s.f = select(ok, y, s.y), select(ok, k[6], s.f)
    s.error = select(good, maximum(error, 1e-4), s.error)
    s.accepted, s.rejected = s.accepted + select(ok, 1.0, 0.0), s.rejected + select(ok, 0.0, 1.0)
    s.h = minimum(s.h_max, select(good, select(last, maximum(s.h, h * up), h * up), h * down))
    s.tentative = select(ok, 1.0, 0.0)
    s.T = select(ok, r.T, s.T)
    ended = any_of(g < 0.0 for g in r.G)
    fallen = below if below is False else ok & below
    s.locate = select(fallen, 1.0, 0.0)
    s.doubt = select(ended, 0.0, 1.0)
    s.lo, s.hi = 0.0, select(ended, 1.0, earliest)
    s.G = r.G
    s.budget = s.budget - 1.0
    s.more = select(s.budget > 0.0, select(s.rows > s.row, select(s.until >= s.t, 1.0, 0.0), 0.0), 0.0)
    s.calm = select(s.h < s.h_min, FAILED, select(s.still > 0.0, STILL, select(ok & last, BREAK, RUNNING)))
    go_on(s, select(fallen, select(s.calm > BREAK, s.calm, EVENT), s.calm))


def go_on(s: SimpleNamespace, status: Any) -> None:
    """The loop goes on while nothing has happened and there is budget, room for samples, and time."""
    s.status = status
    s.run = select(status > RUNNING, 0.0, s.more)


def bisect(s: SimpleNamespace, rate: Rate) -> None:
    """Halve the bracket [lo, hi] around the first fall of a guard in the last step; G holds the guards at hi.

    A fall that only a stage has seen is in doubt: if the solution does not show it at that time there was none.
    """
    x = select(s.doubt > 0.0, s.hi, 0.5 * (s.lo + s.hi))
    t = s.t0 + x * s.h0
    G = rate(t, t, dense(s, x)).G
    fallen = any_of(g < 0.0 for g in G)
    none = select(fallen, 0.0, s.doubt)
    s.G = select(fallen, G, s.G)
    s.lo, s.hi = select(fallen, s.lo, x), select(fallen, x, s.hi)
    s.locate = select(none > 0.0, 0.0, select((s.hi - s.lo) * s.h0 > LOCATED, 1.0, 0.0))
    s.doubt = 0.0
    go_on(s, select(none > 0.0, s.calm, s.status))


def commit(s: SimpleNamespace, quaternions: list[int], velocities: slice) -> None:
    """The tentative step becomes history: peaks of the tensions, samples that are due, unit quaternions.

    `still` is set when all velocities and accelerations vanish after the last command has run out.
    """
    higher = [(s.tentative > 0.0) & (p < T) for T, p in zip(s.T, s.peak, strict=True)]
    s.peak = np.array([select(c, T, p) for c, T, p in zip(higher, s.T, s.peak, strict=True)], dtype=object)
    s.peak_time = np.array([select(c, s.t, p) for c, p in zip(higher, s.peak_time, strict=True)], dtype=object)
    y = s.y.copy()
    for i in quaternions:
        q = s.y[i : i + 4]
        y[i : i + 4] = q * (1.0 / sqrt(q @ q))
    s.y = y
    slow = [sum(e * e for e in x[velocities]) < STILL_SQUARE for x in (s.y, s.f)]
    s.still = select(s.t >= s.t_rest, select(slow[0], select(slow[1], 1.0, 0.0), 0.0), 0.0)
    s.due = select(s.tentative > 0.0, select(s.t >= s.t_out, 1.0, 0.0), 0.0)
    s.tentative = 0.0


def refresh(s: SimpleNamespace, rate: Rate) -> None:
    """After a change of state, laws or discrete states: derivative, tensions and guards at (t, y)."""
    r = rate(s.t, inside(s), s.y)
    s.f, s.T, s.G = r.dy, r.T, r.G
    s.tentative = 0.0


def look(s: SimpleNamespace, row: Callable[[Any, Any], list[Any]]) -> tuple[Any, list[Any]]:
    """The state as it stands in the next free row, which stays free."""
    return s.row, [*row(s.t, s.y), *s.peak, *s.peak_time]


def sample(s: SimpleNamespace, row: Callable[[Any, Any], list[Any]]) -> tuple[Any, list[Any]]:
    """One row from the dense output of the committed step; steps are never shortened for samples."""
    values = [*row(s.t_out, dense(s, (s.t_out - s.t0) * (1.0 / s.h0))), *s.peak, *s.peak_time]
    number = s.row
    s.row, s.count = number + 1.0, s.count + 1.0
    s.t_out = s.t_base + s.count * s.dt_out
    s.peak = s.peak * 0.0
    s.due = select(s.t >= s.t_out, 1.0, 0.0)
    return number, values


class Dopri5:
    """The native functions of one program: `advance` (the loop), and step, commit, sample, bisect, refresh, look."""

    def __init__(self, program: Program) -> None:
        p = self.program = program
        nq, nv = p.nq, p.nv
        n_ropes, n_guards = len(p.system.ropes), len(p.guards)
        states = dict.fromkeys(("y", "f", "f0", "d0", "d1", "d2", "d3", "d4"), p.ny)
        ropes = dict.fromkeys(("T", "peak", "peak_time"), n_ropes)
        sizes = {**dict.fromkeys(_SCALARS), **states, **ropes, "G": n_guards}
        self.layout = Layout(sizes, frozenset(states))
        self.plain = Layout(sizes)
        n_p = len(p.parameters.initial)
        self.row_layout = self._row_layout()
        self.columns = self.row_layout.size

        def evaluate(t: Any, y: Any, P: Any) -> dict[str, Any]:
            x = p.evaluate(t[0], y, P, t[1])
            return {"dy": x.dy, "T": x.tensions, "G": x.guards}

        state = {"t": 1, "y": p.ny, "P": n_p}
        self.f_rate = Function("rate", evaluate, {**state, "t": 2}, vectors=["dy"])
        self.f_row = Function("row", lambda t, y, P: {"values": self.row(p.evaluate(t[0], y, P))}, state, ["values"])
        self.functions = {
            "step": self._on_block("step", lambda s, rate, row: step(s, rate, float(nq + nv))),
            "bisect": self._on_block("bisect", lambda s, rate, row: bisect(s, rate)),
            "commit": self._on_block(
                "commit", lambda s, rate, row: commit(s, p.quaternions, slice(nq, nq + nv)), plain=True
            ),
            "sample": self._on_block("sample", lambda s, rate, row: sample(s, row), table=True),
            "refresh": self._on_block("refresh", lambda s, rate, row: refresh(s, rate)),
            "look": self._on_block("look", lambda s, rate, row: look(s, row), table=True),
        }
        at, f = self.layout.at, self.functions
        sampling = While("sampling", at["due"], (f["sample"],))
        locating = While("locating", at["locate"], (f["bisect"],))
        self.advance = While("advance", at["run"], (f["commit"], sampling, f["step"], locating))

    def _row_layout(self) -> Layout:
        """Columns of a sample row: state, accounts, laws, poses (origin and rotation, 12 a body), energies, peaks."""
        p = self.program
        ropes, supports = len(p.system.ropes), len(p.system.supports)
        sizes: dict[str, int | None] = {"q": p.nq, "v": p.nv, "accounts": len(p.accounts)}
        sizes |= dict.fromkeys(("tension", "length", "length_rate", "elongation"), ropes)
        sizes |= {
            "normal": supports,
            "place": 2 * supports,
            "velocity": 2 * supports,
            "stored": len(p.stored),
        }
        sizes |= {"poses": 12 * len(p.graph.links), "kinetic": None, "potential": None}
        return Layout(sizes | {"peak": ropes, "peak_time": ropes})

    def row(self, x: Evaluation) -> list[Any]:
        """The columns of `_row_layout` without the peaks."""
        poses, kinetic, potential = x.poses_and_energies()
        parts = (x.q, x.v, x.accounts, x.tensions, x.lengths, x.length_rates, x.elongations, x.normals)
        flat = [e for part in parts for e in part]
        return [*flat, *x.places, *x.velocities, *x.stored, *poses, kinetic, potential]

    def _on_block(self, name: str, part: Callable[..., Any], table: bool = False, plain: bool = False) -> Function:
        """A function of the blocks X and P (and a table) made of `part(s, rate, row)`."""
        layout = self.plain if plain else self.layout

        def body(X: Any, P: Any) -> dict[str, Any]:
            s = layout.unpack(X)
            r = part(
                s,
                lambda t, among, y: self.f_rate(t=[t, among], y=y, P=P),
                lambda t, y: flatten(self.f_row(t=[t], y=y, P=P).values),
            )
            return {"X": layout.pack(s), **({"table": r} if table else {})}

        return Function(name, body, {"X": layout.size, "P": len(self.program.parameters.initial)})
