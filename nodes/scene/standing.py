"""Where everything of a lift stands in one static state: hooks, loaders, lugs, the block.

Ropes hang plumb and do not stretch.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass

from . import plan, schema
from .yard import HOOKS, exit_height

SLACK = 0.06  # a sling this short of its length counts as taut [m]


@dataclass(frozen=True)
class State:
    """Where everything stands; keys are the names of cranes, drives, ropes and slings."""

    cranes: dict[str, float]  # x [m]
    trolleys: dict[tuple[str, str], float]  # y [m]
    ropes: dict[str, float]  # unstretched length [m]
    lugs: dict[str, str]  # of hooked slings
    at: tuple[float, float, float]  # middle of the block [m]
    theta: float  # [rad]
    grounded: bool


class Standing:
    """The geometry of a scene in its present `state`."""

    def __init__(self, scene: schema.Scene, built: plan.Plan) -> None:
        assert scene.block is not None
        self.scene, self.plan, self.block = scene, built, scene.block
        self.ropes = {rope.name: rope for rope in built.rig.hook_ropes}
        self.rope_of = {rope.carries: rope.name for rope in built.rig.hook_ropes}
        self.slings = {sling.name: sling for sling in built.rig.slings}
        self.state = State(
            cranes={c.name: c.gantry.start for c in built.cranes},
            trolleys={(c.name, t.name): t.axis.start for c in built.cranes for t in (c.upper, c.lower)},
            ropes={rope.name: rope.L0 for rope in built.rig.hook_ropes},
            lugs={sling.name: sling.lug for sling in built.rig.slings if sling.lug},
            at=scene.block.at,
            theta=0.0,
            grounded=True,
        )

    def eye(self, loader: str) -> tuple[float, float, float]:
        """The hook eye of a loader under its plumb rope [m]."""
        rope = self.ropes[self.rope_of[loader]]
        crane = self.scene.cranes[rope.crane]
        trolley, side = HOOKS[rope.hook]
        x = self.state.cranes[rope.crane] + side * crane.hook_spacing
        z = exit_height(crane, rope.hook) - self.state.ropes[rope.name]
        return (x, self.state.trolleys[rope.crane, trolley], z)

    def offset(self, p: tuple[float, float, float], theta: float | None = None) -> tuple[float, float, float]:
        """From the middle of the block to one of its points, in world axes [m]."""
        t = self.state.theta if theta is None else theta
        u, v, w = p
        return (u, v * math.cos(t) + w * math.sin(t), w * math.cos(t) - v * math.sin(t))

    def place(self, lug: str) -> tuple[float, float, float]:
        """World position of a lug [m]."""
        x, y, z = self.offset(self.block.lugs[lug])
        return (self.state.at[0] + x, self.state.at[1] + y, self.state.at[2] + z)

    def mean(self, lugs: list[str], theta: float | None = None) -> tuple[float, float, float]:
        """From the middle of the block to the mean of its lugs, in world axes [m]."""
        u, v, w = (sum(self.block.lugs[lug][axis] for lug in lugs) / len(lugs) for axis in range(3))
        return self.offset((u, v, w), theta)

    def carriers(self) -> dict[str, list[str]]:
        """Loaders with hooked slings -> their lugs."""
        found: dict[str, list[str]] = {}
        for sling, lug in self.state.lugs.items():
            found.setdefault(self.slings[sling].loader, []).append(lug)
        return found

    def hangs_at(self, loader: str, lugs: list[str]) -> float:
        """Height of the middle of the block if it hung from this loader without slack [m]."""
        given = self.loader(loader)
        return self.eye(loader)[2] - given.height - given.sling - self.mean(lugs)[2]

    def taut(self, loaders: Iterable[str] | None = None) -> list[str]:
        """The loaders whose slings are taut, among these."""
        carriers = self.carriers()
        wanted = carriers if loaders is None else [name for name in loaders if name in carriers]
        return [name for name in wanted if self.hangs_at(name, carriers[name]) > self.state.at[2] - SLACK]

    def above(self, loaders: Iterable[str]) -> bool:
        """Whether one of these loaders would hold the block above where it is."""
        carriers = self.carriers()
        return any(self.hangs_at(x, carriers[x]) > self.state.at[2] + SLACK for x in loaders if x in carriers)

    def rest(self) -> float:
        """Height of the middle of the block when it stands on its stools [m]."""
        return self.block.supports.height + self.block.size[2] / 2

    def loader(self, name: str) -> schema.Loader:
        """A loader as the scene file gives it."""
        assert self.scene.rig is not None
        return self.scene.rig.loaders[name]


def reach(at: Standing, sling: str, lug: str) -> str:
    """A sentence if a sling is too short for its lug or hangs too far beside it, else nothing."""
    given = at.slings[sling]
    eye, p = at.eye(given.loader), at.place(lug)
    beam = (eye[0] + given.beam.p[0], eye[1] + given.beam.p[1], eye[2] - at.loader(given.loader).height)
    gap = math.dist(beam, p) - given.L0
    beside = math.hypot(beam[0] - p[0], beam[1] - p[1])
    if gap <= SLACK / 10:
        return ""
    if beside > 0.05 * given.L0:
        told = f"the hook stands {beside:.1f} m beside the lug {lug}, too far for the {given.L0:g} m of {sling}"
        return f"{told} ({gap * 1000:.0f} mm are missing): move crane or trolley first"
    told = f"{sling} is {gap * 1000:.0f} mm too short for the lug {lug}"
    return f"{told}: lower the hook or take a longer sling than {given.L0:g} m"
