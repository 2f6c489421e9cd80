"""Levels of fidelity of a machine's model: passes over its description, each of which turns a machine into a simpler
machine.

joints    locked joints, motion in a plane, compliant drives
beams     flexible bodies, with the parts that hang on them or slide on them
ropes     hook ropes that are rigid, with mass at their ends or as chains of lumps; rigid slings
water     radiation of vessels at one frequency
motion_given  vessels that follow their own response to the waves; applied with the whole plan, before the passes
supports  only the supports that carry a load at the start
guards    reasons why a pass cannot change the motion: no order moves what it fixes, or the lift is mirror-symmetric
listing   the model level of a machine of a plan, and a list of what it leaves out

A pass reads hooks, ties and optional parts from the plan and knows nothing of particular machines; if a fidelity does
not require the pass, it returns the machine itself.
"""

from collections.abc import Callable
from dataclasses import replace
from typing import NamedTuple

import msgspec
from heavylift.kernel.on_demand import face
from heavylift.nodes.plan.fidelity import Fidelity
from heavylift.nodes.plan.mechanism import Mechanism
from heavylift.nodes.plan.plan import Plan

from .beams import beams
from .guards import guard_locked, guard_motion, guard_supports, unless
from .joints import locking, planar, yielding
from .ropes import heavy, rigid_slings
from .water import radiating, without_memory

__all__ = ["PASSES", "modelled"]


def standing(machine: Mechanism, fidelity: Fidelity) -> Mechanism:
    """Return the machine without those supports that do not touch their body at the start."""
    if fidelity.pads == "all" or not machine.cargo:
        return machine
    supports = tuple(s for s in machine.system.supports if s.name in machine.closed)
    return msgspec.structs.replace(machine, system=replace(machine.system, supports=supports))


class Pass(NamedTuple):
    """A simplification of a machine model, with a test of whether it leaves the motion unchanged.

    `guard` returns the reason why the motion of a plan stays unchanged, or "" if it may change."""

    name: str
    apply: Callable[[Mechanism, Fidelity], Mechanism]
    guard: Callable[[Plan], str]


PASSES = (
    Pass("locked", locking, guard_locked),
    Pass("motion", planar, guard_motion),
    Pass("drives", yielding, unless(lambda machine: bool(machine.servos))),
    Pass("beams", beams, unless(lambda machine: bool(machine.bends))),
    Pass("ropes", heavy, unless(lambda machine: any(not row.why for row in machine.heavy))),
    Pass("slings", rigid_slings, unless(lambda machine: bool(machine.ties))),
    Pass("supports", standing, guard_supports),
    Pass("water", without_memory, unless(lambda machine: bool(radiating(machine)))),
)


def modelled(machine: Mechanism, fidelity: Fidelity) -> Mechanism:
    """Return a machine reduced to the effects that a model level includes."""
    for level in PASSES:
        machine = level.apply(machine, fidelity)
    return machine


face(__name__)
