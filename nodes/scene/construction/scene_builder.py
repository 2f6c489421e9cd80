"""Shared by the builders of a scene's machines: the yard that they build, and where hooks and trolleys are."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal, TypeAlias

from heavylift.kernel.description.mechanics import Vector
from heavylift.nodes.plan import plan
from heavylift.nodes.plan.limit import RatedLimit
from heavylift.nodes.plan.mechanism import Cargo
from heavylift.nodes.scene.keys import schema
from heavylift.nodes.scene.keys.parts.machines import PortalParts
from heavylift.nodes.scene.language.phrases import SwingRamp
from heavylift.nodes.scene.text.source import Source

Level: TypeAlias = Literal["upper", "lower"]
UPPER: Level = "upper"
LOWER: Level = "lower"
LEVELS = UPPER, LOWER

PROVISIONAL = 0.05  # [m/s2 or rad/s2] of a ramp that lasts a swing, until that is known


@dataclass
class SceneBuilder:
    """The machines of a scene as far as they are built; its faults are collected by the source."""

    source: Source
    scene: schema.Scene
    machines: list[plan.Mechanism] = field(default_factory=list)  # that are modelled on levels
    hooks: dict[str, tuple[str, str]] = field(default_factory=dict)  # beam -> (crane, hook)
    groups: dict[str, tuple[str, ...]] = field(default_factory=dict)  # -> beams
    interlocks: tuple[plan.Interlock, ...] = ()
    limits: tuple[RatedLimit, ...] = ()  # where they are known before: of several lifts

    @property
    def cranes(self) -> list[plan.Mechanism]:
        """Cranes on rails: the drive of the gantry is the first actuator, those of the trolleys the next two."""
        return [machine for machine in self.machines if machine.girders]

    @property
    def ropes(self) -> list[str]:
        """Their hook ropes."""
        return [f"{crane}.{hook}" for crane, hook in self.hooks.values()]

    @property
    def cargo(self) -> list[Cargo]:
        """What they lift."""
        return [cargo for machine in self.machines for cargo in machine.cargo]

    def slings(self, *beams: str) -> list[plan.Tie]:
        """The slings of beams, or of all."""
        own = (machine for machine in self.machines if not beams or machine.name in beams)
        return [tie for machine in own for tie in machine.ties]


def ramp_of(ramp: float | SwingRamp) -> tuple[float, int]:
    """Acceleration, provisional where it follows from the swing, and number of pulses of a ramp without swing."""
    return (ramp.accel or PROVISIONAL, ramp.pulses) if isinstance(ramp, SwingRamp) else (ramp, 0)


def box(mass: float, size: Vector) -> Vector:
    """Moments of inertia of a uniform box about its centre [kg m2]."""
    x, y, z = (s * s for s in size)
    return (mass / 12 * (y + z), mass / 12 * (x + z), mass / 12 * (x + y))


def parts_of(crane: schema.CraneKeys) -> PortalParts:
    """What its type makes of a crane: bodies, drives, and where the ropes of its hooks leave the trolleys."""
    assert crane.parts is not None
    return crane.parts


def by_beam(lugs: list[str], u: dict[str, float]) -> list[str]:
    """Lugs of the slings of a beam: two in the order of its ends, smaller u first."""
    return sorted(lugs, key=lambda lug: u[lug]) if len(lugs) == 2 else lugs
