"""Start pose with closed loops: given coordinates are kept where possible, and changes are reported.

Coordinates and speeds that a description gives are kept; those that it omits follow. First only the omitted ones move.
If that does not close the loops, the given ones move, too, by full Gauss-Newton steps, as long as these contract as
they do near a solution (Deuflhard 2004, section 2.1: near a solution an ordinary Newton step shrinks to less than half
at once). Anything else would be another branch of the linkage, or a pose far away, and is refused.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from math import degrees, inf
from typing import TYPE_CHECKING

import numpy as np
from heavylift.kernel.algebra.dense import dot, least_norm, norm, singular_values
from heavylift.kernel.algebra.elementary import atan2
from heavylift.kernel.constraints.loop_closures import closed_coordinates, closed_rates, near
from heavylift.kernel.description.mechanics import JOINTS, Joint
from heavylift.kernel.errors import KernelError
from heavylift.kernel.model.reactions.jacobian import RANK, Pose, RowGroup, pose_of

if TYPE_CHECKING:
    from heavylift.kernel.model.program import Program

SHUT = 1e-11  # scaled residual of a closed pose
NEVER_SHORTER = 1e-3  # part of a step below which it is given up
FOLLOWING = 100  # steps of what follows
NEAR = 12  # steps of Newton's method near a solution
CONTRACTS = 0.6  # by which each of them is at most as long as the one before: 0.5, and rounding
STILL = 1e-7  # scaled step below which contraction is no question
KEPT = 0.03  # what is asked moves by so much where the rest moves by one
LONGEST = 0.7  # scaled step of what follows
TRIES = 8  # start poses of what follows
ASIDE = 2.399963229728653  # [rad] the golden angle, by which tries differ
ROUNDED = 3e-4  # [rad, or of the longest lever] change that is worth no word: digits of a start value
SLOWER = 1e-3  # part of the fastest asked speed likewise

Columns = Sequence[float]


def keeping(program: Program, y: np.ndarray, P: np.ndarray, closed: Callable[[], np.ndarray]) -> np.ndarray:
    """Return the state (ny,) with loops closed near the given values; raises KernelError if that is impossible.

    `closed`: returns a pose with closed loops, however far away, or raises KernelError if there is none.
    """
    pose = pose_of(program, y, P)
    asked = _asked(program, [bool(k.joint.q0) for k in program.graph.links])
    free = [[not asked[c] for c in g.columns] for g in pose.groups]
    best = pose
    if any(map(any, free)):
        best = _followed(pose, free)
    if _size(best) > SHUT:
        found = _newton(best, [[KEPT if asked[c] else 1.0 for c in g.columns] for g in best.groups])
        if found is None:
            raise _refusal(program, pose, asked, closed())
        best = found
    out = y.copy()
    out[: program.nq] = best.q
    return out


def _asked(program: Program, given: Sequence[bool]) -> dict[tuple[int, int], bool]:
    """Return for each degree of freedom whether it belongs to a joint with given values; `given`: by link."""
    found: dict[tuple[int, int], bool] = {}
    for i, (tree, _) in enumerate(program.instances):
        for n, b in enumerate(tree.bodies):
            found |= dict.fromkeys(((i, k) for k in range(b.v.start, b.v_modes.stop)), given[tree.first + n])
    return found


def _residual(pose: Pose, g: RowGroup) -> list[float]:
    return [float(pose.rows[r].gap) / by for r, by in zip(g.rows, g.rows_by, strict=True)]


def _size(pose: Pose) -> float:
    return max((norm(_residual(pose, g)) for g in pose.groups), default=0.0)


def _step(g: RowGroup, residual: Sequence[float], weights: Columns) -> list[float]:
    """Return the step of least weighted norm with the largest reduction of the residual."""
    G = [[x * w for x, w in zip(row, weights, strict=True)] for row in g.G]
    least = RANK * max(singular_values(G), default=0.0)
    step = least_norm(G, [-x for x in residual], least)
    return [x * w for x, w in zip(step, weights, strict=True)]


def _followed(pose: Pose, free: Sequence[Sequence[bool]]) -> Pose:
    """Return the pose with the best values of dependent coordinates, from several starts."""
    best = pose
    for n in range(TRIES):
        lateral = [(g, _aside(g, f, n)) for g, f in zip(pose.groups, free, strict=True)]
        found = _descent(pose.moved(lateral) if n else pose, free)
        if _size(found) < _size(best):
            best = found
        if _size(best) <= SHUT:
            break
    return best


def _aside(g: RowGroup, free: Sequence[bool], n: int) -> list[float]:
    """Return start values number n for the dependent coordinates, with angles other than those of the pose."""
    angles = (may and by == 1.0 for may, by in zip(free, g.columns_by, strict=True))
    return [ASIDE * n * (k + 1) % 3.0 if angle else 0.0 for k, angle in enumerate(angles)]


def _descent(pose: Pose, free: Sequence[Sequence[bool]]) -> Pose:
    for _ in range(FOLLOWING):
        size = _size(pose)
        if size <= SHUT:
            break
        steps = [(g, _step(g, _residual(pose, g), list(map(float, f)))) for g, f in zip(pose.groups, free, strict=True)]
        part = min(1.0, LONGEST / max(max((norm(s) for _, s in steps), default=0.0), LONGEST))
        while part > NEVER_SHORTER:
            nearer = pose.moved([(g, [part * x for x in s]) for g, s in steps])
            if _size(nearer) < size * (1.0 - 0.1 * part):
                break
            part *= 0.5
        else:
            break
        pose = nearer
    return pose


def _newton(pose: Pose, weights: Sequence[Columns]) -> Pose | None:
    """Return the solution near a pose, None if there is none."""
    before = inf
    for _ in range(NEAR):
        if _size(pose) <= SHUT:
            return pose
        steps = [(g, _step(g, _residual(pose, g), w)) for g, w in zip(pose.groups, weights, strict=True)]
        length = norm([norm(s) for _, s in steps])
        if length > max(CONTRACTS * before, STILL) or (before == inf and length > 1.0):
            return None
        pose, before = pose.moved(steps), length
    return pose if _size(pose) <= 1e2 * SHUT else None


# ---- speeds ------------------------------------------------------------------------------------------------------


def fitting_speeds(program: Program, y: np.ndarray, P: np.ndarray) -> np.ndarray:
    """Return the state (ny,) with dependent speeds computed from the given ones; raises KernelError if the given speeds
    contradict each other."""
    pose = pose_of(program, y, P)
    asked = _asked(program, [bool(k.joint.v0) for k in program.graph.links])
    out = y.copy()
    for g in pose.groups:
        rates = [float(pose.rows[r].rate) / by for r, by in zip(g.rows, g.rows_by, strict=True)]
        change = _step(g, rates, [not asked[c] for c in g.columns])
        for (i, k), x, by in zip(g.columns, change, g.columns_by, strict=True):
            out[program.nq + program.instances[i][0].v.start + k] += x * by
    return out


# ---- what is reported ------------------------------------------------------------------------------------------------


def changes_message(program: Program, before: np.ndarray, after: np.ndarray, P: np.ndarray) -> list[str]:
    """Return one sentence for each given coordinate or speed that was changed by more than the rounding of its digits.

    The coordinates of a joint that closes a loop are not reported, since they follow from the other coordinates.
    """
    links, nq = program.graph.links, program.nq
    names = ", ".join(dict.fromkeys(n for n, _ in zip(program.constraints.names, program.constraints.of, strict=False)))
    moved, sped = [], []
    for k in links:
        if k.joint.q0:
            moved += _changed(k.joint, before[k.q].tolist(), after[k.q].tolist())
    speeds = [(k.joint, before[nq:][k.v].tolist(), after[nq:][k.v].tolist()) for k in links if k.joint.v0]
    closing = [j for j in program.constraints.loops if j.q0 or j.v0]
    ends = pose_of(program, after, P).ends if closing else {}
    for j in closing:
        A, B = (ends[program.graph.number(body)] for body in (j.parent, j.child))
        if j.q0:
            moved += _changed(j, j.q0, closed_coordinates(j, A, B))
        if j.v0:
            speeds.append((j, list(j.v0), closed_rates(j, A, B)))
    following: dict[str, None] = {}
    fastest = max((abs(x) for _, asked, _ in speeds for x in asked), default=0.0)
    for j, asked, found in speeds:
        for c, x, z in zip(JOINTS[j.kind].velocities, asked, found, strict=True):
            if abs(z - x) > SLOWER * fastest:
                following |= {f"'{j.name}'": None} if j in closing else {}
                sped.append(f"{_place(j, c)} from {x:.6g} to {z:.6g} {'rad/s' if _is_turn(j, c) else 'm/s'}")
    out = []
    if moved:
        out.append(f"the start pose was changed so that the loops of {names} close: {'; '.join(moved)}")
    if sped:
        out.append(f"the start speeds were changed to what the loops of {names} allow: {'; '.join(sped)}")
        if following:
            out[-1] += f"; give other joints of the loop the speeds from which those of {', '.join(following)} follow"
    return out


def _changed(joint: Joint, asked: Columns, found: Columns) -> list[str]:
    """Describe the coordinates of a joint that differ from the given ones."""
    return [
        f"{where} from {_message(x, turns)} to {_message(z, turns)}"
        for where, x, z, turns in _coordinates(joint, asked, found)
        if abs(z - x) > ROUNDED * max(1.0, abs(x) if not turns else 1.0)
    ]


def _place(joint: Joint, coordinate: str) -> str:
    several = len(JOINTS[joint.kind].velocities) > 1
    return f"joint '{joint.name}'{f' {coordinate}' * several}"


def _is_turn(j: Joint, velocity: str) -> bool:
    joint = JOINTS[j.kind]
    n = joint.velocities.index(velocity)
    return n >= joint.quaternion if joint.quaternion is not None else any(
        m.turns for m in joint.motions if m.coordinate == n
    )  # fmt: skip


def _coordinates(j: Joint, before: Columns, after: Columns) -> list[tuple[str, float, float, bool]]:
    """Return name, both values, whether it is an angle, by coordinate; for a quaternion the angle between both."""
    joint = JOINTS[j.kind]
    x, z = ([float(e) for e in y[: joint.n_q]] for y in (before, after))
    end = joint.n_q if joint.quaternion is None else joint.quaternion
    names = list(joint.coordinates)
    out = [
        (_place(j, names[n]), x[n], z[n], any(m.turns for m in joint.motions if m.coordinate == n)) for n in range(end)
    ]
    if joint.quaternion is not None:
        p, q = x[end:], z[end:]
        part = dot(p, q) / (norm(p) * norm(q))
        across = [a - part * b for a, b in zip(q, p, strict=True)]
        out.append(
            (f"{_place(j, names[0])[: -len(names[0]) - 1]} attitude", 0.0, 2.0 * atan2(norm(across), abs(part)), True)
        )
    return out


def _message(x: float, turns: bool) -> str:
    return f"{degrees(x):.6g} degrees" if turns else f"{x:.6g} m"


def _refusal(program: Program, pose: Pose, asked: Mapping[tuple[int, int], bool], possible: np.ndarray) -> KernelError:
    """Return the error that names the joint with the largest change, and a start value that would be possible."""
    y = np.zeros(program.ny)
    y[: program.nq] = pose.q
    changes = [
        (abs(z - x), where, x, z, turns)
        for k in program.graph.links
        if k.joint.q0
        for where, x, end, turns in _coordinates(k.joint, y[k.q].tolist(), possible[k.q].tolist())
        for z in (near(end, x) if turns else end,)
    ]
    _, where, x, z, turns = max(changes, key=lambda change: change[0])
    gaps = [(abs(float(row.gap)), n) for n, row in enumerate(pose.rows)]
    widest, r = max(gaps)
    size = f"{widest * 1e3:.4g} mm" if pose.units[r] == "m" else f"{degrees(widest):.4g} degrees"
    return KernelError(
        f"{where}: asked to start at {_message(x, turns)}, where the loop of {pose.names[r]} is {size} open; it closes "
        f"at {_message(z, turns)}, which is another branch or too far away to be meant: correct the start values, or "
        "leave out those that may follow"
    )
