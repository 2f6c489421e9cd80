"""Whether a block can be what the scene says: lugs that are on it, and a centre of mass that is in it."""

from __future__ import annotations

from collections.abc import Iterator
from math import dist, hypot

from heavylift.kernel.description.points import Vector
from heavylift.nodes.plan.limit import Finding
from heavylift.nodes.plan.mechanism import Cargo
from heavylift.nodes.plan.plan import Plan

REACH = 1.0  # of a lug from the plates of its block [m]
ROUNDING = 1e-9


def outside(half: Vector, p: Vector) -> float:
    """How far a point is outside a box of these half edges around the origin [m]; 0 inside."""
    return hypot(*(max(0.0, abs(x) - h) for x, h in zip(p, half, strict=True)))


def geometry_findings(plan: Plan) -> list[Finding]:
    """Lugs that stand far off the box of a block, and centres of mass outside it: red, each with its line."""
    return [finding for machine in plan.machines for cargo in machine.cargo for finding in _of(cargo)]


def _of(cargo: Cargo) -> Iterator[Finding]:
    u, v, w = (side / 2 for side in cargo.size)
    if not any(cargo.size):
        return
    for lug, p in cargo.lugs.items():
        off = outside((u, v, w), p)
        if off > REACH + ROUNDING:
            told = f"the lug {lug} is {off:.4g} m off the block, no lug of it can be more than {REACH:g} m off"
            yield _finding(lug, told, cargo.marks[lug], off, REACH)
    off = outside((u, v, w), cargo.com)
    if off > ROUNDING:
        com = ", ".join(f"{x:g}" for x in cargo.com)
        told = f"the centre of mass at u, v, w = {com} m is {off:.4g} m outside the block"
        yield _finding(cargo.body, told, cargo.marks[""], off, 0.0)


def _finding(subject: str, told: str, where: str, value: float, limit: float) -> Finding:
    return Finding(
        severity="red", kind="geometry", subject=subject, sentence=told, where=where, value=value, limit=limit, unit="m"
    )


def passes_through(a: Vector, b: Vector, half: Vector) -> float:
    """Length of the part of a straight line from a to b that is inside a box of these half edges around the origin [m]
    (the slab method: Kay and Kajiya 1986, Ray tracing complex scenes)."""
    first, last = 0.0, 1.0
    for p, q, h in zip(a, b, half, strict=True):
        d = q - p
        if abs(d) < ROUNDING:
            if abs(p) >= h:
                return 0.0
            continue
        low, high = sorted(((-h - p) / d, (h - p) / d))
        first, last = max(first, low), min(last, high)
    return max(0.0, last - first) * dist(a, b)
