"""Rigid ropes at an event: impulses of ropes that become taut with a jerk, and which ropes are taut afterwards.

A guard becomes negative if a tension vanishes or the slack is used up; then all ropes without slack are solved
together: impulses first (a rope that snaps taut stops its ends inelastically), then tensions, each a linear
complementarity problem on the rows' matrix (Brogliato 2016, ch. 5), with loops as rows that push and pull. If one
rope's impulse slackens another whose force pulls taut again at once, both would snap in turns for ever, since events
are located only to a nanosecond: the motion of the other rope is stopped, too.
"""

from dataclasses import dataclass
from math import fsum

import numpy as np
from heavylift.kernel.constraints.complementarity import product, solve
from heavylift.kernel.constraints.row_structure import TOUCHING, RigidAt
from heavylift.kernel.errors import KernelError
from heavylift.kernel.model.evaluation import evaluate
from heavylift.kernel.model.program import Program

RESTING = 1e-9  # [m/s] speed that is none
RESOLVED = 5e-5  # [s] a rope that forces pull taut again within it after an impulse has not parted
WIDE = 1e4  # ratio of what an impulse does in two rows, beyond which softness for both would drown one
LEFT = 1e-4  # part of the energy of impulses that may be lost in loops by such softness


@dataclass(frozen=True)
class RopeImpactResult:
    """Result of an impact of rigid ropes: velocities (n_v,), and for each rope its state, impulse, heat and work.

    Whether it may pull, whether it is taut, its impulse [N s], heat and work [J].
    """

    v: np.ndarray
    may: list[bool]
    taut: list[bool]
    impulse: list[float]
    heat: list[float]
    work: list[float]


def resolve(program: Program, t: float, among: float, y: np.ndarray, P: np.ndarray) -> RopeImpactResult:
    """Return impulses and taut rigid ropes for a state at an event.

    Ropes that the parameters P mark as taut stay taut unless they would push. Raises KernelError if no set of taut
    ropes agrees with the forces.
    """
    constraints, ropes = program.constraints, program.system.rigid_ropes
    first = len(constraints) - len(ropes)
    slots = [program.parameters.at["rigid", r.name] for r in ropes]
    e = evaluate(program, t, y, P, among, forces=False)
    rows = e.constraint_rows()
    hooked = np.array([P[at][RigidAt.HOOKED] > 0.0 for at in slots], dtype=bool)
    close = [P[at][RigidAt.TAUT] > 0.0 or r.gap < TOUCHING for at, r in zip(slots, rows.rows[first:], strict=True)]
    may = hooked & np.array(close, dtype=bool) & rows.movable[first:]
    before = np.array([float(r.rate) for r in rows.rows])
    A = rows.matrix()
    x, after = _complementary(A, before, first, may, t)
    Q = P.copy()
    for at in slots:
        Q[at][RigidAt.TAUT] = 1.0

    def moved() -> np.ndarray:
        """Return the state (ny,) after the impulses x on the constraint rows."""
        y_after = y.copy()
        for i, dv in rows.change(x).items():
            tree = program.instances[i][0]
            y_after[program.nq + tree.v.start : program.nq + tree.v.stop] += np.array(dv, dtype=float)
        return y_after

    def forces(still: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the tensions [N] of the rigid ropes that may pull, and the accelerations of their slack [m/s2]."""
        there = evaluate(program, t, moved(), Q, among).constraint_rows()
        return _complementary(there.matrix(), np.array(there.approach(), dtype=float), first, still, t)

    still = may & ((x[first:] > 0.0) | (np.abs(after[first:]) <= RESTING))
    tension, rise = forces(still)
    back = may & ~still & (2.0 * after[first:] < -RESOLVED * rise[first:])
    if back.any():
        still |= back
        x = x + _ended(A, after, first, still)
        after = product(A, x, before)
        tension, _ = forces(still)
    mean = 0.5 * (before + after)
    speeds = [float(e.lengths_of[r.name][1]) for r in ropes]
    heat = [-float(x[first + i] * mean[first + i]) for i in range(len(ropes))]
    work = [-float(x[first + i]) * speeds[i] for i in range(len(ropes))]
    taut = [bool(f > 0.0) for f in tension[first:]]
    return RopeImpactResult(
        moved()[program.nq : program.nq + program.nv], may.tolist(), taut, x[first:].tolist(), heat, work
    )


def _ended(A: np.ndarray, speed: np.ndarray, first: int, still: np.ndarray) -> np.ndarray:
    """Return the impulses that stop the motion of the ropes `still` and of the loops."""
    rows = [*range(first), *(first + np.flatnonzero(still))]
    x = np.zeros(len(speed))
    free = np.full(len(rows), np.inf)
    x[rows] = solve(A[np.ix_(rows, rows)], speed[rows], -free, free).x
    return x


def _complementary(
    A: np.ndarray, b: np.ndarray, first: int, may: np.ndarray, t: float
) -> tuple[np.ndarray, np.ndarray]:
    """Return x and A x + b of the complementarity problem: rows before `first` are free, ropes complementary."""
    A = A + np.diag(np.where(np.diag(A) > 0.0, 0.0, 1.0))  # a row that moves nothing stands alone
    scale = _scale(np.diag(A))
    lo = np.concatenate([np.full(first, -np.inf), np.zeros(len(may))])
    hi = np.concatenate([np.full(first, np.inf), np.where(may, np.inf, 0.0)])
    found = solve(A * (scale[:, None] * scale), b * scale, lo, hi)
    if not found.found:
        raise KernelError(
            f"rigid ropes at {t:.6f} s: no set of taut ropes is consistent with the forces; make some of them elastic"
        )
    left = fsum(np.abs(found.x * found.w)[:first].tolist())
    if scale.min() < scale.max() and left > LEFT * fsum(np.abs(found.x * b * scale).tolist()):
        raise KernelError(
            f"rigid ropes at {t:.6f} s: the masses that they and the loops move differ too much to "
            "compute the impulses; make the heavy bodies lighter, or the ropes elastic"
        )
    return found.x * scale, found.w / scale


def _scale(diagonal: np.ndarray) -> np.ndarray:
    """Return scale factors for rows that move very different masses, else 1."""
    wide = diagonal.max(initial=0.0) > WIDE * diagonal.min(initial=np.inf)
    return 1.0 / np.sqrt(diagonal) if wide else np.ones(len(diagonal))
