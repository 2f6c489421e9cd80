"""One step of Newton's method toward the equilibrium near a pose, in one native call.

It evaluates the accelerations, solves with the factors of the tangent stiffness, and moves the pose along the step.
"""

from collections.abc import Callable, Iterator, Mapping
from itertools import pairwise

import numpy as np
from heavylift.kernel.compiler.function import OPAQUE, Outputs, Primitive
from heavylift.kernel.compiler.native_linear_algebra import FactorLayout
from heavylift.kernel.compiler.native_loops import VECTOR, LoopEmitter
from heavylift.kernel.compiler.simd_batches import WIDEST
from heavylift.kernel.compiler.symbol import Array, Scalar

REACHED = 2  # place of the new pose in block `found`, after the largest acceleration and the length of the step


def newton_step(
    rate: Callable[..., object],
    sizes: Mapping[str, int],
    nq: int,
    free: tuple[int, ...],
    quaternions: tuple[int, ...],
    factors: FactorLayout,
) -> Primitive:
    """Return the native function `newton_step`(t, y, P, M, work, found), which takes a Newton step from state y.

    y (ny,) has zero velocities; M: factors over the velocities `free`; `found` (2 + nq,): the largest acceleration, the
    largest component of the step [m, rad], and the coordinates reached; `quaternions`: first coordinates of each.
    `sizes`: of the arrays that `rate` returns, as for `tangent`; the state before them in `work` is moved.
    """
    inputs = dict.fromkeys(("t", "y", "P", "M", "work", "found"), OPAQUE)
    c, ny = LoopEmitter("newton_step", list(inputs)), sizes["dy"]
    places, place = {}, ny
    for name, n in sizes.items():
        places[name], place = c.at("%work", place), place + n
    x, largest, wrong = c.reserve(f"[{max(factors.stride, 1)} x double]"), c.reserve("double"), c.reserve("double")

    def evaluate(y: str) -> None:
        c.call("rate", ["%t", y, "%P", *places.values()])

    def measure(into: int) -> None:
        """Store the largest component of x; nan if one of them is not finite."""
        c.store("0.0", largest)
        c.store("0.0", wrong)
        with c.loop(0, len(free)) as i:
            value = c.load(c.at(x, i))
            size, best = c.let(f"call double @llvm.fabs.f64(double {value})"), c.load(largest)
            better = c.let(f"fcmp ogt double {size}, {best}")
            c.store(c.let(f"select i1 {better}, double {size}, double {best}"), largest)
            c.store(c.let(f"fadd double {c.load(wrong)}, {c.let(f'fmul double {size}, 0.0')}"), wrong)
        c.store(c.let(f"fadd double {c.load(largest)}, {c.load(wrong)}"), c.at("%found", into))

    evaluate("%y")
    with c.loop(0, factors.stride, WIDEST) as i:
        c.store("zeroinitializer", c.at(x, i), VECTOR)
    for first, start, stop in _runs(free):
        with c.loop(0, stop - start) as i:
            c.store(c.load(c.at(places["dy"], nq + start, i)), c.at(x, first, i))
    measure(0)
    factors.solve(c, [x])
    measure(1)
    with c.loop(0, ny) as i:
        c.store(c.load(c.at("%y", i)), c.at("%work", i))
    for first, start, stop in _runs(free):
        with c.loop(0, stop - start) as i:
            c.store(c.load(c.at(x, first, i)), c.at("%work", nq + start, i))
    evaluate("%work")
    with c.loop(0, nq) as i:
        c.store(
            c.let(f"fadd double {c.load(c.at('%y', i))}, {c.load(c.at(places['dy'], i))}"), c.at("%found", REACHED, i)
        )
    for q in quaternions:
        parts = [c.at("%found", REACHED, q + k) for k in range(4)]
        turns = [c.load(part) for part in parts]
        squares = [c.let(f"fmul double {turn}, {turn}") for turn in turns]
        total = squares[0]
        for square in squares[1:]:
            total = c.let(f"fadd double {total}, {square}")
        size = c.let(f"call double @llvm.sqrt.f64(double {total})")
        for part, turn in zip(parts, turns, strict=True):
            c.store(c.let(f"fdiv double {turn}, {size}"), part)

    def floats(t: Scalar, y: Array, P: Array, M: Array, work: Array, found: Array) -> Outputs:
        a = np.array(rate(t=t, y=y, P=P).dy)[nq:][[*free]]  # type: ignore[attr-defined]
        step, moved = factors.solve_floats(M, a.copy()), np.array(y)
        moved[nq + np.array(free, int)] = step
        q = y[:nq] + np.array(rate(t=t, y=moved, P=P).dy)[:nq]  # type: ignore[attr-defined]
        for first in quaternions:
            q[first : first + 4] /= np.sqrt(np.cumsum(q[first : first + 4] ** 2)[-1])
        found[:] = [np.abs(a).max(initial=0.0), np.abs(step).max(initial=0.0), *q]
        return {}

    return Primitive(c.name, floats, inputs, {}, c.text())


def _runs(places: tuple[int, ...]) -> Iterator[tuple[int, int, int]]:
    """Yield the runs of consecutive numbers: place of the first one in the list, first number, number after the
    last."""
    breaks = [0, *(i for i, (a, b) in enumerate(pairwise(places), 1) if b != a + 1), len(places)]
    for i, k in pairwise(breaks):
        if k > i:
            yield i, places[i], places[k - 1] + 1
