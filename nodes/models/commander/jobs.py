"""Orders in progress, conflicts between them, and how times are written in sentences."""

from __future__ import annotations

from dataclasses import dataclass

from heavylift.nodes.plan import actions as scene
from heavylift.nodes.plan.places import numbered

from .refused import Refused
from .turn_law import Follower


@dataclass
class Job:
    """An order that is being carried out, until its Done (or, for a wait, its time) has come."""

    id: int
    at: tuple[int, int]
    verb: str
    actor: str
    since_ns: int
    until: scene.Condition | None = None
    ends_ns: int | None = None
    followers: tuple[Follower, ...] = ()
    halting: bool = False
    limit: str = ""

    @property
    def action(self) -> int:
        """Number of its action."""
        return self.at[0]


def addressed(order: scene.Order) -> str | None:
    """The actor that an order addresses; None for a turn, which moves many, "" for none."""
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


def still_open(jobs: list[Job], action: int) -> tuple[tuple[str, str, bool], ...]:
    """The orders of an action that are not done, as (verb, actor, whether a limit or an interlock stopped it)."""
    return tuple((job.verb, job.actor, bool(job.limit)) for job in jobs if job.action == action)


def stopping(jobs: list[Job], actuator: str, turn: str) -> str | None:
    """What is to be stopped that an actuator stands: itself or the turn that it follows; None if that is under way."""
    actor = turn if any(actuator == f.actuator for job in jobs for f in job.followers) else actuator
    return None if any(job.verb == "stop" and job.actor == actor for job in jobs) else actor


def make_way(jobs: list[Job], actor: str) -> None:
    """Refuse a second order to an actor that is busy; one that is ramping down or at a limit is not."""
    for job in list(jobs):
        if job.actor == actor and job.limit:
            jobs.remove(job)
        elif actor == job.actor and not job.halting:
            raise Refused(
                f"{actor} gets an order while its {job.verb} ({numbered(job.at)}) is not done, wait for "
                f"`moves done` or end that order with `until`",
                job.at,
            )
        elif any(actor == f.actuator for f in job.followers):
            raise Refused(f"{actor} gets an order while it follows the turn, wait until it is done")


def seconds(t_ns: int) -> str:
    """A time to the millisecond: "812.4 s"."""
    return f"{t_ns / 1e9:.3f}".rstrip("0").rstrip(".") + " s"
