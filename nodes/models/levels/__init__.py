"""How much of a machine is modelled: passes over its description, each from a machine to a machine.

joints    what is locked is fixed where it starts; motion in a plane; drives that yield
beams     bodies that bend, with what hangs on them or slides on them
ropes     hook ropes rigid, with mass at their ends or in lumps (`lumps`); rigid slings
supports  only those that bear at the start
guards    when what a pass fixes would not move anyway: nothing orders it, or the lift is its own mirror image
listing   how a machine of a plan is modelled, and what its fidelity leaves out
A pass reads what the plan tells of hooks, ties and optional parts and has no knowledge of machines; where a fidelity
asks nothing of it, it returns the machine itself.
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

__all__ = ["PASSES", "modelled"]


def standing(machine: Mechanism, fidelity: Fidelity) -> Mechanism:
    """Return the machine without supports that carry nothing at the start."""
    if fidelity.pads == "all" or not machine.cargo:
        return machine
    supports = tuple(s for s in machine.system.supports if s.name in machine.closed)
    return msgspec.structs.replace(machine, system=replace(machine.system, supports=supports))


class Pass(NamedTuple):
    """A step of the model reduction, applied to one machine; its guard returns why it changes nothing in a whole plan,
    or ""."""

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
)


def modelled(machine: Mechanism, fidelity: Fidelity) -> Mechanism:
    """Return a machine at the model level of a fidelity."""
    for level in PASSES:
        machine = level.apply(machine, fidelity)
    return machine


face(__name__)
