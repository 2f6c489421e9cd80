"""A state on the equilibrium path of a scene: poses of all bodies, and loads on every rope and support."""

from collections.abc import Mapping
from dataclasses import dataclass, field

REEVING = "reeving/tension"  # topic of the parts of ropes over sheaves, of which the most loaded stands for the rope

Pose = tuple[tuple[float, float, float], tuple[tuple[float, float, float], ...]]  # p_WB [m], R_WB (3, 3)


@dataclass(frozen=True)
class StaticState:
    """State of equilibrium for given positions of drives, winches and slings; bodies, joints and ropes by name."""

    t: float  # [s] of the action list, followed without inertia
    action: int  # number of the action that led here, from 1; 0: the start
    stage: str
    event: str  # what happens here ("taut legs.sling-1", "lifted"), or nothing
    tensions: Mapping[str, float]  # rope, hook rope or sling -> tension, of its most loaded part [N]
    supports: Mapping[str, float]  # support -> normal force [N]
    poses: Mapping[str, Pose]  # body -> its frame in the world
    coordinates: Mapping[str, float]  # joint -> its first coordinate [m or rad]
    references: Mapping[str, float]  # drive or winch -> commanded coordinate, or unstretched length [m]
    speeds: Mapping[str, float]  # drive or winch -> commanded speed [m/s]; hoisting is negative
    hooked: Mapping[str, str]  # sling -> lug
    grounded: bool  # whether a support of a load is closed
    stiffness: float | None  # smallest eigenvalue of stiffness over inertia [1/s2], below 0 unstable; None: not looked
    modes: Mapping[str, tuple[float, ...]] = field(default_factory=dict)  # of flexible bodies: coordinates [m or rad]


@dataclass(frozen=True)
class Acted:
    """The static state at the beginning of an action, with the taut ropes and the time [s].

    If the action had to wait, the state is that at the last event before the action."""

    before: StaticState
    taut: tuple[str, ...]
    t: float


def reeved(part: str) -> str:
    """Return the name of the rope over sheaves to which a rope part belongs."""
    return part.rpartition(".")[0]
