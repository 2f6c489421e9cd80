"""The entities that move through a queueing network, and the order in which they wait."""

from collections.abc import Mapping
from heapq import heappop, heappush
from itertools import accumulate
from math import isfinite
from typing import ClassVar, Literal, get_args

from heavylift.kernel.errors import ModelError
from heavylift.nodes.devs import Atomic, Message

Discipline = Literal["first in, first out", "last in, first out", "priority"]


class Entity(Message):
    """A customer, job or part: number, kind, priority (lowest first), and the time of its creation [ns]."""

    units: ClassVar[Mapping[str, str]] = {"born": "ns"}
    number: int
    kind: str = ""
    priority: int = 0
    born: int = 0


class Demand(Message):
    """Message by which a server demands this number of entities from a queue."""

    count: int = 1


class NetworkPart(Atomic):
    """Base class of the atomic models in a queueing network."""

    @property
    def ns(self) -> int:
        """The present simulation time [ns]."""
        return self._present.now[0]


class Waiting:
    """A queue of entities, served in the order of arrival, in the reverse order, or by priority."""

    def __init__(self, discipline: str = "first in, first out") -> None:
        if discipline not in get_args(Discipline):
            raise ModelError(f"there is no discipline '{discipline}'; choose one of {', '.join(get_args(Discipline))}")
        self._by_priority = discipline == "priority"
        self.heap = list[tuple[int, int, int, int, Entity]]()

    def __len__(self) -> int:
        return len(self.heap)

    def put(self, turn: int, since: int, left: int, entity: Entity) -> None:
        """Add an entity to the queue, with `turn` as its sort key in the order of service.

        `since`: time [ns] from which the entity has waited; `left`: rest of an interrupted service [ns] (-1: no service
        was interrupted)."""
        heappush(self.heap, (entity.priority if self._by_priority else 0, turn, since, left, entity))

    def take(self) -> tuple[int, int, int, Entity]:
        """Remove the first entity; return sort key, start of waiting [ns], remaining service [ns] and entity."""
        return heappop(self.heap)[1:]


def turn_of(discipline: str, count: int) -> int:
    """Return the sort key of the `count`-th arrival in the order of service; smaller keys are served first."""
    return -count if discipline == "last in, first out" else count


def capacity_of(name: str, given: int | None) -> int | None:
    if given is not None and (not isinstance(given, int) or given < 0):
        raise ModelError(f"{name}: capacity {given!r}; give a whole number >= 0, or None for no bound")
    return given


def shares_of(name: str, weights: tuple[float, ...]) -> list[float]:
    """Return the cumulative probabilities of choices with these weights, except the last, which is always 1."""
    if not weights or not all(isfinite(x) and x >= 0 for x in weights) or not sum(weights):
        raise ModelError(f"{name}: weights {weights}; give numbers >= 0, one of them above zero")
    return [x / sum(weights) for x in accumulate(weights)][:-1]
