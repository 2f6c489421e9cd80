"""Choice of the joints that form the spanning tree of a system, and of those that close its loops.

The tree grows from the ground, one body at a time (Prim 1957). A body should be carried by a joint on which a spring,
stop, brake or drive acts or which is measured (its coordinates must be states), else by the joint with the fewest
degrees of freedom, so that the joints left over have the fewest rows. Preferred are joints that carry their body in
this sense, then joints near the ground, then those whose parent has mass (a massless body may not end a branch), then
those with start values, then by geometry: names decide only between joints that are equal in all this. A joint left
over closes a loop. If only a joint's child can be reached, the joint is reversed: one along a single axis is the same
joint, coordinate by coordinate, with the axis reversed.
"""

from collections.abc import Collection, Mapping
from dataclasses import replace

from heavylift.kernel.description.mechanics import JOINTS, WORLD, Brake, Drive, Joint, JointSpring, Lock, Stop, System
from heavylift.kernel.errors import KernelError


def spanning_tree(system: System, joints: Mapping[str, Joint]) -> tuple[dict[str, Joint], tuple[Joint, ...]]:
    """Return the joint that carries each body, and the joints that close loops, in the order of `joints`.

    Raises KernelError for a joint that connects a body to itself, and for a loop in which no joint can be cut.
    """
    waiting = list(joints.values())
    for j in waiting:
        if j.parent == j.child:
            raise KernelError(f"joint '{j.name}': it connects '{j.child}' to itself; give it another parent or child")
    carrier = {j.child: j for j in waiting}
    if len(carrier) == len(waiting) and WORLD not in carrier:
        return carrier, ()
    acted = _acted_on(system)
    depth = {WORLD: 0}
    carrier = {}

    def rank(j: Joint) -> tuple[bool, int]:
        return j.name not in acted, JOINTS[j.kind].n_v

    massive = {WORLD} | {b.name for b in system.bodies if b.mass > 0.0}

    def own(j: Joint) -> tuple[object, ...]:
        return _own(j, massive)

    first: dict[str, Joint] = {}  # the joint that should carry a body, once its parent is reached
    for j in waiting:
        if j.child not in first or (rank(j), own(j)) < (rank(first[j.child]), own(first[j.child])):
            first[j.child] = j

    def order(j: Joint) -> tuple[object, ...]:
        return j is not first[j.child], *rank(j), depth[j.parent], own(j)

    flexible = {b.name for b in system.bodies if b.flexible}
    while True:
        ready = [j for j in waiting if j.parent in depth and j.child not in depth]
        if not ready:
            behind = [j for j in waiting if j.child in depth and j.parent not in depth]
            if not behind:
                break
            best = min(behind, key=lambda j: (*rank(j), own(j)))
            waiting[waiting.index(best)] = first[best.parent] = _turned_round(best, flexible)
            continue
        best = min(ready, key=order)
        carrier[best.child], depth[best.child] = best, depth[best.parent] + 1
        waiting.remove(best)
    loops = tuple(j for j in waiting if j.parent in depth and j.child in depth)
    for j in loops:
        _check(j, acted, carrier)
    lost = {j.child: j for j in waiting if j not in loops}
    return carrier | lost, loops


def _own(j: Joint, massive: Collection[str]) -> tuple[object, ...]:
    """Return the sort key of joints of equal rank, independent of names."""
    return (
        j.parent in massive, not (j.q0 or j.v0), j.p_PJ, j.p_CJ, j.kind, j.axis, j.second, j.R_PJ, j.R_CJ, j.q0, j.v0,
        j.parent, j.child,
    )  # fmt: skip


def _turned_round(j: Joint, flexible: Collection[str]) -> Joint:
    """Return the joint with parent and child exchanged; raises KernelError if its coordinates would differ."""
    if JOINTS[j.kind].axes > 1 or JOINTS[j.kind].quaternion is not None or {j.parent, j.child} & set(flexible):
        raise KernelError(
            f"joint '{j.name}': no other joint carries its parent '{j.parent}', so "
            "the child must carry the parent; swap parent and child"
        )
    x, y, z = j.axis
    return replace(
        j, parent=j.child, child=j.parent, p_PJ=j.p_CJ, R_PJ=j.R_CJ, p_CJ=j.p_PJ, R_CJ=j.R_PJ, axis=(-x, -y, -z)
    )


def _acted_on(system: System) -> dict[str, str]:
    """Return the joints whose coordinates an element uses, with the name of the element."""
    laws: list[JointSpring | Stop | Brake | Drive | Lock] = [*system.springs, *system.stops, *system.brakes]
    laws += [*system.drives, *system.locks]
    acted = {x.joint: x.name for x in laws}
    acted |= {f.along[0]: f.name for f in system.forces if f.along}
    acted |= {m.of: m.name for m in system.measured if m.kind == "joint"}
    return acted | {h.of: h.name for h in system.thresholds if h.quantity in ("joint", "speed")}


def _check(j: Joint, acted: Mapping[str, str], carrier: Mapping[str, Joint]) -> None:
    other = carrier[j.child].name if j.child in carrier else WORLD
    if j.kind == "free":
        raise KernelError(
            f"joint '{j.name}': a free joint constrains nothing, and '{other}' carries '{j.child}' already; remove it"
        )
    if j.name in acted:
        raise KernelError(
            f"joint '{j.name}': '{acted[j.name]}' needs a coordinate, but this joint closes a loop and has none; "
            "remove all laws from one joint of the loop, so that that joint closes the loop"
        )
