"""The two-crane reference scene of 24 degrees of freedom with redundant pins, and many copies side by side."""

from dataclasses import replace

from goliath import HOOK_Y, scene
from heavylift.kernel.description import WORLD, Joint, System

__all__ = ["HOOK_Y", "copies", "pinned", "scene"]


def pinned(one):
    """The scene with each of six loaders on two pins in line: 36 redundant rows of rank 30 among bodies cut loose,
    of which the kernel's spanning tree leaves 18."""
    joints = []
    for j in one.joints:
        x, y, z = j.p_PJ
        ends = ((f"{j.name}-{d}", d) for d in (-0.5, 0.5))
        pins = [Joint(name, "spherical", "block", j.child, (x + d, y, z), p_CJ=(d, 0.0, 0.0)) for name, d in ends]
        joints += pins if j.parent == "block" else [j]
    springs = tuple(x for x in one.springs if not x.joint.startswith("low"))  # pins have no friction
    return replace(one, joints=tuple(joints), springs=springs)


def copies(n, hooks):
    """n reference scenes side by side, with so many hooks a crane."""
    one = scene(hooks)

    def renamed(part, i):
        if isinstance(part, tuple):
            return tuple(renamed(x, i) for x in part)
        fields = getattr(part, "__dataclass_fields__", None)
        if fields is None:
            return part
        names = {"name", "parent", "child", "joint", "body", "of"} & set(fields)
        own = {k: renamed(getattr(part, k), i) for k in fields}
        own |= {k: f"{getattr(part, k)}-{i}" for k in names if getattr(part, k) != WORLD}
        return type(part)(**own)

    groups = ("bodies", "joints", "springs", "drives", "ropes")
    return System(
        **{g: tuple(renamed(x, i) for i in range(n) for x in getattr(one, g)) for g in groups}, gravity=one.gravity
    )
