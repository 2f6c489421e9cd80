"""What the coordinator knows of one node: what it has said of its future, and what waits for it."""

from __future__ import annotations

from bisect import bisect_left, insort
from collections.abc import Sequence
from operator import attrgetter

from heavylift.nodes.devs import FOREVER, Event, Tag

from .messages import Delay

NAMED = 4  # models of a node that are named in a sentence


def together(models: Sequence[str]) -> str:
    """The models of a node in a sentence."""
    more = f" and {len(models) - NAMED + 1} others" if len(models) > NAMED else ""
    return ", ".join(models[: NAMED - 1] if more else models) + more


class NodeState:
    """A node as the coordinator sees it; the words are those of PROTOCOL.md."""

    def __init__(self, name: str, rank: int, models: Sequence[str]) -> None:
        self.name, self.rank, self.models = name, rank, frozenset(models)
        self.who = together(models)
        self.lookahead = dict[str, int]()  # [ns] of each out port, "model.port"
        self.least = 0  # [ns] of those that other nodes hear
        self.inner = frozenset[str]()  # those that no other node hears
        self.next = self.quiet = self.hears = self.first = FOREVER
        self.offer: list[Event] = []
        self.committed = self.running = self.greeted = False
        self.ahead = 0  # of what it has said: events that have not left, and inputs that others have not done
        self.until = Tag(0)  # all before it is decided: its window while it runs, else what it has reached
        self.gseq = 0
        self.ways: list[tuple[int, int, int]] = []  # what can reach it, see `distance.ways`
        self.echo: Delay | None = None  # D[i][i]
        self.holds: dict[int, NodeState] = {}  # whom it has held back, by rank
        self._held: list[tuple[int, str]] = []  # after so many DONEs of all, who began to hold it back
        self._pending: list[Event] = []  # sorted; what was granted stays until it is done
        self._fresh: list[Event] = []  # those among them that the node has not been sent

    @property
    def untold(self) -> bool:
        """Whether what comes first is an offer that is not committed."""
        return bool(self.offer) and not self.committed and self.next <= self.hears

    def put(self, event: Event) -> bool:
        """An input waits for it, in total order; whether that is the first thing that it hears."""
        insort(self._pending, event)
        insort(self._fresh, event)
        if self._pending[0] is not event:
            return False
        self.hears = event.tag
        return True

    def send(self, until: Tag) -> list[Event]:
        """The inputs before `until` that it has not been sent; from now on it keeps them itself."""
        return _before(self._fresh, until)

    def drop(self, reached: Tag) -> list[Event]:
        """It has done what lay before `reached`: these inputs."""
        done = _before(self._pending, reached)
        if done:
            self.hears = self._pending[0].tag if self._pending else FOREVER
        return done

    def hold_back(self, other: NodeState, dones: int) -> None:
        """The other one cannot move before this one does; it is looked at again then."""
        self.holds[other.rank] = other
        if not other._held or other._held[-1][1] != self.name:
            other._held.append((dones, self.name))

    def told(self) -> list[tuple[int, str]]:
        """Who has held it back since this was asked last, each after how many DONEs of all."""
        held, self._held = self._held, []
        return held


def _before(inputs: list[Event], tag: Tag) -> list[Event]:
    """Take the inputs before this tag out of a sorted list."""
    if not inputs:
        return []
    n = bisect_left(inputs, tag, key=attrgetter("tag"))
    found = inputs[:n]
    del inputs[:n]
    return found
