"""How much of a machine is modelled: passes over its description, each from a machine to a machine.

joints    what is locked is fixed where it starts; motion in a plane
girders   a beam that bends, with what slides on it
beams     booms that bend, with what hangs on them
ropes     hook ropes rigid, with mass at their ends or in lumps (`lumps`); rigid slings
supports  only those that bear at the start
listing   how a machine of a plan is modelled, and what its fidelity leaves out
A pass reads what the plan tells of hooks, ties and girders and has no knowledge of machines; where a fidelity asks
nothing of it, it returns the machine itself.
"""

from __future__ import annotations

from dataclasses import replace

import msgspec
from heavylift.kernel.on_demand import face
from heavylift.nodes.plan.fidelity import Fidelity
from heavylift.nodes.plan.mechanism import Mechanism

from .beams import beams
from .girders import bending
from .joints import locking, planar
from .ropes import heavy, rigid_slings

__all__ = ["PASSES", "modelled"]


def standing(machine: Mechanism, fidelity: Fidelity) -> Mechanism:
    """The machine without supports that carry nothing at the start."""
    if fidelity.pads == "all" or not machine.cargo:
        return machine
    supports = tuple(s for s in machine.system.supports if s.name in machine.closed)
    return msgspec.structs.replace(machine, system=replace(machine.system, supports=supports))


PASSES = (locking, planar, bending, beams, heavy, rigid_slings, standing)


def modelled(machine: Mechanism, fidelity: Fidelity) -> Mechanism:
    """A machine at a model level."""
    for level in PASSES:
        machine = level(machine, fidelity)
    return machine


face(__name__)
