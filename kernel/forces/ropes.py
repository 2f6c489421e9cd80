"""Elastic ropes over straight lines, which pull only, with winch.

Taut: T = max(0, EA e/L0 + c (l' - L0')). Guards: slack -> taut when e rises through 0; taut -> slack when the tension
falls through 0. Winch power -T L0' - (EA strain^2/2) L0': the second term is strain energy wound onto the drum.

Own mass of a rope, lumped at its ends as if it were straight and evenly stretched.

Half of its weight pulls each end down. With end velocities u and v, its kinetic energy is m (u.u + u.v + v.v)/6
(Rayleigh 1877, The Theory of Sound, section 156). A third of its mass moves with each end: this keeps the frequencies
of a mass on a rope, vertically and as a pendulum. These masses are added to the bodies before anything is traced; the
remaining weight, a sixth of the rope at each end, is applied as a force. Of u.v, what drives move along straight lines
is kept: if the reference of a drive moves one end with the acceleration a, the other end is pushed by -m a/6, which is
work of the drive; so a ramp of a trolley drives a load M by M + m/2. The reaction m v'/6, and u.v of other motions,
such as modes of a girder, are neglected, so that trees of bodies stay independent. The tension at the lower end is
smaller than in the middle by half of the weight.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from heavylift.kernel.algebra.spatial import cross, join
from heavylift.kernel.compiler.symbol import Array, Scalar, Scalars, maximum, minimum, named, select, sqrt
from heavylift.kernel.description.forces import InputSignal
from heavylift.kernel.description.mechanics import WORLD, Body, Point, RigidRope, Rope, System
from heavylift.kernel.multibody.graph import Graph
from heavylift.kernel.multibody.joint_locking import gathered

from .force_law import ForceLaw, LawOutput, Poses, SampledQuantity, Setting, attachment
from .joint_laws import one_sided

STRAIGHT = ("prismatic", "slider")  # joints along straight lines
MOVES, WEIGHS, SHARED = 1.0 / 3.0, 1.0 / 2.0, 1.0 / 6.0  # parts of a rope's mass at each end, and of both


def with_rope_masses(system: System) -> System:
    """Return the system with the part of each rope's mass that moves with its ends added to the end bodies."""
    borne: dict[str, list[tuple[float, Point]]] = {}
    for rope in system.straight_ropes:
        for mass, end in _ends(rope):
            borne.setdefault(end.body, []).append((mass, end))
    if not borne:
        return system
    return replace(system, bodies=tuple(_with(b, borne.get(b.name, [])) for b in system.bodies))


@dataclass(frozen=True)
class LedEnd:
    """A rope end on which rope mass exerts an inertia force when drives move the other end along straight lines.

    `line`, `end`: of the rope, numbered from 0; `mass`: the force on the end per acceleration [kg].
    """

    rope: Rope | RigidRope
    line: int
    end: int
    body: str
    drives: tuple[str, ...]
    mass: float


def straight_drives(system: System, graph: Graph) -> dict[str, tuple[str, list[float]]]:
    """Return, for each drive along a straight line, the body that it moves and the direction (3,) in axes of that
    body."""
    joints = {d.name: graph.joint(d.joint) for d in system.drives}
    return {
        name: (link.body.name, (np.array(link.joint.R_CJ) @ np.array(link.joint.axis)).tolist())
        for name, link in joints.items()
        if link.joint.kind in STRAIGHT
    }


def led_ends(system: System, graph: Graph) -> Iterator[LedEnd]:
    """Yield the ends of ropes with mass on which inertia forces act because drives move the other ends of the ropes."""
    moving = {body: name for name, (body, _) in straight_drives(system, graph).items()}
    for rope in system.straight_ropes:
        for n, line in enumerate(rope.lines if rope.mass else ()):
            for i, (end, other) in enumerate(((line.a, line.b), (line.b, line.a))):
                above = [link.body.name for link in graph.above(other.body)] if end.body != WORLD else []
                if drives := tuple(moving[name] for name in above if name in moving):
                    yield LedEnd(rope, n, i, end.body, drives, SHARED * line.share * rope.mass)


def not_weighed(weight: Scalar) -> Scalar:
    """Return the part of a rope's weight [N] to apply at each end; the rest acts on rope mass in the end bodies."""
    # of half the weight, a third of the mass has been added to the end body, which gravity pulls already
    return (WEIGHS - MOVES) * weight


def pulls_down(weight: Scalar, x: Array) -> Array:
    """Return the wrench (6,) about the tree's reference point of the weight from `not_weighed`, which acts at x."""
    f = -not_weighed(weight)
    return join([x[1] * f, -x[0] * f, 0.0], [0.0, 0.0, f])


def at_the_hook(tension: Scalar, weight: Scalar) -> Any:
    """Return the tension at the lower end of a rope [N], given the tension at mid-length and the weight of the rope."""
    return maximum(tension - WEIGHS * weight, 0.0)


def _ends(rope: Rope | RigidRope) -> Iterator[tuple[float, Point]]:
    """Yield the masses that move with the ends of a rope, with their points."""
    for line in rope.lines if rope.mass else ():
        for end in (line.a, line.b):
            if end.body != WORLD:
                # the world cannot be made heavier
                yield MOVES * line.share * rope.mass, end


def _with(body: Body, borne: list[tuple[float, Point]]) -> Body:
    """Return a body with additional point masses."""
    if not borne:
        return body
    parts = [(body.mass, np.array(body.com)), *((m, np.array(p.p)) for m, p in borne)]
    # point masses keep their parallel-axis inertia, so that the rope's end also resists rotation
    mass, com, inertia = gathered(np.array(body.inertia), parts)
    px, py, pz = com.tolist()
    a, b, c = ((u, v, w) for u, v, w in inertia.tolist())
    return replace(body, mass=mass, com=(px, py, pz), inertia=(a, b, c))


ROPE_HEAD, ROPE_LINE = 4, 7  # numbers of a rope, and of each of its lines: a(3), b(3), share


class RopeAt:
    """Indices into the parameters of an elastic rope, which end with its weight; A, B: end points of its first line."""

    EA, DAMPING, HOOKED, TAUT = range(4)
    A, B = slice(4, 7), slice(7, 10)


@dataclass(frozen=True)
class RopeLaw(ForceLaw[Rope]):
    """Force law of an elastic rope.

    If it has a mass, samples show the tension at the ends b (see the module). `calm`: the rope has no events; its
    damping acts only at elongations e > 0 and is at most as large as the elastic part, so nothing jumps at e = 0.
    """

    clamped: bool = True
    calm: bool = False
    works: bool = False
    gravity: float = 0.0

    kind = "rope"

    def within(self, f: Rope, setting: Setting) -> "RopeLaw":
        return RopeLaw(setting.clamped, f.name in setting.calm, f.winch, setting.gravity)

    def signal(self, f: Rope) -> InputSignal:
        return InputSignal(f.L0, driven=f.winch)

    def shape(self, f: Rope) -> bool:
        return self.calm

    def numbers(self, f: Rope, poses: Poses) -> list[float]:
        lines = [x for line in f.lines for x in (*line.a.p, *line.b.p, line.share)]
        return [f.EA, f.damping, float(f.hooked), 0.0, *lines, *([f.mass * self.gravity] if f.mass else [])]

    def answer(self, f: Rope, p: Array, ends: list[Array], signal: Scalars, joint: Scalars, t: Scalar) -> LawOutput:
        EA, c, hooked, taut = p[:ROPE_HEAD]
        L0, dL0 = signal
        length, rate, high, lines = 0.0, 0.0, 0.0, []
        for n, (A, B) in enumerate(zip(ends[::2], ends[1::2], strict=True)):
            q = p[ROPE_HEAD + ROPE_LINE * n :]
            (x_a, p_a, v_a), (x_b, p_b, v_b) = (attachment(A, q[:3], f"a{n + 1}"), attachment(B, q[3:6], f"b{n + 1}"))
            d = named(f"d{n + 1}", p_b - p_a)
            l = named(f"l{n + 1}", sqrt(d @ d))
            u = named(f"u{n + 1}", d * (1.0 / l))
            length, rate = length + q[6] * l, rate + q[6] * (u @ (v_b - v_a))
            lines.append((x_a, x_b, q[6] * u, q[6]))
            if f.mass:
                high = high + q[6] * (p_a[2] + p_b[2])
        length, rate = named("l", length), named("dl", rate)
        e, de = length - L0, rate - dL0
        strain = e * (1.0 / L0)
        if self.calm:
            strain = maximum(strain, 0.0)
            held = EA * strain
            # damping never exceeds the elastic part: the tension starts from zero and stays positive without an event
            damped = minimum(maximum(c * de, -held), held)
        else:
            held, damped = EA * strain, c * de
        # a viscous damper in parallel with the elastic rope (Kelvin-Voigt)
        trial = held + damped
        on = select(taut > 0.0, hooked, 0.0)
        tension = named("T", select(on > 0.0, one_sided(trial, self.clamped), 0.0))
        wrenches: list[Array] = []
        for n, (x_a, x_b, u, share) in enumerate(lines):
            pull = named(f"f{n + 1}", tension * u)
            both = join(cross(x_a, pull), pull), -join(cross(x_b, pull), pull)
            if f.mass:
                weight = share * p[-1]
                both = both[0] + pulls_down(weight, x_a), both[1] + pulls_down(weight, x_b)
            wrenches += both
        # strain energy per unit of unstretched length
        wound = select(on > 0.0, 0.5 * EA * strain * strain, 0.0)
        stored, at_end = wound * L0, tension
        if f.mass:
            stored, at_end = stored + not_weighed(p[-1]) * high, at_the_hook(tension, p[-1])
        return LawOutput(
            wrenches,
            heat=select(on > 0.0, damped * de, 0.0),
            # winding moves tension, and takes strain energy onto the drum with the rope
            work=-(tension + wound) * dL0,
            stored=stored,
            # slack -> taut needs elongation and force: a rope that shortens fast stays slack at e = 0
            guards=[1.0 if self.calm else select(hooked > 0.0, select(taut > 0.0, trial, -minimum(e, trial)), 1.0)],
            shown=[at_end, e],
        )

    def guards(self, f: Rope) -> tuple[str, ...]:
        return ("rope",)

    def switch(self, f: Rope, p: np.ndarray, guard: str, shown: np.ndarray) -> tuple[str, float]:
        p[RopeAt.TAUT] = 1.0 - p[RopeAt.TAUT]
        return "taut" if p[RopeAt.TAUT] else "slack", float(shown[1])

    def shows(self, f: Rope) -> list[SampledQuantity]:
        return [
            SampledQuantity("rope/tension", f.name, "N", "tension"),
            SampledQuantity("rope/elongation", f.name, "m", "elongation"),
        ]
