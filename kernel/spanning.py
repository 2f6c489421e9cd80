"""Which joints of a graph form its spanning tree, and which close its loops.

The tree grows from the ground, one body at a time (Prim 1957).  A body should be carried by a joint on which a spring,
stop, brake or drive acts or which something measures (its coordinates must be states), else by that with the fewest
freedoms, so that the joints left over have the fewest rows; joints that carry their body so come first, then those near
the ground, then those first in the list.  A joint left over closes a loop.
"""

from __future__ import annotations

from collections.abc import Mapping

from .describe import WORLD, Brake, Drive, Joint, JointSpring, Lock, Stop, System
from .errors import KernelError
from .joints import JOINTS

__all__ = ["spanning_tree"]


def spanning_tree(system: System, joints: Mapping[str, Joint]) -> tuple[dict[str, Joint], tuple[Joint, ...]]:
    """The joint that carries each body, and the joints that close loops, in the order of the list.

    Raises KernelError for a joint that joins a body to itself, and for a loop in which no joint can be cut.
    """
    waiting = list(joints.values())
    for j in waiting:
        if j.parent == j.child:
            raise KernelError(f"joint '{j.name}': it joins '{j.child}' to itself; give it another parent or child")
    carrier = {j.child: j for j in waiting}
    if len(carrier) == len(waiting) and WORLD not in carrier:
        return carrier, ()
    acted = _acted_on(system)
    depth = {WORLD: 0}
    carrier = {}

    def rank(j: Joint) -> tuple[bool, int]:
        return j.name not in acted, JOINTS[j.kind].n_v

    first: dict[str, Joint] = {}  # the joint that should carry a body, once its parent is reached
    for j in waiting:
        if j.child not in first or rank(j) < rank(first[j.child]):
            first[j.child] = j

    def order(j: Joint) -> tuple[bool, bool, int, int]:
        return j is not first[j.child], *rank(j), depth[j.parent]

    while ready := [j for j in waiting if j.parent in depth and j.child not in depth]:
        best = min(ready, key=order)
        carrier[best.child], depth[best.child] = best, depth[best.parent] + 1
        waiting.remove(best)
    loops = tuple(j for j in waiting if j.parent in depth and j.child in depth)
    for j in loops:
        _check(j, acted, carrier)
    lost = {j.child: j for j in waiting if j not in loops}
    return carrier | lost, loops


def _acted_on(system: System) -> dict[str, str]:
    """Joints whose coordinates something acts on or measures, with its name."""
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
            f"joint '{j.name}': a free joint constrains nothing, and '{other}' carries '{j.child}' already"
        )
    if j.name in acted:
        raise KernelError(
            f"joint '{j.name}': it closes a loop, so that '{acted[j.name]}' finds no coordinate in it; "
            "every other joint of the loop is in use, too: free one of them of its laws"
        )
