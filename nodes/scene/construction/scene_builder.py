"""Data that the builders of a scene's machines share: the machines built so far, and the hooks of frames."""

from dataclasses import dataclass, field

from heavylift.kernel.description.mechanics import Vector
from heavylift.nodes.plan import plan
from heavylift.nodes.plan.limit import RatedLimit
from heavylift.nodes.plan.mechanism import Cargo
from heavylift.nodes.scene.keys import schema
from heavylift.nodes.scene.language.phrases import SwingRamp
from heavylift.nodes.scene.text.source import SourceText
from heavylift.nodes.sea.hydrodynamics import Hydrodynamics

UPPER, LOWER = "upper", "lower"  # faces of a block

PROVISIONAL = 0.05  # [m/s2 or rad/s2] of a ramp that lasts a swing, until that is known


@dataclass
class SceneBuilder:
    """Collects the machines of a scene while they are built; errors are added to the scene."""

    source: SourceText
    scene: schema.Scene
    machines: list[plan.Mechanism] = field(default_factory=list)
    vessels: list[plan.Mechanism] = field(default_factory=list)
    hooks: dict[str, tuple[str, str]] = field(default_factory=dict)  # frame -> (machine, hook)
    groups: dict[str, tuple[str, ...]] = field(default_factory=dict)  # -> frames
    hulls: dict[str, Hydrodynamics | None] = field(default_factory=dict)  # of vessels, read once
    interlocks: tuple[plan.Interlock, ...] = ()
    limits: tuple[RatedLimit, ...] = ()  # where they are known before: of several lifts

    @property
    def cranes(self) -> list[plan.Mechanism]:
        """The machines with hooks built so far, including machines whose hooks will be added later."""
        could = {name for name, given in self.scene.machines.items() if given.hooks}
        return [machine for machine in self.machines if machine.hooks or machine.name in could]

    @property
    def frames(self) -> list[plan.Mechanism]:
        """The frames that the rig hangs on hooks."""
        return [machine for machine in self.machines if machine.name in self.hooks]

    @property
    def tandem(self) -> bool:
        """Whether hooks of several machines carry loads at the start."""
        words = (word for given in self.scene.rigging.values() for word in getattr(given, "holders", ()))
        others = {word.replace(".", " ").split()[0] for word in words} - {*self.scene.rigging}
        return len({machine for machine, _ in self.hooks.values()} | others) > 1

    @property
    def cargo(self) -> list[Cargo]:
        """The lifted bodies."""
        return [cargo for machine in self.machines for cargo in machine.cargo]

    def slings(self, *beams: str) -> list[plan.Tie]:
        """Return the slings of the frames with these names, or all slings if none is named."""
        return [tie for frame in self.frames if not beams or frame.name in beams for tie in frame.ties]


def ramp_of(ramp: float | SwingRamp) -> tuple[float, int]:
    """Return the acceleration of a ramp and its number of pulses (0: an ordinary ramp).

    The acceleration of a ramp without swing is provisional if it is not given."""
    return (ramp.accel or PROVISIONAL, ramp.pulses) if isinstance(ramp, SwingRamp) else (ramp, 0)


def box(mass: float, size: Vector) -> Vector:
    """Return the moments of inertia of a uniform box about its centre [kg m2]."""
    x, y, z = (s * s for s in size)
    return (mass / 12 * (y + z), mass / 12 * (x + z), mass / 12 * (x + y))


def by_beam(lugs: list[str], u: dict[str, float]) -> list[str]:
    """Return the lugs of a lifting beam's slings in the order of the beam's ends; two lugs are sorted by x."""
    return sorted(lugs, key=lambda lug: u[lug]) if len(lugs) == 2 else lugs
