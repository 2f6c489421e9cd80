"""What is connected with what in the machines of a plan: hooks, slings, frames, lugs, and bodies on joints."""

from collections.abc import Iterator, Mapping, Sequence

from heavylift.kernel.description.mechanics import WORLD, Drive, Joint, Point

from .mechanism import Hoist, Mechanism, Tie

LEVEL = ("travel", "traverse", "slew")  # verbs of drives that lower nothing


def frames_on_hooks(machines: Sequence[Mechanism]) -> dict[str, Hoist]:
    """Return, for each machine without hooks of its own (such as a lifting beam), the hook from which it hangs."""
    eyes = {hook.eye.body: hook for machine in machines for hook in machine.hooks}
    bodies = ((machine.name, body.name) for machine in machines if not machine.hooks for body in machine.system.bodies)
    return {name: eyes[body] for name, body in bodies if body in eyes}


def ties_on(machines: Sequence[Mechanism], hook: Hoist) -> Iterator[Tie]:
    """Yield the slings below a hook, including the slings on frames and bodies connected to the hook."""
    joined, before, ties = {hook.eye.body}, 0, [tie for machine in machines for tie in machine.ties]
    loads = {cargo.body for machine in machines for cargo in machine.cargo}
    pairs = [{j.parent, j.child} for m in machines for j in m.system.joints if WORLD not in (j.parent, j.child)]
    frames = [(tie.upper.body, tie.lower.body) for tie in ties if tie.lower and tie.lower.body not in loads]
    while len(joined) > before:
        before = len(joined)
        for ends in pairs:
            joined |= ends if ends & joined else set()
        joined |= {lower for upper, lower in frames if upper in joined}
    return (tie for tie in ties if tie.upper.body in joined)


def holders(machines: Sequence[Mechanism], body: str, hooked: Mapping[str, str]) -> tuple[list[Hoist], list[Mechanism]]:
    """Return the hooks that hold a body by slings, and all machines connected with it by slings, ropes or joints.
    `hooked`: the lug of each hooked sling."""
    places, ties = lug_places(machines), [tie for machine in machines for tie in machine.ties]
    loads = {place.body for place in places.values()}
    fixed = {tie.rope: tie.lower for tie in ties if tie.lower and tie.lower.body not in loads}
    lower = {tie.rope: fixed.get(tie.rope) or places.get(hooked.get(tie.rope, "")) for tie in ties}
    hooks = [hook for machine in machines for hook in machine.hooks]
    held = [x for x in hooks if any((p := lower[tie.rope]) and p.body == body for tie in ties_on(machines, x))]
    joined, links = {body}, [{j.parent, j.child} for m in machines for j in m.system.joints]
    links += [{tie.upper.body, p.body} for tie in ties if (p := lower[tie.rope])]
    ropes = [rope for m in machines for rope in m.system.all_ropes if rope.name not in lower]
    links += [{p.body.partition("@")[0] for p in rope.points} for rope in ropes]
    links = [link - {WORLD} for link in links]
    while more := {name for link in links if link & joined for name in link} - joined:
        joined |= more
    return held, [m for m in machines if joined & {x.name for x in m.system.bodies}]


def lowering(machines: Sequence[Mechanism]) -> tuple[list[str], list[Drive]]:
    """Return the winch ropes (other than hook ropes) and the drives that can lower the loads of these machines."""
    hooks = {hook.rope for machine in machines for hook in machine.hooks}
    lowers = {x.name for m in machines for x in m.actuators if x.verb not in LEVEL} - hooks
    ropes = [rope.name for m in machines for rope in m.system.all_ropes if rope.name in lowers]
    return ropes, [drive for m in machines for drive in m.system.drives if drive.name in lowers]


def carried_hooks(machine: Mechanism, body: str) -> list[Hoist]:
    """Return, sorted by rope, the hooks whose ropes hang from a body or from bodies that this body carries."""
    own = (hook for hook in machine.hooks if body in (hook.on, *(joint.parent for joint in beneath(machine, hook.on))))
    return sorted(own, key=lambda hook: hook.rope)


def beneath(machine: Mechanism, body: str) -> Iterator[Joint]:
    """Yield the joints of a machine that carry a body, from the body down to the ground."""
    carried = {joint.child: joint for joint in reversed(machine.system.joints)}
    while (joint := carried.get(body)) is not None:
        yield joint
        body = joint.parent


def is_root(machine: Mechanism, body: str) -> bool:
    """Return whether this body is the base of its machine: no joint connects it to a body that carries it."""
    return all(joint.parent == WORLD for joint in machine.system.joints if joint.child == body)


def lug_places(machines: Sequence[Mechanism]) -> dict[str, Point]:
    """Return the points of the lugs on lifted bodies, by the name of the lug."""
    return {name: Point(c.body, p) for machine in machines for c in machine.cargo for name, p in c.lugs.items()}
