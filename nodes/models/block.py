"""The block: one body on a free joint, moved by slings, stools and gravity only.

It reports lift-off, touch-down and landing from the states of its supports, and its attitude every 30
degrees.
"""

from __future__ import annotations

from heavylift.kernel.description.mechanics import WORLD, Joint, System
from heavylift.nodes.models.parts.bending import block_body
from heavylift.nodes.models.parts.fidelity_variants import modelled
from heavylift.nodes.models.parts.gauges import Inclinometer
from heavylift.nodes.models.parts.parts import BodyCoupled, JointCoupled, Law, Machine
from heavylift.nodes.models.parts.rigging import Stools
from heavylift.nodes.plan.plan import Block, Plan

from .loader import REST6


class BlockModel(Machine):
    """The block of the plan."""

    def __init__(self, plan: Plan, block: Block) -> None:
        super().__init__(block.name)
        joint = Joint(f"{block.name}.free", "free", WORLD, block.name, q0=block.pose, v0=REST6)
        self.take(JointCoupled("free", modelled(joint, plan.fidelity), Law("free")))
        pads = [pad for pad in block.pads if pad.closed or plan.fidelity.pads == "all"]
        faces = {pad.support.name: pad.face for pad in pads}
        closed = frozenset(pad.support.name for pad in pads if pad.closed)
        laws = System(supports=tuple(pad.support for pad in pads))
        stools = Stools("stools", block.name, laws, faces=faces, closed=closed)
        level = Inclinometer("attitude", block.name, plan.start)
        self.take(BodyCoupled("body", block_body(block.name, block.body, block.flexible), Law("weight"), stools, level))
