"""Nodes of one thread in lockstep: events pass from node to node as they are, without grants, messages or bytes.

  1. tag = the earliest next time of any node, or of an event from outside
  2. what the nodes that are due say at this tag goes to its receivers
  3. each node that is due or has an input advances, up to the earliest time at which another may say something
  4. events before the next tag leave through `on_event`, in total order
The run is that of the time protocol, event by event: both execute the same transitions at the same tags.
"""

from collections.abc import Callable, Iterable, Mapping, Sequence
from heapq import heappop, heappush

from heavylift.coordinator.protocol.distance import Coupling
from heavylift.coordinator.protocol.invariants import CycleWatch
from heavylift.coordinator.protocol.messages import RunEnd
from heavylift.coordinator.protocol.node import failure
from heavylift.kernel.errors import HeavyliftError, ModelError, ProtocolError
from heavylift.nodes.devs import FOREVER, Event, Steppable, Tag, succ
from heavylift.nodes.devs.execution.rules import LIMIT


class Lockstep:
    """Nodes of a run that advance together in this thread; no coordinator checks the events that they exchange.

    `safe`: the earliest logical time at which an event from outside can still be injected.
    """

    def __init__(
        self,
        nodes: Mapping[str, Steppable],
        couplings: Iterable[tuple[str, str, str, str]],
        end: Tag = FOREVER,
        finish: tuple[str, str] | None = None,
        on_event: Callable[[Event], None] = lambda event: None,
        outside: Iterable[tuple[str, str, str, str]] = (),
        microsteps: int = LIMIT,
        models: Mapping[str, Sequence[str]] | None = None,
    ) -> None:
        """Start the nodes, in this order; the last one works furthest ahead. The other arguments are those of the
        `Coordinator`; an event on the port `finish` must leave its node. Raises HeavyliftError."""
        self._nodes, self._finish, self._on_event = {**nodes}, finish, on_event
        self._home = {model: name for name in nodes for model in (models or {}).get(name, (name,))}
        wires = [Coupling(*coupling) for coupling in couplings]
        self._receivers: dict[tuple[str, str], list[str]] = {}
        for source, port, target, _ in (*wires, *outside):
            known, name = self._receivers.setdefault((source, port), []), self._home[target]
            if name != self._home.get(source) and name not in known:
                known.append(name)
        self._cycles = CycleWatch(wires, microsteps)
        self._held: list[Event] = []  # heap of events that have not left yet
        self._injected: list[Event] = []  # heap of events from outside that nobody has reached
        self._bags: dict[str, list[Event]] = {name: [] for name in nodes}
        self._finished = False
        self.end, self.safe = end, Tag(0)
        for name, node in self._nodes.items():
            try:
                node.start()
            except Exception as error:
                raise self._failed(name, Tag(0), error) from _cause(error)

    @property
    def first(self) -> Tag:
        """The earliest pending logical time of all nodes and of events from outside; FOREVER if nothing is pending."""
        tags = [self._next(name) for name in self._nodes]
        return min(*tags, self._injected[0].tag) if self._injected else min(tags)

    @property
    def over(self) -> RunEnd | None:
        """The reason why the run has ended, the same as `Coordinator.over`; None while it goes on."""
        if (first := self.first) < self.end:
            return None
        return RunEnd.FINISHED if self._finished else RunEnd.QUIET if first == FOREVER else RunEnd.BOUND

    def extend(self, end: Tag) -> None:
        """Move the time bound of the run to a later time, unless a model has already ended it."""
        if not self._finished:
            self.end = max(self.end, end)

    def scheduled(self, names: Iterable[str]) -> Tag:
        """Return the earliest pending logical time of the nodes that contain these models; FOREVER if they only react
        to inputs."""
        homes = {self._home[name]: None for name in names}
        given = [event.tag for event in self._injected for name in self._to(event) if name in homes]
        return min(*map(self._next, homes), FOREVER, *given)

    def inject(self, event: Event) -> None:
        """Inject an event from outside at or after `safe`; raises ProtocolError if it is earlier or has no
        receivers."""
        if not self._to(event) or event.source in self._home:
            raise ProtocolError(f"no node receives outside events on {event.source}.{event.port}; couple this port")
        if event.tag < self.safe:
            raise ProtocolError(
                f"{event.source}.{event.port} at {event.tag}: everything up to {self.safe} "
                "has already been computed; choose a later time"
            )
        heappush(self._injected, event)

    def advance(self, horizon: Tag = FOREVER) -> RunEnd | None:
        """Process all events before the end and before `horizon`; return why the run is over, or None. Raises
        HeavyliftError."""
        while (tag := self.first) < min(self.end, horizon):
            self._leave(tag)
            self._speak(tag)
            self._cycles.check()  # before time advances: a cycle without delay would go on for ever
            self._move(tag, min(self.end, horizon))
        self._leave(min(tag, self.end))
        return self.over

    def _speak(self, tag: Tag) -> None:
        """Put what is said at this tag into the bags of its receivers."""
        self._due = [name for name in self._nodes if self._next(name) == tag]
        for name in self._due:
            try:
                outputs = self._nodes[name].outputs()
            except Exception as error:
                raise self._failed(name, tag, error) from _cause(error)
            for event in outputs:
                self._pass(event)
        while self._injected and self._injected[0].tag == tag:
            self._pass(heappop(self._injected))

    def _pass(self, event: Event) -> None:
        if (event.source, event.port) == self._finish:
            # events at the finish time itself are still part of the run
            self.end, self._finished = min(self.end, Tag(event.t + 1)), True
        self._cycles.note(event)
        heappush(self._held, event)
        for name in self._to(event):
            self._bags[name].append(event)

    def _move(self, tag: Tag, limit: Tag) -> None:
        """Advance the nodes that are due at this tag or have an input."""
        waiting = [name for name in self._nodes if name in self._due or self._bags[name]]
        while waiting:
            name = waiting.pop(0)
            node, bag, self._bags[name] = self._nodes[name], sorted(self._bags[name]), []
            try:
                # who is still to advance at this tag may say something at the next microstep
                others = [succ(tag) if x in waiting else self._nodes[x].quiet for x in self._nodes if x != name]
                until = min([limit, *others, *(event.tag for event in self._injected[:1])])
                node.advance(tag, bag, until)
                among = node.among()
                self.safe = max(self.safe, min(until, node.next_time))
            except Exception as error:
                raise self._failed(name, tag, error) from _cause(error)
            for event in among:
                self._cycles.note(event)
                heappush(self._held, event)

    def _leave(self, before: Tag) -> None:
        """Release the events before a logical time."""
        while self._held and self._held[0].tag < before:
            self._on_event(heappop(self._held))

    def _next(self, name: str) -> Tag:
        try:
            return self._nodes[name].next_time
        except Exception as error:
            raise self._failed(name, self.safe, error) from _cause(error)

    def _to(self, event: Event) -> list[str]:
        return self._receivers.get((event.source, event.port), [])

    def _failed(self, name: str, tag: Tag, error: Exception) -> ModelError:
        """Return the error to raise for that of a node: its sentence, or the cycle of nodes in which time does not
        advance; what was said before is released."""
        spoken = self._nodes[name].among() if tag > Tag(0) else []
        for event in spoken:
            heappush(self._held, event)
        last = max([tag, *(event.tag for event in spoken)])
        self._leave(succ(last))
        own = sorted(model for model, home in self._home.items() if home == name)
        cycles = (self._cycles.sentence(model, last) for model in own)
        return ModelError(next(filter(None, cycles), failure(name, error, last).sentence))


def _cause(error: Exception) -> BaseException | None:
    return error.__cause__ if isinstance(error, HeavyliftError) else error
