"""The turn-over law: references for trolleys and winches that keep the block's centre of gravity in place.

A lug at (v, w) from the centre of gravity is, at the turn angle theta, displaced from it by y = v cos(theta) + w
sin(theta) and z = w cos(theta) - v sin(theta) (theta turns +w towards +y). A trolley stays above the mean of the lugs
on its hook, and its winch pays out as much rope as this mean point sinks: ref(theta) = const + kc cos(theta) + ks
sin(theta) with (kc, ks) = (v, w) for the trolley and (-w, v) for the rope. The law is sent once for each turn;
elasticity shifts the true angle by a few tenths of a degree.
"""

from collections.abc import Mapping, Sequence

from heavylift.nodes.plan.actions import Follow
from heavylift.nodes.plan.connections import beneath, ties_on
from heavylift.nodes.plan.mechanism import Hoist, Mechanism

from .actuator_registry import TURN
from .conditions import OrderRejected

SAME = 1e-9  # [m]
LEVER = 0.1  # [m] between lines of lugs below which the stretch of slings decides how far a block turns
ACROSS = (0.0, 1.0, 0.0)  # the way of what follows a turn


def followers(
    machines: Sequence[Mechanism], lugs: Mapping[str, str], block: str = "block", master: str = TURN
) -> list[Follow]:
    """Return the reference laws by which trolleys and winches follow a turn of the block that they hold by slings.

    `lugs`: lug of each hooked sling. Raises OrderRejected if no hook can follow the turn, or if none can tilt the block
    since all its lugs are in one line."""
    found: dict[str, Follow] = {}
    lines: list[tuple[float, float]] = []
    cargo = next((c for machine in machines for c in machine.cargo if c.body == block), None)
    for machine, hook in ((m, h) for m in machines for h in m.hooks):
        hung = [lugs[tie.rope] for tie in ties_on(machines, hook) if tie.rope in lugs]
        places = [cargo.lugs[lug] for lug in hung if lug in cargo.lugs] if cargo else []
        if cargo is None or not places:
            continue
        v, w = (sum(p[i] for p in places) / len(places) - cargo.com[i] for i in (1, 2))
        lines.append((v, w))
        drive = traversing(machine, hook)
        if not drive:
            raise OrderRejected(f"the block cannot turn: no drive moves {hook.on} of {machine.name} sideways")
        trolley = Follow(model=machine.name, actuator=drive, master=master, law=(0.0, v, w))
        _, kc, ks = found.setdefault(drive, trolley).law
        if abs(kc - v) > SAME or abs(ks - w) > SAME:
            raise OrderRejected(
                f"the hooks on {hook.on} hold lugs at different places of the block: those of {hook.rope} lie {v:g} m "
                f"from its centre of mass along its axis v and {w:g} m along w, those of another hook {kc:g} m and "
                f"{ks:g} m; one trolley cannot follow both in a turn"
            )
        found[hook.rope] = Follow(model=machine.name, actuator=hook.rope, master=master, law=(0.0, -w, v))
    if not found:
        raise OrderRejected("the block cannot turn: no sling is hooked")
    (y, z), *others = lines
    if all(max(abs(v - y), abs(w - z)) < LEVER for v, w in others):
        raise OrderRejected(
            f"the block cannot turn: all hooks pull along a single line, {y:g} m beside and {z:g} m above its "
            "centre of mass; hook slings of another trolley to lugs away from this line"
        )
    return list(found.values())


def traversing(machine: Mechanism, hook: Hoist) -> str:
    """Return the drive that moves a hook's suspension across the girder, or "" if there is none."""
    drives = {drive.joint: drive.name for drive in machine.system.drives}
    slides = (x.name for x in beneath(machine, hook.on) if x.kind == "prismatic" and x.axis == ACROSS)
    return next((drives[joint] for joint in slides if joint in drives), "")
