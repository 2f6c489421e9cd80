"""A coordinator that also takes events, and a later end, from outside: an operator's, who takes part in no round.

An event from outside may come at any tag from `safe` on, the latest of
  until_i   of every node: its window while it runs, else what it has reached
  next_i    of every node whose offer is committed and not yet granted
  floor     below which all events have left
and it goes into its receivers' bags there, in the total order. Nothing that was decided can change by it: a node that
ran did so below until_i; the receiver's reaction comes at or after the tag, and so after every window that was granted;
only an input before next_i refutes a committed offer. So the same events, known from the beginning, give the same run.
With `ready(horizon)` nothing is decided at or after the horizon, so that `safe` never lies above it.

`run_in_memory`: coordinator and nodes in one thread, without transport, each message in its wire form, for tests.
"""

from collections.abc import Iterable, Mapping
from random import Random

from heavylift.kernel.errors import ModelError, ProtocolError
from heavylift.nodes.devs import FOREVER, Event, Tag

from .core import Coordinator, RunEnd
from .messages import Done, Fail, Grant, decode, encode
from .node import Node


class OpenCoordinator(Coordinator):
    """A coordinator with couplings `outside`, whose sources are not nodes; `inject` adds their events."""

    def extend(self, end: Tag) -> None:
        """Move the time bound of the run to a later time, unless a model has ended it."""
        if not self._finished:
            self.end = max(self.end, end)

    @property
    def safe(self) -> Tag:
        """The earliest tag at which nothing is decided yet."""
        nodes = self._nodes.values()
        committed = (node.next for node in nodes if node.committed and not node.running)
        return max(self.floor, *(node.until for node in nodes), *committed)

    @property
    def safe_ns(self) -> int:
        """The first whole nanosecond at which nothing is decided yet."""
        safe = self.safe
        return safe.t + (safe.k > 0)

    def inject(self, event: Event) -> None:
        """Inject an event from outside, at `safe` or later; raises ProtocolError if earlier or without receivers."""
        if (event.source, event.port) not in self._receivers or event.source in self._home:
            raise ProtocolError(f"{event.source}.{event.port} is coupled to no node from outside")
        if event.tag < self.safe:
            raise ProtocolError(
                f"{event.source}.{event.port} at {event.tag}: the run is decided up to {self.safe}, choose a later time"
            )
        self._hold(event)


def run_in_memory(coordinator: Coordinator, nodes: Iterable[Node], order: Random | None = None) -> RunEnd:
    """Run to the end; raises ModelError with the sentence of a node that fails."""
    order = order or Random(0)
    by_name = {node.name: node for node in nodes}
    for name in order.sample(sorted(by_name), len(by_name)):
        hello = by_name[name].hello()
        if isinstance(hello, Fail):
            raise ModelError(hello.sentence) from by_name[name].cause
        coordinator.hello(name, hello)
    turns(coordinator, by_name, FOREVER, order)
    assert coordinator.over is not None
    return coordinator.over


def turns(
    coordinator: Coordinator, nodes: Mapping[str, Node], until: Tag, order: Random | None = None, wired: bool = True
) -> int:
    """Let nodes that have sent HELLO execute everything before a tag; returns the number of grants."""
    answers, grants = list[tuple[str, Done]](), 0
    while True:
        for name, grant in coordinator.ready(until):
            answers.append((name, answer(nodes[name], grant, coordinator, wired)))
            grants += 1
        if not answers:
            return grants
        coordinator.done(*answers.pop(order.randrange(len(answers)) if order else -1))


def answer(node: Node, grant: Grant, coordinator: Coordinator, wired: bool = True) -> Done:
    """Grant a node and return its DONE, encoded and decoded if `wired`; raises the error of a FAIL."""
    text = node.handle(decode(encode(grant)) if wired else grant)
    if isinstance(text, Fail):
        raise coordinator.failed(node.name, text) from node.cause
    again = decode(encode(text)) if wired and text is not None else text
    if not isinstance(again, Done):
        raise ProtocolError(f"{node.name} answered GRANT {grant.gseq} with {text!r}")
    return again
