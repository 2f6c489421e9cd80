"""What a simulator did: a trace that is whole and yet costs little, and a log that is reported at once.

A run is determined by who was due at each tag and what was said: these few lists are kept, and the transitions (kinds,
bags, what each model said) are made from them by the routes when somebody reads.  To keep a line for every transition
would cost as much as the transitions do, most of it in the garbage collector.
"""

from collections.abc import Callable, Iterator, Sequence
from typing import Any, NamedTuple

from heavylift.nodes.devs.events import Instant, Tag
from heavylift.nodes.devs.messages import Message
from heavylift.nodes.devs.models import Atomic
from heavylift.nodes.devs.ports import OutPort, Owner, Port


class Transition(NamedTuple):
    """A transition of an atomic at a tag, with received and sent messages as (port, message)."""

    tag: Tag
    path: str
    kind: str  # "internal", "external" or "confluent"
    bag: tuple[tuple[str, Message], ...]
    sent: tuple[tuple[str, Message], ...]


class Trace:
    """Stores all transitions of `Simulator(model, trace=Trace())`; iterate over it in order."""

    def __init__(self) -> None:
        self._lines: list[Transition] = []
        self._atomics: list[Atomic] = []
        # of all tags not settled yet, end to end; lists of lists would keep the garbage collector busy
        self._sizes: list[int] = []  # t, k, number of those due, number of messages
        self._due: list[int] = []
        self._sources: list[Port[Message]] = []
        self._values: list[Message] = []

    def note(
        self,
        tag: Instant,
        atomics: list[Atomic],
        imminent: list[int],
        sources: Sequence[Port[Message]],
        values: Sequence[Message],
    ) -> None:
        """Record a tag: imminent atomics and delivered messages."""
        self._atomics = atomics
        self._sizes += (*tag, len(imminent), len(values))
        self._due += imminent
        self._sources += sources
        self._values += values

    def settle(self) -> None:
        """Build the transitions; called before routes change."""
        sizes, due, text = iter(self._sizes), 0, 0
        for t, k, n_due, n_said in zip(sizes, sizes, sizes, sizes, strict=True):
            imminent, now = self._due[due : due + n_due], slice(text, text + n_said)
            self._lines += _transitions((t, k), self._atomics, imminent, self._sources[now], self._values[now])
            due, text = due + n_due, text + n_said
        self._sizes, self._due, self._sources, self._values = [], [], [], []

    def __iter__(self) -> Iterator[Transition]:
        self.settle()
        return iter(self._lines)

    def __len__(self) -> int:
        self.settle()
        return len(self._lines)


class TransitionLog(Trace):
    """Passes on each transition at the end of its tag."""

    def __init__(self, tell: Callable[[Transition], None]) -> None:
        super().__init__()
        self._tell = tell

    def note(self, *instant: Any) -> None:
        """Record a tag and pass it on."""
        for line in _transitions(*instant):
            self._tell(line)


def _transitions(
    tag: Instant,
    atomics: list[Atomic],
    imminent: list[int],
    sources: Sequence[Port[Message]],
    values: Sequence[Message],
) -> list[Transition]:
    """The transitions of one tag in path order."""
    text: dict[Owner, list[tuple[str, Message]]] = {}
    heard: dict[int, list[tuple[int, str, Message]]] = {}
    for source, value in zip(sources, values, strict=True):
        if isinstance(source, OutPort):
            text.setdefault(source.owner, []).append((source.name, value))
        for m, port, place in source.routes:
            heard.setdefault(m._index, []).append((place, port.name, value))
    due = set(imminent)
    lines = []
    for i in sorted(due | heard.keys()):
        bag = sorted(heard.get(i, ()), key=lambda entry: entry[0])
        kind = "external" if i not in due else "confluent" if bag else "internal"
        m = atomics[i]
        message = tuple((port, value) for _, port, value in bag)
        lines.append(Transition(Tag(*tag), m.path, kind, message, tuple(text.get(m, ()))))
    return lines
