"""Names the way on which messages went around between nodes while time stood still.

A simulator sees a zero-time loop among its own atomics only; between nodes the coordinator sees the messages. From the
second half of the microsteps that are allowed on it keeps them. Back from the last one, each node has spoken because
of the last message that reached it before; the first node that is met twice closes the cycle.
"""

from collections import deque
from collections.abc import Iterable

from heavylift.kernel.errors import ModelError
from heavylift.nodes.devs import Event, Tag
from heavylift.nodes.devs.execution.rules import LONGER

from .distance import Coupling


class CycleWatch:
    """`note` every event, `check` before time goes on."""

    def __init__(self, couplings: Iterable[Coupling], microsteps: int) -> None:
        """A message at the microstep `microsteps` [> 0] is one too many."""
        self.microsteps = microsteps
        self._late: deque[Event] = deque(maxlen=4 * microsteps)
        self._reached: list[Event] = []
        self._into: dict[str, list[Coupling]] = {}
        for coupling in couplings:
            self._into.setdefault(coupling.target, []).append(coupling)

    def note(self, event: Event) -> None:
        """An event was committed or spoken."""
        if 2 * event.k >= self.microsteps:
            self._late.append(event)
            if event.k >= self.microsteps:
                self._reached.append(event)

    def check(self) -> None:
        """Raise ModelError if time stands still."""
        if self._reached:
            last = min(self._reached, key=lambda event: event.order)
            raise ModelError(
                self.sentence(last.source, last.tag)
                or f"{last.source} at {last.tag}: port {last.port} has spoken at {self.microsteps} microsteps in which "
                f"no time passes; let it hold for more than 0 ns{LONGER}"
            )

    def sentence(self, node: str, tag: Tag) -> str:
        """Where time stood still when `node` came to `tag`; "" if that was not on a way between nodes."""
        way = self._back(node, tag) if tag.k >= self.microsteps else []
        if not way:
            return ""
        first = way.index(min(way))
        way = way[first:] + way[:first]
        return (
            f"{', '.join(dict.fromkeys(hop.source for hop in way))} at {tag}: zero-time loop between nodes, "
            f"{self.microsteps} microsteps in which no time passes: "
            f"{', '.join(f'{hop.source}.{hop.port} -> {hop.target}.{hop.into}' for hop in way)}; "
            f"let one of them hold for more than 0 ns{LONGER}"
        )

    def _back(self, node: str, tag: Tag) -> list[Coupling]:
        """The cycle that led to `node` at `tag`, in the order in which messages went."""
        way: list[Coupling] = []
        met: list[str] = []
        while node not in met:
            met.append(node)
            heard = [
                (event.order, hop)
                for event in self._late
                for hop in self._into.get(node, ())
                if (event.source, event.port) == (hop.source, hop.port) and event.t == tag.t and event.k < tag.k
            ]
            if not heard:
                return []
            (*at, _, _, _), hop = max(heard)
            node, tag = hop.source, Tag(*at)
            way.append(hop)
        return way[met.index(node) :][::-1]
