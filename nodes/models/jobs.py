"""An order that is under way, and how times are written in sentences."""

from __future__ import annotations

from dataclasses import dataclass

from heavylift.nodes.scene import actions as scene

from .turn import Follower


@dataclass
class Job:
    """An order that is being carried out, until its Done (or, for a wait, its time) has come."""

    id: int
    action: int
    order: scene.Order
    verb: str
    actor: str
    since_ns: int
    until: scene.Condition | None = None
    ends_ns: int | None = None
    followers: tuple[Follower, ...] = ()
    halting: bool = False
    limit: str = ""


def addressed(order: scene.Order) -> str | None:
    """The actor that an order addresses; None for a turn, which moves many, "" for nobody."""
    match order:
        case scene.Move():
            return order.actuator
        case scene.Hookup() | scene.Unhook():
            return order.sling
        case scene.Brake():
            return order.brake
        case scene.Turn():
            return None
    return ""


def seconds(t_ns: int) -> str:
    """A time to the millisecond: "812.4 s"."""
    return f"{t_ns / 1e9:.3f}".rstrip("0").rstrip(".") + " s"
