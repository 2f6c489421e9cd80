"""What moves through a network, and the order in which it waits."""

from heapq import heappop, heappush
from typing import Literal, get_args

from heavylift.kernel.errors import ModelError
from heavylift.nodes.devs import Message

Discipline = Literal["first in, first out", "last in, first out", "priority"]


class Entity(Message):
    """A customer, job or part: its number, kind, priority (lowest first), and when it came into being [ns]."""

    number: int
    kind: str = ""
    priority: int = 0
    born: int = 0


class Demand(Message):
    """A server is ready for so many entities."""

    count: int = 1


class Waiting:
    """Entities in the order in which they are taken: by discipline, equal ones in the order of arrival."""

    def __init__(self, discipline: str = "first in, first out") -> None:
        if discipline not in get_args(Discipline):
            raise ModelError(f"there is no discipline '{discipline}'; choose one of {', '.join(get_args(Discipline))}")
        self.discipline = discipline
        self._heap = list[tuple[int, int, int, int, Entity]]()
        self._count = 0

    def __len__(self) -> int:
        return len(self._heap)

    def put(self, entity: Entity, since: int, left: int = -1) -> None:
        """Add an entity that waits since a time [ns]; `left` [ns] of a service that was interrupted, else -1."""
        self._count += 1
        self._add(self._count if self.discipline != "last in, first out" else -self._count, entity, since, left)

    def put_back(self, turn: int, entity: Entity, since: int, left: int) -> None:
        """Return an entity to its earlier turn."""
        self._add(turn, entity, since, left)

    def _add(self, turn: int, entity: Entity, since: int, left: int) -> None:
        heappush(self._heap, (entity.priority if self.discipline == "priority" else 0, turn, since, left, entity))

    def take(self) -> tuple[int, int, int, Entity]:
        """Remove the first: its turn, since when it waits [ns], what is left of its service [ns] or -1, the entity."""
        return heappop(self._heap)[1:]

    @property
    def first(self) -> Entity:
        """The entity that is taken next."""
        return self._heap[0][4]


def capacity_of(name: str, given: int | None) -> int | None:
    if given is not None and (not isinstance(given, int) or given < 0):
        raise ModelError(f"{name}: capacity {given!r}; give a whole number >= 0, or None for no bound")
    return given
