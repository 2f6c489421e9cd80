"""Closing the kinematic loops of an initial pose, or reporting the gaps that cannot be closed.

A pose whose loops are closed to `CLOSED` stays as it is, bit for bit. Any other is closed near the given coordinates
(see `start_pose`). Then the independent rows are counted: a linkage whose loops leave no degree of freedom is refused.
To suggest another pose, Newton's method is applied to the rows, weighted with the inertia (light bodies move first); a
step that widens the gaps is halved. During a run loops are lost to contradictory drives, to masses too far apart, or at
the end of a linkage's range.
"""

from collections.abc import Callable, Sequence

import numpy as np
from heavylift.kernel.algebra.dense import norm
from heavylift.kernel.errors import KernelError
from heavylift.kernel.model.program import Program
from heavylift.kernel.multibody.trees import Tree

from .start_pose import changes_message, fitting_speeds, keeping

CLOSED = 1e-9  # [m or rad, m/s or rad/s] what counts as closed at the start
SHUT = 1e-11  # [m or rad] where Newton's method may end
ITERATIONS = 200
INDEPENDENT = 1e-4  # pivot above which a row is no combination of those before it (a redundant one keeps about 1e-6)
LOST = 1e-2  # [m or rad] gap that opens within one step when a constraint cannot be kept
APART = 1e8  # ratio of masses in a loop beyond which its rows are lost in rounding
END = "the linkage has reached the end of its range, or a drive asks for what it cannot do"
SINGULAR = 1e-2  # part of a row's first pivot that is left where a linkage locks

Step = Callable[[np.ndarray], tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]]  # y -> place, gap, slip, pivot


def assemble(program: Program, y: np.ndarray, P: np.ndarray, step: Step) -> tuple[np.ndarray, list[str]]:
    """Return the initial state (ny,) with closed loops and consistent speeds, and sentences on what was changed; raises
    KernelError if the loops cannot be closed."""
    _, gap, slip, pivot = step(y)
    asked = y
    message: list[str] = []
    if max(_widest(gap), _widest(slip)) > CLOSED:
        if _widest(gap) > CLOSED:
            y = keeping(program, y, P, lambda: _closed(program, asked, step))
        y = fitting_speeds(program, y, P)
        y = np.concatenate([y[: program.nq], step(y)[0][program.nq :]])
        pivot = step(y)[3]
    if len(program.constraints.of):
        message = changes_message(program, asked, y, P)
    _check_mobility(program, pivot > INDEPENDENT)
    return y, message


def _widest(gap: np.ndarray) -> float:
    return float(np.abs(gap).max(initial=0.0)) if np.isfinite(gap).all() else np.inf


def _closed(program: Program, y: np.ndarray, step: Step) -> np.ndarray:
    first = step(y)[1]
    nearer, gap, *_ = step(y)
    for _ in range(ITERATIONS):
        if _widest(gap) <= SHUT:
            return y
        size, part = 1.0, y
        while size > 1e-4:
            part = y + size * (nearer - y)
            after, left, *_ = step(part)
            if norm(left.tolist()) < norm(gap.tolist()):
                break
            size *= 0.5
        else:
            break
        y, nearer, gap = part, after, left
    if _widest(gap) <= CLOSED:
        return y
    name, left_over = _gap(program, gap)
    at_first = _gap(program, first)[1]
    raise KernelError(
        f"{name}: its loop does not close; a gap of {left_over} is left of {at_first} in the initial pose: "
        "change the dimensions or the initial coordinates"
    )


def _gap(program: Program, gap: np.ndarray) -> tuple[str, str]:
    """Return the joint with the largest gap, and the gap as text."""
    r = int(np.argmax(np.abs(np.nan_to_num(gap, nan=np.inf))))
    name, unit = program.constraints.names[r], program.constraints.units[r]
    size = abs(float(gap[r]))
    size, word = (size * 1e3, "mm") if unit == "m" else (float(np.degrees(size)), "degrees")
    return name, f"{size:.3g} {word}" if size < 100.0 else f"{size:.0f} {word}"


def _check_mobility(program: Program, independent: Sequence[bool] | np.ndarray) -> None:
    """Raise KernelError if the trees in a loop have no degree of freedom left, unless drives prescribe their motion."""
    constraints = program.constraints
    n = len(constraints.of)
    for rows, trees in constraints.groups:
        held = [program.instances[i][0] for i in trees]
        free = sum(len(t.free_dofs) for t in held)
        closing = [r for r in rows if r < n]
        if closing and free <= sum(bool(independent[r]) for r in closing):
            if any(t.prescribed_dofs for t in _tied(program, rows[0])):  # one that is driven as a whole is in no group
                continue
            names = ", ".join(dict.fromkeys(constraints.names[r] for r in closing))
            raise KernelError(
                f"{names}: the loops leave nothing free to move; "
                "give one of their joints another degree of freedom, or connect the bodies by fixed joints"
            )


def lost(program: Program, gap: np.ndarray, t: float, moving: Sequence[str] = ()) -> KernelError | None:
    """Return the error for a kinematic loop that opened within a step; None if all loops are closed.

    `moving`: prescribed drives in motion.
    """
    if _widest(gap) <= LOST:
        return None
    name, size = _gap(program, gap)
    why = _cause(program, int(np.argmax(np.abs(np.nan_to_num(gap, nan=np.inf)))), moving)
    return KernelError(f"constraint lost at {name} before {t:.6f} s: {size} open; {why}")


def locked(
    program: Program, at_start: np.ndarray, pivot: np.ndarray, t: float, moving: Sequence[str] = ()
) -> KernelError | None:
    """Return the error for steps that became too small because constraint rows are dependent; None for other causes.

    `moving`: prescribed drives in motion.
    """
    pivot, at_start = (x[: len(program.constraints.of)] for x in (pivot, at_start))
    if not len(pivot):
        return None
    left = np.where(at_start > INDEPENDENT, pivot / np.maximum(at_start, INDEPENDENT), 1.0)
    r = int(np.argmin(left))
    why = _cause(program, r, moving)
    if not left[r] < SINGULAR and why == END:
        return None
    return KernelError(f"constraint lost at {program.constraints.names[r]} at {t:.6f} s: {why}")


def _cause(program: Program, row: int, moving: Sequence[str]) -> str:
    """Describe, in part of a sentence, why a row can no longer be satisfied; `moving`: prescribed drives in motion."""
    trees = _tied(program, row)
    bodies = [b for tree in trees for b in tree.bodies]
    dofs = {k for tree in trees for k in range(tree.v.start, tree.v.stop)}
    own = [d for d in program.system.drives if d.name in moving and program.driven(d)[1] in dofs]
    if len(own) > 1:
        names = " and ".join(f"'{d.name}'" for d in own)
        return f"drives {names} move the same loop and contradict each other; stop one or make it a servo"
    masses = sorted((float(b.mass), b.name) for b in bodies if float(b.mass) > 0.0)
    if masses and masses[-1][0] > APART * masses[0][0]:
        (light, name), (heavy, other) = masses[0], masses[-1]
        return (
            f"body '{name}' with {light:.3g} kg is tied into a loop with '{other}' of {heavy:.3g} kg, too far apart "
            "for the loop to be kept; make it heavier, or leave it out"
        )
    return END


def torn(program: Program, rope: str, movable: bool, moving: Sequence[str]) -> str:
    """Return why a rigid rope switches endlessly between taut and slack, naming the drive that causes it, or ""."""
    if not moving:
        return ""
    names = " and ".join(f"'{name}'" for name in moving)
    drives = f"drives {names} move" if len(moving) > 1 else f"drive {names} moves"
    held = "what it holds" if movable else "all that it could move"
    cure = f"stop the drive before, make it a servo, or give '{rope}' EA"
    return f"{drives} {held}, and a rigid rope does not stretch; {cure}"


def _tied(program: Program, row: int) -> list[Tree]:
    """Return the trees coupled by the loops of a row's group, including driven ones."""
    rows = next((rows for rows, _ in program.constraints.groups if row in rows), [row])
    ends = {body for r in rows for body in program.constraints.held[r]}
    return [tree for tree, _ in program.instances if ends & set(range(tree.first, tree.first + len(tree.bodies)))]
