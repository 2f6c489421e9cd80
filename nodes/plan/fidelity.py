"""How much of a yard is modelled: the rung of the ladder between a rigid pendulum and heavy ropes on a soft girder.

Named in a scene under `fidelity:`, or chosen for what the scene asks; the models obey when they declare themselves, so
that what is left out never reaches the kernel.
"""

from __future__ import annotations

from typing import Literal

from .actions import Item

__all__ = ["ACROSS", "ALONG", "PLANAR", "Fidelity", "held_by"]

ACROSS, ALONG = "across", "along"
PLANAR = {ACROSS: ("gantries", "hinges"), ALONG: ("trolleys",)}  # motion -> joints that it locks
KINDS = {".gantry": "gantries", ".hinge": "hinges", "-slide": "trolleys"}  # end of a joint's name -> its group


class Fidelity(Item, frozen=True, kw_only=True):
    """What of the machines is modelled.

    ropes: "rigid" ones keep their length, "elastic" ones stretch, "massive" ones are chains of `lumps` pieces.
    rope_mass: of rigid and elastic ones; "none", or "lumped" onto trolley and hook.
    slings: rigid or elastic.  girder: rigid, or "elastic" with its first vertical mode.
    motion: spatial, or planar "across" (along the girders: y, z) or "along" the rails (x, z).
    pads: of the block; all of them, or only those of the face that it is "standing" on.
    locked: joints that are declared fixed where they start.
    islands: what nothing ties together is solved apart, or all of it together.
    """

    ropes: Literal["rigid", "elastic", "massive"] = "elastic"
    lumps: int = 4
    rope_mass: Literal["none", "lumped"] = "none"
    slings: Literal["rigid", "elastic"] = "elastic"
    girder: Literal["rigid", "elastic"] = "rigid"
    motion: Literal["spatial", "across", "along"] = "spatial"
    pads: Literal["all", "standing"] = "all"
    locked: tuple[str, ...] = ()
    islands: Literal["apart", "together"] = "apart"


def held_by(fidelity: Fidelity, joint: str) -> str:
    """Why a locked joint cannot move, and what to name under `fidelity:` for it to move."""
    group = next(group for end, group in KINDS.items() if joint.endswith(end))
    if group in PLANAR.get(fidelity.motion, ()):
        return f"{joint} cannot move, 'motion: {fidelity.motion}' of 'fidelity' holds it: name 'motion: spatial' there"
    return f"{joint} cannot move, 'locked' of 'fidelity' holds it: name there a list without it and without '{group}'"
