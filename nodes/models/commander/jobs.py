"""Orders in progress, conflicts between them, and the format of times in messages."""

from collections.abc import Iterable
from dataclasses import dataclass

from heavylift.nodes.plan import actions as scene
from heavylift.nodes.plan.interlock import BarredActuator
from heavylift.nodes.plan.places import numbered

from .conditions import OrderRejected


@dataclass
class CommanderJob:
    """An order in progress, until its actor reports `Done` or, for an order to wait, until its end time."""

    id: int
    at: tuple[int, int]
    verb: str
    actor: str
    since_ns: int
    until: scene.Condition | None = None
    ends_ns: int | None = None
    followers: tuple[scene.Follow, ...] = ()
    halting: bool = False
    limit: str = ""
    move: scene.Move | None = None

    @property
    def action(self) -> int:
        """Number of the action to which this order belongs."""
        return self.at[0]


def addressed(order: scene.Order) -> str | None:
    """Return the actor to which an order goes: None for a turn (several actors), "" for an order without an actor."""
    match order:
        case scene.Move():
            return order.actuator
        case scene.Hookup() | scene.UnhookSling():
            return order.sling
        case scene.BrakeOrder():
            return order.brake
        case scene.Turn():
            return None
    return ""


def still_open(jobs: list[CommanderJob], action: int) -> tuple[tuple[str, str, bool], ...]:
    """Return the unfinished orders of an action as (verb, actor or end time of a wait, whether a limit stopped it)."""
    of = [(job, job.actor if job.ends_ns is None else clock(job.ends_ns)) for job in jobs if job.action == action]
    return tuple((job.verb, actor, bool(job.limit)) for job, actor in of)


def partners(jobs: list[CommanderJob], actor: str) -> list[CommanderJob]:
    """Return the unfinished moves of the other actors that this actor's order names in `together`."""
    names = {name for job in jobs if job.actor == actor and job.move for name in job.move.together}
    return [job for job in jobs if job.actor in names - {actor} and job.move and not job.halting and not job.limit]


def barred(jobs: list[CommanderJob], stops: Iterable[BarredActuator]) -> list[tuple[str, float | None]]:
    """Return the actuators that an interlock stops in a move, each with its deceleration (None: that of the move)."""
    distances = {job.actor: job.move.by or 0.0 for job in jobs if job.move and not job.halting}
    return [
        (x.actuator, x.emergency) for x in stops if x.actuator in distances and x.way * distances[x.actuator] >= 0.0
    ]


def make_way(jobs: list[CommanderJob], actor: str) -> None:
    """Raise OrderRejected if an actor that gets an order is busy, unless it ramps down or has stopped at a limit."""
    for job in list(jobs):
        if job.actor == actor and job.limit:
            jobs.remove(job)
        elif actor == job.actor and not job.halting:
            raise OrderRejected(
                f"{actor} gets an order while its {job.verb} ({numbered(job.at)}) is not done; wait for "
                f"`moves done` or end that order with `until`",
                job.at,
            )
        elif any(actor == f.actuator for f in job.followers):
            what = "the turn" if job.verb == "turn" else job.actor
            raise OrderRejected(f"{actor} gets an order while it follows {what}; wait until that is done")


def clock(t_ns: int) -> str:
    """Return a time as text in seconds with at most three decimals, such as "812.4 s"."""
    return f"{t_ns / 1e9:.3f}".rstrip("0").rstrip(".") + " s"
