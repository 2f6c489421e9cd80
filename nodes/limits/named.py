"""The signal that each limit checks, taken from the kernel's table of quantities: one row for each quantity.

Loads are the mass below the hook blocks [kg]. The load of the parts of a hook rope is the force at the upper end of one
part: at the drum in hoisting, or in the most loaded part, which is the drum part in hoisting and the dead end in
lowering.
"""

from collections.abc import Sequence

from heavylift.kernel.description.mechanics import Point, Quantity as Kind
from heavylift.kernel.description.signals import ScalarSignal
from heavylift.nodes.plan.limit import Quantity, RatedLimit
from heavylift.nodes.plan.mechanism import Hoist, Mechanism
from heavylift.nodes.plan.plan import Plan
from heavylift.recordings.format.spellings import BEAM_LOAD

from .reeving import drum_end_factor, lead_factor

LOADS: tuple[Quantity, ...] = (
    "hook load", "trolley load", "crane load", "tandem load", "frame load", "shackle load",
)  # fmt: skip
ROPES: tuple[Quantity, ...] = ("rope tension", "sling tension")  # limits of one rope at rest
TENSIONS: tuple[Quantity, ...] = (BEAM_LOAD, "sling tension", "sling peak", "rope tension", "impact")
KINDS: dict[Quantity, Kind] = {
    **dict.fromkeys((*LOADS, "lug load"), "load"),
    **dict.fromkeys(TENSIONS, "tension"),
    "support load": "use",
    "rope peak": "pull",
    "drum pull": "pull",
    "rope factor": "reserve",
    "off-lead": "off-lead",
    "off-lead along": "swing along",
    "off-lead across": "swing across",
    "bridle angle": "off-lead",
    "side force": "side across",  # or along, as the limit is over
    "hook height": "height",
    "rope length": "length",
    "rails": "place along",
    "girder": "place across",
    "wind": "wind",
}
OF_TENSIONS = ("load", "tension", "use", "pull", "reserve")  # kinds of which a run knows an exact peak


def hooks_of(machines: Sequence[Mechanism]) -> dict[str, Hoist]:
    """Return all hooks of the machines, by the names of their hook ropes."""
    return {hook.rope: hook for machine in machines for hook in machine.hooks}


def signal_of(limit: RatedLimit, machines: Sequence[Mechanism], gravity: float) -> ScalarSignal | None:
    """Return the signal that a limit checks, with gravity [m/s2]; None for quantities that need several signals: sling
    angle with changing lugs, strongest wind, clearance."""
    kind, (first, *_) = KINDS.get(limit.quantity), (*limit.elements, "")
    if kind and not limit.elements:
        return None
    hooks, ropes = hooks_of(machines), limit.elements
    hook = hooks.get(first)
    match kind:
        case None:
            return limit.signal
        case "load":
            blocks = sum((hooks[r].block_mass for r in ropes if r in hooks), 0.0)
            return ScalarSignal(kind, ropes=ropes, numbers=(1.0 / gravity, blocks))
        case "use":
            return ScalarSignal(kind, ropes=ropes, numbers=(1.0 / gravity,) * len(ropes))
        case "tension" | "length":
            return ScalarSignal(kind, ropes=ropes)
        case "place along" | "place across":
            return ScalarSignal(kind, point=Point(first), numbers=(origin(machines, first, kind == "place across"),))
        case "wind":
            return None
    if hook is None:
        return None
    match kind:
        case "height":
            return ScalarSignal(kind, point=hook.eye)
        case "pull" | "reserve":
            own = hook.line / hook.falls * gravity, *((hook.breaking,) if kind == "reserve" else ())
            return ScalarSignal(
                kind, ropes=ropes, point=hook.eye, numbers=(_lead(hook, limit.quantity) / hook.falls, *own)
            )
        case "side across":
            return ScalarSignal("side along" if limit.over == "along" else kind, ropes=ropes)
    return ScalarSignal(kind, ropes=ropes, point=hook.eye)


def _lead(hook: Hoist, quantity: Quantity) -> float:
    reeved = hook.falls, hook.drum_ends, hook.efficiency
    return drum_end_factor(*reeved, hoisting=True) if quantity == "drum pull" else lead_factor(*reeved)


def origin(machines: Sequence[Mechanism], body: str, axis: int) -> float:
    """Return the position [m] on a world axis from which a machine's coordinate along this axis is counted."""
    carried, found = {joint.child: joint for machine in machines for joint in machine.system.joints}, 0.0
    while (joint := carried.get(body)) is not None:
        found, body = found + joint.p_PJ[axis], joint.parent
    return found


def rated(plan: Plan) -> dict[str, float]:
    """Return the rated load [N] of each rope, which is 100 % utilisation; ropes without a rated load are omitted."""
    hooks = {hook.rope: hook.rated for machine in plan.machines for hook in machine.hooks if hook.rated}
    slings = {tie.rope: tie.rated for machine in plan.machines for tie in machine.ties if tie.rated}
    ropes, others = ({x.subject: x.value for x in plan.limits if x.quantity == q and x.value} for q in ROPES)
    return ropes | hooks | slings | others
