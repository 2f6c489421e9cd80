"""Shared by the builders of a scene's machines: the yard that they build, and where hooks and trolleys are."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal, TypeAlias

from heavylift.kernel.description.mechanics import Vector
from heavylift.nodes.plan import plan
from heavylift.nodes.plan.goliaths import machines
from heavylift.nodes.plan.limit import Limit
from heavylift.nodes.scene.keys import schema
from heavylift.nodes.scene.keys.parts.machines import GoliathParts
from heavylift.nodes.scene.language.phrases import SwingRamp
from heavylift.nodes.scene.text.source import Source

Level: TypeAlias = Literal["upper", "lower"]
UPPER: Level = "upper"
LOWER: Level = "lower"

PROVISIONAL = 0.05  # [m/s2 or rad/s2] of a ramp that lasts a swing, until that is known


@dataclass
class Yard:
    """The machines of a scene as far as they are built; its faults are collected by the source."""

    source: Source
    scene: schema.Scene
    cranes: list[plan.Crane] = field(default_factory=list)
    loaders: list[plan.Loader] = field(default_factory=list)
    block: plan.Block | None = None
    ropes: list[plan.HookRope] = field(default_factory=list)
    slings: list[plan.Sling] = field(default_factory=list)
    hooks: dict[str, tuple[str, str]] = field(default_factory=dict)  # loader -> (crane, hook)
    groups: dict[str, tuple[str, ...]] = field(default_factory=dict)  # -> loaders
    interlocks: tuple[plan.Interlock, ...] = ()
    limits: tuple[Limit, ...] = ()  # where they are known before: of several lifts
    blocks: tuple[plan.Block, ...] = ()  # of several lifts of goliaths

    @property
    def parts(self) -> tuple[plan.Mechanism, ...]:
        """Its cranes, loaders and blocks as machines made of parts, as far as they are built."""
        rig = plan.Rig(hook_ropes=tuple(self.ropes), slings=tuple(self.slings))
        own = {"cranes": tuple(self.cranes), "loaders": tuple(self.loaders), "block": self.block, "blocks": self.blocks}
        return machines(plan.Plan(name=self.scene.name, gravity=self.scene.gravity, rig=rig, **own))  # type: ignore[arg-type]

    @property
    def all_blocks(self) -> tuple[plan.Block, ...]:
        """The block of its goliaths, or those of several lifts."""
        return (self.block, *self.blocks) if self.block else self.blocks


def ramp_of(ramp: float | SwingRamp) -> tuple[float, int]:
    """Acceleration, provisional where it follows from the swing, and number of pulses of a ramp without swing."""
    return (ramp.accel or PROVISIONAL, ramp.pulses) if isinstance(ramp, SwingRamp) else (ramp, 0)


def box(mass: float, size: Vector) -> Vector:
    """Moments of inertia of a uniform box about its centre [kg m2]."""
    x, y, z = (s * s for s in size)
    return (mass / 12 * (y + z), mass / 12 * (x + z), mass / 12 * (x + y))


def parts_of(crane: schema.Crane) -> GoliathParts:
    """What its type makes of a crane: bodies, drives, and where the ropes of its hooks leave the trolleys."""
    assert crane.parts is not None
    return crane.parts


def trolley_start(yard: Yard, name: str, crane: schema.Crane, trolley: str) -> float:
    """y of a trolley at the start: as written, or above the mean of the lugs its loaders carry [m]."""
    written = crane.upper_trolley if trolley == UPPER else crane.lower_trolley
    block, rig = yard.scene.block, yard.scene.rig
    if written is not None or block is None or rig is None:
        return written if written is not None else sum(crane.girder) / 2
    hung = [loader for loader, (c, h) in yard.hooks.items() if c == name and parts_of(crane).hooks[h].on == trolley]
    lugs = [lug for loader in hung for lug in rig.loaders[loader].lugs or () if lug in block.lugs]
    if not lugs:
        return sum(crane.girder) / 2
    return block.at[1] + sum(block.lugs[lug][1] for lug in lugs) / len(lugs)


def by_beam(lugs: list[str], u: dict[str, float]) -> list[str]:
    """Two lugs in the order of the beam's ends, smaller u first."""
    return sorted(lugs, key=lambda lug: u[lug])
