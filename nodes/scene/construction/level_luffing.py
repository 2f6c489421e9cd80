"""The order `hold height`: a winch that keeps its hook at its height as the boom above it luffs.

What the hook rope pays out is what its tip rises, and what the way from tip to drum grows by over the number of falls:
a function of the boom's angle that k1 s + kc cos s + ks sin s meets within a tenth of a millimetre (the law by which
the kernel's winches follow an angle).  The rope's stretch is that of its start.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from math import pi

import msgspec
import numpy as np
from heavylift.kernel.algebra.dense import cross, dot, norm, solve
from heavylift.kernel.algebra.elementary import cos, sin
from heavylift.kernel.description.mechanics import Joint, Line, Measured, Point, System, merge
from heavylift.nodes.plan import plan
from heavylift.nodes.plan.actions import Follow, Move
from heavylift.nodes.scene.keys.parts.kinematics import Array, Poses, place, poses

from .scene_builder import SceneBuilder
from .targets import targets

NODES = tuple(float(cos(pi * (2 * i + 1) / 8)) for i in range(4))  # of Chebyshev, in -1 to 1
LEVEL = 1e-9  # of an axis that is level


def measuring(builder: SceneBuilder) -> list[plan.Mechanism]:
    """The machines with angle measurements of booms whose hooks hold their height."""
    asked = [t for action in builder.scene.actions for t, phrase in action.orders.items() if phrase.height]
    known = targets(builder) if asked else {}
    ropes = {actor.name for target in asked for actor in known.get(" ".join(target.split()), ())}
    found = []
    for machine in builder.machines:
        led: dict[str, list[str]] = {}
        for rope in sorted(ropes):
            if boom := _boom(machine, rope):
                led.setdefault(boom.name, []).append(rope)
        angles = tuple(Measured(angle_of(x), "joint", x, followers=tuple(each)) for x, each in led.items())
        seen = replace(machine.system, measured=(*machine.system.measured, *angles))
        found.append(msgspec.structs.replace(machine, system=seen) if angles else machine)
    return found


def angle_of(joint: str) -> str:
    """The name of a boom's measured angle."""
    return f"{joint}.angle"


def follow(mechanisms: Sequence[plan.Mechanism], move: Move, rope: str, where: str) -> Follow | str:
    """The law of a winch while a boom luffs, or a sentence why there is none."""
    own = next(m for m in mechanisms if m.name == move.model)
    luffs = next(d.joint for d in own.system.drives if d.name == move.actuator)
    boom, actuator = _boom(own, rope), next(a for a in own.actuators if a.name == move.actuator)
    if boom is None or boom.name != luffs:
        return f"'{rope}' does not hang from what '{move.actuator}' luffs"
    whole = merge([m.system for m in mechanisms], 0.0)
    at = poses(System(whole.bodies, whole.joints))
    x, y, z = (dot(row, boom.axis) for row in boom.R_PJ)
    axis = place(Point(boom.parent, (x, y, z)), at) - place(Point(boom.parent), at)
    if abs(float(axis[2])) > LEVEL or actuator.lower is None or actuator.upper is None:
        return f"'{rope}' holds its height below a boom that luffs about a level axis, in a 'range' of its drive"
    length = _length(own.system, boom, rope, at, axis)
    middle, half = (actuator.upper + actuator.lower) / 2, (actuator.upper - actuator.lower) / 2
    angles = [middle + half * node for node in NODES]
    rows = [[s, float(cos(s)), float(sin(s)), 1.0] for s in angles]
    k1, kc, ks, _ = solve(rows, [length(s) for s in angles])
    return Follow(model=own.name, actuator=rope, master=angle_of(boom.name), law=(k1, kc, ks), where=where)


def _boom(machine: plan.Mechanism, rope: str) -> Joint | None:
    """The joint that carries the tip of a hook's rope by one angle."""
    lines = next((r.lines for r in machine.system.ropes if r.name == rope and r.winch), ())
    return next(
        (j for j in machine.system.joints if lines and j.child == lines[0].a.body and j.kind == "revolute"), None
    )


def _length(system: System, boom: Joint, rope: str, at: Poses, axis: Array) -> Callable[[float], float]:
    """Functions of the boom angle: height of the tip, and length from tip to drum divided by the falls [m]."""
    lines = next(r.lines for r in system.ropes if r.name == rope)
    start, o = (boom.q0 or (0.0,))[0], place(Point(boom.parent, boom.p_PJ), at)

    def turned(end: Point, s: float) -> Array:
        p = place(end, at) - o
        if end.body != boom.child:
            return o + p
        c, n = float(cos(s - start)), float(sin(s - start))
        k, q = axis.tolist(), p.tolist()
        return o + c * p + n * np.array(cross(k, q)) + (1.0 - c) * dot(k, q) * axis

    def part(line: Line, s: float) -> float:
        a, b = turned(line.a, s), turned(line.b, s)
        plumb = line.b.body == lines[0].b.body
        return line.share * (float(a[2]) if plumb else norm((a - b).tolist()))

    return lambda s: sum(part(line, s) for line in lines)
