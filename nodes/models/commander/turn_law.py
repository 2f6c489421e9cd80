"""The turn-over law: what trolleys and winches follow so that the block's centre of gravity stays in place.

A lug at (v, w) from the centre of gravity stands at y = v cos(theta) + w sin(theta), z = w cos(theta) - v
sin(theta) from it (theta turns +w towards +y).  A trolley stays above the mean of the lugs that a loader
carries, its winch pays out what that lug sinks: ref(theta) = const + kc cos(theta) + ks sin(theta) with
(kc, ks) = (v, w) for the trolley and (-w, v) for the rope.  Sent once per turn; elasticity shifts the true
angle by a few tenths of a degree.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from heavylift.nodes.plan.plan import HookRope, Plan, drive_name

from .refused import Refused

SAME = 1e-9  # [m]


@dataclass(frozen=True)
class Follower:
    """An actuator of a crane and its coefficients [m]."""

    crane: str
    actuator: str
    kc: float
    ks: float


def followers(plan: Plan, lugs: Mapping[str, str]) -> list[Follower]:
    """All trolleys and winches that carry slings; `lugs` = lug of each hooked sling.  Raises Refused if none can."""
    found: dict[str, Follower] = {}
    for rope in plan.rig.hook_ropes:
        mean = _mean(plan, rope, lugs)
        if mean is None:
            continue
        v, w = mean
        hook = next(h for c in plan.cranes if c.name == rope.crane for h in c.hooks if h.name == rope.hook)
        trolley = Follower(rope.crane, drive_name(rope.crane, hook.trolley), v, w)
        other = found.setdefault(trolley.actuator, trolley)
        if abs(other.kc - v) > SAME or abs(other.ks - w) > SAME:
            raise Refused(
                f"the hooks of {rope.crane} {hook.trolley} trolley carry lugs at "
                f"different places, v, w = {other.kc:g}, {other.ks:g} m and {v:g}, {w:g} m, "
                f"and one trolley cannot follow both in a turn"
            )
        found[rope.name] = Follower(rope.crane, rope.name, -w, v)
    if not found:
        raise Refused("the block cannot turn, no sling is hooked")
    return list(found.values())


def _mean(plan: Plan, rope: HookRope, lugs: Mapping[str, str]) -> tuple[float, float] | None:
    """Mean (v, w) from the centre of gravity of the lugs that hang on a hook rope [m]."""
    if plan.block is None:
        return None
    places = {lug.name: lug.p for lug in plan.block.lugs}
    com = plan.block.body.com
    hung = [lugs[s.name] for s in plan.rig.slings if s.loader == rope.carries and s.name in lugs]
    if not hung:
        return None
    return (
        sum(places[name][1] for name in hung) / len(hung) - com[1],
        sum(places[name][2] for name in hung) / len(hung) - com[2],
    )
