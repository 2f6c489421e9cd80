"""The signals that each limit checks, taken from the kernel's table of quantities: one row for each quantity.

A limit checks one signal, or a reduction over signals: the largest of several (winds, lugs of a sling), the sum (legs
of a bridle), the range over time while a winch stands, the speed ordered in the stages with lift-off or landing, or the
largest with the water's dynamic force since the sample before (`splash`).

Loads are the mass below the hook blocks [kg]. The load of the parts of a hook rope is the force at the upper end of one
part: at the drum in hoisting, or in the most loaded part, which is the drum part in hoisting and the dead end in
lowering.
"""

from collections.abc import Iterator, Sequence
from typing import Literal, NamedTuple, TypeAlias

from heavylift.kernel.description.forces import Wind
from heavylift.kernel.description.mechanics import Point, Quantity as Kind
from heavylift.kernel.description.signals import ScalarSignal
from heavylift.nodes.plan.actions import Action, Move
from heavylift.nodes.plan.connections import lug_places
from heavylift.nodes.plan.limit import TOUCHING, Quantity, RatedLimit
from heavylift.nodes.plan.mechanism import Footing, Hoist, Mechanism, Tie
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
    "bridle angle": "slope",
    "assembly load": "vertical load",
    "side force": "side across",  # or along, as the limit is over
    "hook height": "height",
    "relative heave": "height over",
    "rope length": "length",
    "rails": "place along",
    "girder": "place across",
    "wind": "wind",
    "ground pressure": "corner load",  # or of a track
    "wheel load": "corner load",
    "uplift": "tipping",
    "drive moment": "starting moment",  # or of what is held, as the limit is over
    "brake moment": "joint moment",
}
Reduction: TypeAlias = Literal["largest", "sum", "range at rest", "ordered speed", "splash zone"]
REDUCTIONS: dict[Quantity, Reduction] = {  # of all others: the largest
    "assembly load": "sum",
    "relative heave": "range at rest",
    **dict.fromkeys(TOUCHING, "ordered speed"),
    **dict.fromkeys(("slack sling", "splash load"), "splash zone"),
}
OF_TENSIONS = ("load", "tension", "use", "pull", "reserve")  # kinds of which a run knows an exact peak
CORNERS = {"front left": (1.0, 1.0), "front right": (1.0, -1.0), "rear left": (-1.0, 1.0), "rear right": (-1.0, -1.0)}
TRACKS = {"left": 1.0, "right": -1.0}


OF_BOOMS: dict[Kind, Kind] = {"swing along": "boom lead", "swing across": "side lead"}


class MeasuredSignal(NamedTuple):
    """A signal that a limit checks.

    With a `sling`, the signal counts only while the sling is taut and hooked to the `lug` (if any)."""

    signal: ScalarSignal
    sling: Tie | None = None
    lug: str = ""


def hooks_of(machines: Sequence[Mechanism]) -> dict[str, Hoist]:
    """Return all hooks of the machines, by the name of the hook rope."""
    return {hook.rope: hook for machine in machines for hook in machine.hooks}


def measured(
    limit: RatedLimit, machines: Sequence[Mechanism], gravity: float, actions: Sequence[Action] = ()
) -> list[MeasuredSignal]:
    """Return the signals that a limit checks; empty for a clearance, which is computed from shapes instead."""
    kind = KINDS.get(limit.quantity)
    if kind in ("slope", "vertical load"):
        return [x for name in limit.elements for x in sling_signals(name, kind, machines, gravity)]
    if kind == "wind":
        winds = (f for m in machines for f in m.system.forces if isinstance(f, Wind) and f.name in limit.elements)
        return [MeasuredSignal(ScalarSignal(kind, of=f.name, point=f.at)) for f in winds]
    x = signal_of(limit, machines, gravity, actions)
    return [MeasuredSignal(x)] if x else []


def sling_signals(
    name: str, kind: Literal["slope", "vertical load"], machines: Sequence[Mechanism], gravity: float
) -> Iterator[MeasuredSignal]:
    """Yield the signal of a sling for each of the lugs that it may be hooked to."""
    tie = next((tie for machine in machines for tie in machine.ties if tie.rope == name), None)
    numbers = (1.0 / gravity,) if kind == "vertical load" else ()
    ends = {"": tie.lower} if tie and tie.lower else lug_places(machines) if tie else {}
    for lug, point in ends.items():
        assert tie is not None  # or it has no ends
        yield MeasuredSignal(
            ScalarSignal(kind, ropes=(name,), point=point, origin=tie.upper, numbers=numbers), tie, lug
        )


def signal_of(
    limit: RatedLimit, machines: Sequence[Mechanism], gravity: float, actions: Sequence[Action] = ()
) -> ScalarSignal | None:
    """Return the signal that a limit checks; None if the limit checks several signals or a clearance.

    `gravity` [m/s2]; `actions`: needed only for the moment of a drive that starts."""
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
        case "wind" | "slope" | "vertical load":
            return None
        case "corner load" | "tipping":
            footing = next((m.footing for m in machines if m.name == first), None)
            return _of_base(limit, footing, gravity) if footing else None
        case "joint moment" | "starting moment":
            return _about_joint(limit, machines, actions)
    if hook is None:
        return None
    match kind:
        case "height over":
            return ScalarSignal(kind, point=hook.eye, origin=Point(ropes[1]))
        case "height":
            return ScalarSignal(kind, point=hook.eye)
        case "pull" | "reserve":
            own = hook.line / hook.falls * gravity, *((hook.breaking,) if kind == "reserve" else ())
            return ScalarSignal(
                kind, ropes=ropes, point=hook.eye, numbers=(_lead(hook, limit.quantity) / hook.falls, *own)
            )
        case "side across":
            return ScalarSignal("side along" if limit.over == "along" else kind, ropes=ropes)
    if hook.axis and kind in OF_BOOMS:
        return ScalarSignal(OF_BOOMS[kind], ropes=ropes, point=hook.eye, origin=hook.axis)
    return ScalarSignal(kind, ropes=ropes, point=hook.eye)


def _lead(hook: Hoist, quantity: Quantity) -> float:
    reeved = hook.falls, hook.drum_ends, hook.efficiency
    return drum_end_factor(*reeved, hoisting=True) if quantity == "drum pull" else lead_factor(*reeved)


def _of_base(limit: RatedLimit, x: Footing, gravity: float) -> ScalarSignal:
    """Return the signal of the ground pressure, wheel load or distance to tipping of a footing."""
    base = 1.0, 0.0, x.length, x.width
    if limit.quantity == "uplift":
        return ScalarSignal("tipping", point=Point(x.body, x.at), numbers=(*base, float(x.kind == "wheels")))
    area = x.each * x.length if x.kind == "tracks" else x.each
    times, plus = (area / x.mat[0], x.mat[1] * gravity / x.mat[0]) if x.mat else (1.0, 0.0)
    if x.kind == "tracks":
        numbers = *base, x.each, TRACKS[limit.over], times, plus
        return ScalarSignal("track pressure", point=Point(x.body, x.at), numbers=numbers)
    times /= gravity * x.each if x.kind == "wheels" else x.each
    return ScalarSignal("corner load", point=Point(x.body, x.at), numbers=(*base, *CORNERS[limit.over], times, plus))


def _about_joint(limit: RatedLimit, machines: Sequence[Mechanism], actions: Sequence[Action]) -> ScalarSignal:
    """Return the signal of the moment with which the drive or brake of a revolute joint holds the bodies on the joint;
    for a limit over "start", with the largest ordered acceleration."""
    (child,) = limit.elements
    machine, joint = next((m, j) for m in machines for j in m.system.joints if j.child == child)
    if limit.over != "start":
        return ScalarSignal("joint moment", of=joint.name)
    drive = next(drive.name for drive in machine.system.drives if drive.joint == joint.name)
    moves = (x for action in actions for x in action.orders if isinstance(x, Move) and x.actuator == drive)
    ramp = max((x.accel for x in moves), default=next(a.accel for a in machine.actuators if a.name == drive))
    return ScalarSignal("starting moment", of=joint.name, numbers=(ramp,))


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
