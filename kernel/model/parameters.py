"""Where each number of a scene lives in the parameter block P that the machine code reads.

Masses, geometry, laws, references and discrete states are run-time numbers: between native calls the simulation
writes them, so hooking, switching and commands never compile anything.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from heavylift.kernel.constraints.contact.contact_points import contact_numbers
from heavylift.kernel.constraints.loop_closures import closure_numbers
from heavylift.kernel.constraints.rigid_ropes import rigid_numbers
from heavylift.kernel.description.mechanics import Brake, Drive, Rope, System
from heavylift.kernel.forces.table import SharedForce
from heavylift.kernel.multibody.graph import Graph
from heavylift.kernel.multibody.trees import Tree, numbers

__all__ = [
    "PROFILE", "ROPE_HEAD", "ROPE_LINE", "SUPPORT", "BrakeAt", "Parameters", "RopeAt", "StopAt", "SupportAt",
]  # fmt: skip

PROFILE = 8  # start, x0, v0, a1, d1, cruise, a2, d2
ROPE_HEAD, ROPE_LINE = 4, 7  # numbers of a rope, and of each of its lines: a(3), b(3), share
SUPPORT = 15  # numbers of a support


class RopeAt:
    """Places of a rope's numbers; a and b are the end points of its first line."""

    EA, DAMPING, HOOKED, TAUT = range(4)
    A, B = slice(4, 7), slice(7, 10)


class SupportAt:
    """Places of a support's numbers, behind its point (3)."""

    HEIGHT, K, D, MU, KT, DT, CLOSED, STICK = range(3, 11)
    ANCHOR, DIRECTION = slice(11, 13), slice(13, 15)


class StopAt:
    """Places of an end stop's numbers."""

    LOWER, UPPER, K, D, AT_LOWER, AT_UPPER = range(6)


class BrakeAt:
    """Places of a brake's numbers."""

    MOMENT, K, D, ENGAGED, STICK, ANCHOR, DIRECTION = range(7)


def _rope_numbers(rope: Rope, gravity: float) -> list[float]:
    """EA, damping, hooked, taut and the lines of a rope, and, if it has any, its weight."""
    lines = [x for line in rope.lines for x in (*line.a.p, *line.b.p, line.share)]
    own = [rope.mass * gravity] if rope.mass else []
    return [rope.EA, rope.damping, float(rope.hooked), 0.0, *lines, *own]


@dataclass(frozen=True)
class Parameters:
    """Slices of P by kind and name; `initial` is P at the start of a run."""

    at: dict[tuple[str, str], slice]
    initial: np.ndarray  # (n,)

    @staticmethod
    def of(system: System, graph: Graph, trees: list[Tree], forces: tuple[SharedForce, ...] = ()) -> Parameters:
        """Lay out a system; references rest at their initial values, thresholds are disarmed."""
        at: dict[tuple[str, str], slice] = {}
        values: list[float] = []

        def put(kind: str, name: str, numbers_: list[float]) -> None:
            at[kind, name] = slice(len(values), len(values) + len(numbers_))
            values.extend(numbers_)

        put("gravity", "", [system.gravity])
        for i, tree in enumerate(trees):
            put("tree", str(i), numbers(tree))
        masters = [*system.masters, *system.measured]
        for m in system.masters:
            put("reference", m.name, [0.0, m.value] + [0.0] * (PROFILE - 2))
        q0 = [x for k in graph.links for x in k.q0]

        def at_start(law: Drive | Brake) -> float:
            return q0[graph.coordinate(law.name, law.joint, law.coordinate)[0]]

        starts = [(d.name, at_start(d)) for d in system.drives]
        starts += [(r.name, r.L0) for r in system.straight_ropes]
        signals = [(f.name, signal) for f in forces if (signal := f.law.signal(f.force))]
        starts += [(name, x.value) for name, x in signals if x.driven]
        for name, x0 in starts:
            put("reference", name, [0.0, x0] + [0.0] * (PROFILE - 2))
            put("follow", name, [0.0] * 3 * len(masters))
        for link in graph.links:
            if link.modes:
                put("modes", link.body.name, [*link.modes.stiffness, *link.modes.damping])
            if link.modes and link.n_modes:
                put("bending", link.body.name, link.modes.smallness.numbers)
        for d in system.drives:
            put("drive", d.name, [d.kp, d.kv])
        for s in system.springs:
            put("spring", s.name, [s.k, s.d, s.q_rest])
        for x in system.stops:
            put("stop", x.name, [x.lower, x.upper, x.k, x.d, 0.0, 0.0])
        for b in system.brakes:
            put("brake", b.name, [b.moment, b.k, b.d, float(b.engaged), 1.0, at_start(b), 0.0])
        for r in system.ropes:
            put("rope", r.name, _rope_numbers(r, system.gravity))
        for u in system.supports:
            laws = [u.height, u.k, u.d, u.mu, u.kt, u.dt]
            put("support", u.name, [*u.point.p, *laws, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0])
        for name, signal in signals:
            put("signal", name, [0.0, signal.value, 0.0])
        for f in forces:
            put("force", f.name, f.numbers)
        if any(f.law.timed for f in forces):
            put("clock", "", [0.0])  # time of the run at the epoch
        for rigid in system.rigid_ropes:
            put("rigid", rigid.name, rigid_numbers(rigid))
            if rigid.mass:
                put("weight", rigid.name, [rigid.mass * system.gravity])
        for j in graph.loops:
            put("loop", j.name, closure_numbers(j))
        weight = system.gravity * sum(b.mass for b in system.bodies)
        for c in system.contacts:
            for (kind, name), numbers_ in contact_numbers(c, abs(weight)).items():
                put(kind, name, numbers_)
        for h in system.thresholds:
            put("threshold", h.name, [0.0, 1.0, *(h.point.p if h.point else (0.0, 0.0, 0.0))])
        return _side_by_side(at, np.array(values))


def _side_by_side(at: dict[tuple[str, str], slice], initial: np.ndarray) -> Parameters:
    """The same numbers with those of equal laws and trees next to each other, first by first, second by second: so
    vector calls load them at once (see `simd_batches`)."""
    groups: dict[tuple[str, int], list[tuple[str, str]]] = {}
    for key, s in at.items():
        groups.setdefault((key[0], s.stop - s.start), []).append(key)
    out: dict[tuple[str, str], slice] = {}
    values = np.empty_like(initial)
    first = 0
    for (_, size), keys in groups.items():
        last = first + size * len(keys)
        for i, key in enumerate(keys):
            out[key] = slice(first + i, last, len(keys))
            values[out[key]] = initial[at[key]]
        first = last
    return Parameters({key: out[key] for key in at}, values)
