"""Solver of Coulomb friction: which contacts push, which of these stick and which slide, around the pivoting solver.

A contact has three rows: normal and two tangents. Sticking, its tangents are constrained (w_t = 0, |x_t| <= mu x_n).
Sliding along the unit vector u, friction is part of the effect of its normal row, x_t = -mu x_n u, and u is the
direction of w_t. The same conditions hold for impulses (w: velocity after the impact) and for forces (w: acceleration);
the u of a contact that already slides is given. The cone is exact, not a pyramid: u is iterated. Signorini and Coulomb
as in Glocker, Set-Valued Force Laws (2001), ch. 5-7; no solution at all: Painleve.

It also determines which contact places can slip away, and which are only at the limit of friction while others hold.
The force of a contact at several places is indeterminate: some places may reach Coulomb's limit long before the body
moves. A place slips if the pushing and the sticking contacts leave it free to move along its direction of sliding, so
that a contact slips only if no distribution of forces within all cones holds it.
"""

from dataclasses import dataclass
from math import sqrt

import numpy as np
from heavylift.kernel.algebra.dense import dot
from heavylift.kernel.algebra.elementary import cos, sin
from heavylift.kernel.constraints.complementarity import eliminate, solve

from .regularised_friction import regularised, sweep

ROUNDS = 30  # changes between stick and slip, and turns of the directions
TOGETHER = 10  # rounds in which all contacts change at once, before they do one by one
FARTHEST = 0.7  # [rad] that a direction is turned at once
CLEAR = 1e-6  # relative size of a normal velocity or acceleration that is left when a set is clear
EASY = 0.9  # part of the limit of friction below which they need no better one
TURN = 1e-12  # [rad] that is round-off
LEAST = 1e-3  # part of the largest normal force below which a contact's share of friction is not lowered
SMALL = 1e-9  # relative size of what counts as zero
CREEP = 1e-6  # relative size of an acceleration against a slip that begins


@dataclass(frozen=True)
class ContactProblem:
    """Impact or force problem of m contacts with Coulomb friction, with three rows each: normal, tangent, tangent."""

    A: np.ndarray  # (3m, 3m) Delassus matrix
    b: np.ndarray  # (3m,) free velocity or acceleration of the rows
    mu: np.ndarray  # (m,)
    moving: np.ndarray  # (m, 2) direction of contacts that slide already, otherwise zero
    size: np.ndarray | None = None
    """Softness (3m,) of the rows: redundant rows share forces in proportion to it (None: to the diagonal of A)."""


@dataclass(frozen=True)
class FrictionSolution:
    """Solution of a contact problem: impulses or forces, resulting motion, and which contacts push, stick or slide.

    `found` is False if no set fulfils all conditions.
    """

    x: np.ndarray  # (3m,) impulses or forces
    w: np.ndarray  # (3m,) velocities or accelerations
    push: np.ndarray  # (m,) booleans
    stick: np.ndarray  # (m,) booleans
    u: np.ndarray  # (m, 2) directions of sliding
    share: np.ndarray  # (m, 2) friction shares if not unique
    prior: np.ndarray  # (3m,) reference for forces that are not unique
    found: bool


def settle(c: ContactProblem) -> FrictionSolution:
    """Return the solution of a contact problem with Coulomb friction: which contacts push, stick and slide."""
    m = len(c.mu)
    given = np.abs(c.moving).sum(axis=1) > 0.0
    stick, u, share, prior, side = _begin(c, given)
    for n in range(ROUNDS):
        f, side = _inner(c, stick, u, share, prior, side)
        if not f.found:
            break
        # relative to the largest force and acceleration, since scenes range from grams to kilotonnes
        size_x, size_w = SMALL * np.abs(f.x).max(initial=0.0), CREEP * np.abs(c.b).max(initial=0.0)
        changed = False
        for i in range(m):
            if given[i] or c.mu[i] == 0.0 or not (f.push[i] or stick[i]):
                continue
            t, v = f.x[3 * i + 1 : 3 * i + 3], f.w[3 * i + 1 : 3 * i + 3]
            held = sqrt(t[0] * t[0] + t[1] * t[1])
            # beyond the cone: it slides against the force that would have held it
            if stick[i] and held > c.mu[i] * f.x[3 * i] + size_x:
                stick[i], u[i], changed = False, -t / held, True
            elif not stick[i] and v[0] * u[i, 0] + v[1] * u[i, 1] < -size_w:
                # friction that would accelerate the slip does not exist: it sticks after all
                stick[i], changed = True, True
            # after TOGETHER rounds one change at a time, or sets that exclude each other would alternate
            if changed and n >= TOGETHER:
                break
        turns = ~given & ~stick & f.push & (c.mu > 0.0) & (np.abs(f.w.reshape(m, 3)[:, 1:]).max(axis=1) > size_w)
        # directions are improved only once the sets agree, as each change of sets moves them
        if not changed and turns.any():
            changed = _turn(c, f, turns, u) > TURN
        if not changed:
            return f
    return _swept(c)


def _begin(
    c: ContactProblem, given: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray, dict[int, float]]:
    """Return which contacts stick at first, sliding directions, friction shares, prior forces, and the sides of the
    pivoting solution."""
    stick, u, share = ~given & (c.mu > 0.0), c.moving.copy(), np.ones((len(c.mu), 2))
    prior = np.zeros(3 * len(c.mu))
    if not stick.any():
        return stick, u, share, prior, {}
    f, side = _inner(c, stick, u, share, prior, {})
    limit, held = c.mu * f.x[::3], np.sqrt(f.x[1::3] * f.x[1::3] + f.x[2::3] * f.x[2::3])
    # far from the cone's limit any distribution of indeterminate forces does
    if not f.found or not limit[stick].max() > 0.0 or (held[stick] <= EASY * limit[stick]).all():
        return stick, u, share, prior, side
    r = regularised(c.A, c.b, c.mu, c.moving, _size(c), f.x)
    if r is None:
        return stick, u, share, prior, side
    x, slides, along, soft = r
    u[slides] = along[slides]
    share = np.sqrt(np.maximum(soft.min() / soft, LEAST))
    return stick & ~slides, u, share, prior if slides.any() else x, side


def _swept(c: ContactProblem) -> FrictionSolution:
    """Return the active set found by Gauss-Seidel sweeps, for forces that are not unique."""
    m = len(c.mu)
    x, found = sweep(c.A, c.b, c.mu, c.moving)
    w = _velocities(c, x)
    most = float(np.abs(c.b).max(initial=0.0))
    size = SMALL * most
    # at the very limit of friction sweeps creep; which contacts push, stick and slide is clear long before
    found = found or bool(np.isfinite(x).all() and w[::3].min() > -CLEAR * most)
    speed = np.sqrt(w[1::3] * w[1::3] + w[2::3] * w[2::3])
    u = np.where(speed[:, None] > size, w.reshape(m, 3)[:, 1:] / np.maximum(speed, size)[:, None], 0.0)
    u = np.where(c.moving != 0.0, c.moving, u)
    return FrictionSolution(
        x, w, x[::3] > 0.0, (np.abs(u).sum(axis=1) == 0.0) & (c.mu > 0.0), u, _share(x), np.zeros(3 * m), found
    )


def _share(x: np.ndarray) -> np.ndarray:
    """Return friction shares (m, 2) by normal forces, so that contacts reach the friction limit together."""
    most = float(x[::3].max(initial=0.0))
    share = np.sqrt(np.maximum(x[::3] / most, LEAST)) if most > 0.0 else np.ones(len(x) // 3)
    return np.stack([share, share], axis=1)


def _velocities(c: ContactProblem, x: np.ndarray) -> np.ndarray:
    """Return w = A x + b, summed column by column."""
    w = c.b.copy()
    for k in range(len(x)):
        w += c.A[:, k] * x[k]
    return w


def _across(c: ContactProblem, i: int, u: np.ndarray) -> np.ndarray:
    """Return the effect of unit friction of contact i along u on all rows."""
    out: np.ndarray = c.A[:, 3 * i + 1] * u[0] + c.A[:, 3 * i + 2] * u[1]
    return out


def _turn(c: ContactProblem, f: FrictionSolution, turns: np.ndarray, u: np.ndarray) -> float:
    """Do a Newton step for the directions of contacts that begin to slide, u x w_t = 0; return the largest angle.

    The unknowns are also the normal forces and the sticking tangents: equations w_n = 0, w_t = 0, unknowns x_n, x_t and
    the angles.
    """
    rows, columns, right = [], [], []
    for i in np.flatnonzero(f.push):
        n, t = 3 * i, slice(3 * i + 1, 3 * i + 3)
        rows.append(np.eye(len(c.b))[n])
        columns.append(c.A[:, n] if f.stick[i] else c.A[:, n] - c.mu[i] * _across(c, int(i), u[i]))
        right.append(0.0)
        if f.stick[i]:
            rows += list(np.eye(len(c.b))[t])
            columns += list(c.A[:, t].T)
            right += [0.0, 0.0]
    first = len(rows)
    for i in np.flatnonzero(turns):
        t, across = slice(3 * i + 1, 3 * i + 3), np.array([-u[i, 1], u[i, 0]])
        row = np.zeros(len(c.b))
        row[t] = across
        rows.append(row)
        columns.append(-c.mu[i] * f.x[3 * i] * _across(c, int(i), across))
        right.append(-float(across[0] * f.w[t][0] + across[1] * f.w[t][1]))
    J = np.array([[dot(r.tolist(), k.tolist()) for k in columns] for r in rows])
    for a, i in enumerate(np.flatnonzero(turns)):
        J[first + a, first + a] -= u[i, 0] * f.w[3 * i + 1] + u[i, 1] * f.w[3 * i + 2]
    # keeps a singular row, such as of a body without freedom to turn, from blowing up the angles
    soft = 1e-9 * np.abs(np.diag(J)).max()
    angle = eliminate(J + soft * np.diag(np.sign(np.diag(J))), np.array(right), np.ones(len(right)))[first:]
    # a large turn may pass the solution; FARTHEST keeps Newton within its sector
    for i, e in zip(np.flatnonzero(turns), np.clip(angle, -FARTHEST, FARTHEST), strict=True):
        a, b = cos(float(e)), sin(float(e))
        u[i] = [a * u[i, 0] - b * u[i, 1], b * u[i, 0] + a * u[i, 1]]
    return float(np.abs(angle).max())


def _size(c: ContactProblem) -> np.ndarray:
    """Return the compliance (3m,) of each row; negligible for a tangent that a joint blocks."""
    size = np.diag(c.A) if c.size is None else c.size
    out: np.ndarray = np.maximum(size, SMALL * size.max(initial=0.0))
    return out


def _inner(
    c: ContactProblem, stick: np.ndarray, u: np.ndarray, share: np.ndarray, prior: np.ndarray, side: dict[int, float]
) -> tuple[FrictionSolution, dict[int, float]]:
    """Solve for the normal forces with given sticking contacts and sliding directions."""
    m = len(c.mu)
    rows = [k for i in range(m) for k in (3 * i, 3 * i + 1, 3 * i + 2)[: 3 if stick[i] else 1]]
    columns = c.A.copy()
    for i in np.flatnonzero(~stick):
        for k in (0, 1):
            # friction of a sliding contact acts with its normal force: x_t = -mu x_n u enters the column of the normal
            columns[:, 3 * i] -= c.mu[i] * u[i, k] * c.A[:, 3 * i + 1 + k]
    normal = np.array([k % 3 == 0 for k in rows])
    lo = np.where(normal, 0.0, -np.inf)
    start = np.array([side.get(k, -1.0 if k % 3 == 0 else 0.0) for k in rows])
    # so that the solver regularises each row in proportion to its own diagonal, as the constraint rows are
    scale = np.array([1.0 if k % 3 == 0 else share[k // 3, k % 3 - 1] for k in rows]) / np.sqrt(_size(c)[rows])
    A = columns[np.ix_(rows, rows)] * scale[:, None] * scale
    s = solve(A, c.b[rows] * scale, lo, np.full(len(rows), np.inf), start, prior[rows] / scale)
    x = np.zeros(3 * m)
    x[rows] = s.x * scale
    push = np.zeros(m, bool)
    push[[k // 3 for k, side_k in zip(rows, s.side, strict=True) if k % 3 == 0 and side_k == 0.0]] = True
    for i in np.flatnonzero(~stick):
        x[3 * i + 1 : 3 * i + 3] = -c.mu[i] * x[3 * i] * u[i]
    w = _velocities(c, x)
    return FrictionSolution(x, w, push, stick.copy(), u.copy(), share, prior, s.found), dict(
        zip(rows, s.side, strict=True)
    )


SOFT = 1e-11  # regularisation of redundant rows, relative
HELD = 1e-6  # part of its own mobility below which a place is held by others
REST = 1e-2  # part of the largest acceleration of what slides below which a place is at rest beside it


def mobile(A: np.ndarray, f: FrictionSolution) -> np.ndarray:
    """Return for each contact (m,) whether it is at its friction limit and free to move along its sliding direction.

    f.u: these directions; A: (3m, 3m) Delassus matrix of all contacts.
    """
    m = len(f.push)
    rows = [3 * i + k for i in range(m) if f.push[i] for k in range(3 if f.stick[i] else 1) if A[3 * i + k, 3 * i + k]]
    out = np.zeros(m, bool)
    if not rows:
        return out
    fixed = A[np.ix_(rows, rows)]
    scale = 1.0 / np.sqrt(np.diag(fixed))
    fixed = fixed * scale[:, None] * scale + SOFT * np.eye(len(rows))
    speeds = np.sqrt(f.w[1::3] * f.w[1::3] + f.w[2::3] * f.w[2::3])
    for i in range(m):
        along = slice(3 * i + 1, 3 * i + 3)
        if not f.push[i] or f.stick[i] or not f.u[i].any() or speeds[i] < REST * speeds.max():
            continue
        response = (A[:, along] * f.u[i]).sum(axis=1)
        own = float((response[along] * f.u[i]).sum())
        side = response[rows] * scale
        # mobility along u less what the other contacts hold of it: a Schur complement
        held = float((side * eliminate(fixed, side, np.ones(len(rows)))).sum())
        # round-off leaves a little even where the others hold it completely
        out[i] = own - held > HELD * own
    return out
