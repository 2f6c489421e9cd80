"""Plausibility of a block: its lugs lie on it, its centre of mass lies inside it, and its mass fits its volume.

Features of model files that machines do not have are warnings.
"""

from collections.abc import Iterator
from math import dist, hypot

from heavylift.kernel.description.findings import Check, finding
from heavylift.kernel.description.units import Vector
from heavylift.nodes.plan.mechanism import Cargo
from heavylift.nodes.plan.plan import Plan

REACH = 1.0  # of a lug from the plates of its block [m]
ROUNDING = 1e-9
GRAVITY = 9.76, 9.84  # from the highest mountain of the tropics to the poles [m/s2]
DENSITIES = 20.0, 7850.0  # of all that is in the box of a block [kg/m3]: of light frames, assumed, and of solid steel


def outside(half: Vector, p: Vector) -> float:
    """Return the distance [m] of a point from a box around the origin with half-extents `half`; 0 inside the box."""
    return hypot(*(max(0.0, abs(x) - h) for x, h in zip(p, half, strict=True)))


def geometry_findings(plan: Plan) -> list[Check]:
    """Return findings about implausible positions, densities and gravity, and about model files converted in part."""
    found = [x for machine in plan.machines for cargo in machine.cargo for x in _of(cargo)]
    lacks = (
        finding("amber", "model file", machine.name, f"not converted: {sentence}", where=machine.where)
        for machine in plan.machines
        for sentence in machine.lacks
    )
    return [*found, *_densities(plan), *_gravity(plan), *lacks]


def _of(cargo: Cargo) -> Iterator[Check]:
    u, v, w = (side / 2 for side in cargo.size)
    if not any(cargo.size):
        return
    for lug, p in cargo.lugs.items():
        off = outside((u, v, w), p)
        if off > REACH + ROUNDING:
            message = f"the lug {lug} is {off:.4g} m away from the block; a lug must be within {REACH:g} m of it"
            numbers = {"where": cargo.marks[lug], "value": off, "limit": REACH, "unit": "m"}
            yield finding("red", "geometry", lug, message, **numbers)
    off = outside((u, v, w), cargo.com)
    if off > ROUNDING:
        com = ", ".join(f"{x:g}" for x in cargo.com)
        message = f"the centre of mass at u, v, w = {com} m is {off:.4g} m outside the block"
        numbers = {"where": cargo.marks[""], "value": off, "limit": 0.0, "unit": "m"}
        yield finding("red", "geometry", cargo.body, message, **numbers)


def _densities(plan: Plan) -> Iterator[Check]:
    """Yield a warning for each lifted body with an implausible density."""
    known = plan.machines
    masses = {body.name: body.mass for m in known for body in m.system.bodies if body.flexible is None}
    low, high = DENSITIES
    for machine, cargo in ((m, c) for m in known for c in m.cargo):
        sizes = [x.size for m in known for x in m.shapes if x.body == cargo.body]
        volume, mass = sum(a * b * c for a, b, c in sizes), masses.get(cargo.body, 0.0)
        if mass and volume and not low <= mass / volume <= high:
            message = (
                f"the mass of {cargo.body}, {mass / 1e3:.4g} t in {volume:.4g} m3, gives {mass / volume:.3g} kg/m3"
            )
            basis = f"loads have {low:g} (light frames, assumed) to {high:g} kg/m3 (solid steel)"
            limit, message = low if mass / volume < low else high, f"{message}; {basis}: check its mass and size"
            numbers = {"where": machine.where, "value": mass / volume, "limit": limit, "unit": "kg/m3"}
            yield finding("amber", "geometry", cargo.body, message, **numbers)


def _gravity(plan: Plan) -> Iterator[Check]:
    """Yield a warning if something is lifted where it would weigh less or more than anywhere on the Earth."""
    low, high = GRAVITY
    if any(machine.cargo for machine in plan.machines) and not low <= plan.gravity <= high:
        message = f"gravity is {plan.gravity:g} m/s2, and on the Earth {low:g} to {high:g}: all loads are wrong there"
        numbers = {"value": plan.gravity, "limit": low if plan.gravity < low else high, "unit": "m/s2"}
        yield finding("amber", "gravity", "all", message, **numbers)


def passes_through(a: Vector, b: Vector, half: Vector) -> float:
    """Return the length [m] of the segment from a to b inside a box around the origin with half-extents `half`.

    Slab method: Kay and Kajiya 1986, Ray tracing complex scenes."""
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
