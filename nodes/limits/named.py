"""The signal that a limit names: one row for each quantity that a row of the kernel's table of quantities tells."""

from __future__ import annotations

from collections.abc import Mapping

from heavylift.kernel.description.mechanics import Quantity as Kind
from heavylift.kernel.description.signals import Signal
from heavylift.nodes.plan.limit import Limit, Quantity
from heavylift.nodes.plan.mechanism import Hoist
from heavylift.nodes.plan.spellings import BEAM_LOAD

LOADS: tuple[Quantity, ...] = (
    "hook load", "trolley load", "crane load", "tandem load", "frame load", "shackle load",
)  # fmt: skip
TENSIONS: tuple[Quantity, ...] = (BEAM_LOAD, "sling tension", "sling peak", "rope tension")
KINDS: dict[Quantity, Kind] = {
    **dict.fromkeys(LOADS, "load"),
    **dict.fromkeys(TENSIONS, "tension"),
    "off-lead": "off-lead",
    "off-lead along": "swing along",
    "off-lead across": "swing across",
    "hook height": "height",
    "rope length": "length",
}


def signal_of(limit: Limit, hooks: Mapping[str, Hoist], gravity: float) -> Signal | None:
    """The signal of a limit, with the hooks by their ropes and gravity [m/s2]; None if its quantity is no signal.

    A load is what hangs below the hook blocks [kg].
    """
    kind = KINDS.get(limit.quantity)
    if kind is None or limit.signal:
        return limit.signal
    if kind == "load":
        blocks = sum(hooks[rope].block_mass for rope in limit.elements if rope in hooks)
        return Signal(kind, ropes=limit.elements, numbers=(1.0 / gravity, blocks))
    if kind == "height":
        hook = hooks.get(limit.elements[0])
        return Signal(kind, point=hook.eye) if hook else None
    return Signal(kind, ropes=limit.elements)
