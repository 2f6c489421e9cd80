"""The coordinator: conservative Parallel DEVS in one round trip per decision. No input or output, no clock.

State per node j: next_j, offer_j = lambda(next_j), quiet_j, lookahead L_j, and the pending inputs.
  o_j  earliest output of j that is not held yet: min(q_j, after(first pending input, L_j)), with
       q_j = succ(next_j) once the offer is committed, else quiet_j; frozen at grant time while j runs
  B_i  = min over j != i of o_j + D[j][i], the window of i; D from `distance`
  COMMIT, to a fixpoint, before granting: an idle i with next_i <= B_i and next_i <= its first pending tag
       puts its offer into the receivers' bags at next_i
  GRANT idle i when e_i = min(next_i, first pending) < B_i and, if e_i = next_i, its offer is empty or
       committed
Nothing is in flight when a decision is made. Committed and spoken events leave through `on_event` in total
order (t, k, source, port, index) as soon as no earlier one can come: when their tag is below all o_j.

After Chandy and Misra's bounds, with lambda computed ahead so that confluent transitions are exact. Not
bounds: next_j + L_j (a scheduled output has no lookahead), and sending an imminent output to the next
microstep.
"""

from bisect import bisect_left, insort
from collections.abc import Callable, Iterable
from enum import Enum
from heapq import heappop, heappush

from heavylift.kernel.errors import ProtocolError
from heavylift.nodes.devs import FOREVER, Delivery, Event, Tag, after, succ
from heavylift.nodes.devs.events import Order

from .distance import Coupling, distances
from .messages import Delay, Done, Grant, Hello


class Outcome(Enum):
    """Why nothing is left to do."""

    FINISHED = "the finish port has spoken, and its time is completed"
    BOUND = "the time bound is reached"
    QUIET = "all nodes are passive and nothing is pending"


class _Node:
    """What the coordinator knows of a node."""

    def __init__(self, name: str, rank: int) -> None:
        self.name, self.rank, self.lookahead = name, rank, 0
        self.next = self.quiet = FOREVER
        self.offer: list[Event] = []
        self.committed = False
        self.pending: list[Delivery] = []  # sorted
        self.first = FOREVER  # tag of the first pending input
        self.ways: list[tuple[int, Delay]] = []  # ranks of the nodes that can reach it, with their D
        self.echo: Delay | None = None  # D[i][i]
        self.frozen: Tag | None = None  # o_j while it runs, else None
        self.until = Tag(0)  # what lies before it is decided: its window while it runs, then what it has reached
        self.gseq = 0
        self.greeted = False

    def change(self) -> None:
        """Take note of a change of `pending`."""
        self.first = self.pending[0].event.tag if self.pending else FOREVER

    @property
    def earliest(self) -> Tag:
        """o_j of the header."""
        if self.frozen is not None:
            return self.frozen
        own = succ(self.next) if self.committed else self.quiet
        return min(own, after(self.first, self.lookahead)) if self.pending else own


class Coordinator:
    """Say `hello` for each node and `done` for each DONE; send what `ready` returns until it is `over`."""

    def __init__(
        self,
        nodes: Iterable[str],
        couplings: Iterable[tuple[str, str, str, str]],
        end: Tag = FOREVER,
        finish: tuple[str, str] | None = None,
        on_event: Callable[[Event], None] = lambda event: None,
    ) -> None:
        """Run to events below `end`; an event on the port `finish` = (node, port) ends it with its time."""
        self._nodes = {name: _Node(name, i) for i, name in enumerate(sorted(nodes))}
        self._couplings = [Coupling(*coupling) for coupling in couplings]
        self._receivers: dict[tuple[str, str], list[tuple[_Node, str]]] = {}
        self._finish, self._finished = finish, False
        self.end, self._limit, self._on_event = end, end, on_event
        self.floor = Tag(0)  # nothing below it comes any more
        self._held: list[tuple[Order, Event]] = []  # heap of events that have not left yet
        self._open = False  # whether all have said HELLO

    def hello(self, name: str, hello: Hello) -> None:
        """A node has started; the last of them opens the run."""
        node = self._node(name)
        if node.greeted:
            raise ProtocolError(f"{name} said HELLO twice: two nodes of one name, or an old one came back")
        node.greeted, node.lookahead = True, hello.lookahead
        self._take(node, hello)
        nodes = self._nodes
        if all(other.greeted for other in nodes.values()):
            ahead = {other.name: other.lookahead for other in nodes.values()}
            finish = self._finish[0] if self._finish else None
            D = distances(list(nodes), self._couplings, ahead, finish)
            for i, other in enumerate(nodes.values()):
                other.ways = [(j, d) for j, row in enumerate(D) if j != i and (d := row[i]) is not None]
                other.echo = D[i][i]
            for source, port, target, into in self._couplings:
                self._receivers.setdefault((source, port), []).append((nodes[target], into))
            self._open = True

    def done(self, name: str, done: Done) -> None:
        """A node has done what it was granted."""
        node = self._node(name)
        if node.frozen is None or done.gseq != node.gseq:
            raise ProtocolError(f"{name} sent DONE {done.gseq} out of order, its last GRANT is {node.gseq}")
        for event in done.spoken:
            if event.source != name:
                raise ProtocolError(f"{name} spoke for {event.source}: a node says only its own events")
            if event.tag < node.frozen:
                raise ProtocolError(
                    f"{name} spoke on port {event.port} at {event.tag}, earlier than the {node.frozen} "
                    f"that it had declared: the lookahead of that port is too long"
                )
        del node.pending[: _before(node.pending, done.reached)]
        node.change()
        node.frozen, node.committed, node.until = None, False, done.reached
        self._take(node, done)
        for event in done.spoken:
            self._hold(event)

    def ready(self, horizon: Tag = FOREVER) -> list[tuple[str, Grant]]:
        """Commit what can be committed, let events leave, and grant every node that can move, all below `horizon`."""
        if not self._open:
            return []
        self._limit = min(self.end, horizon)
        bound = self._commit()
        self.floor = floor = min(min(bound), self._limit)
        while self._held and self._held[0][1].tag < floor:
            self._on_event(heappop(self._held)[1])
        grants = []
        for node in self._nodes.values():
            if node.frozen is None and (node.first < node.next or not node.offer or node.committed):
                tag = min(node.next, node.first)
                if tag < self._limit and tag < (window := self._window(node, bound)):
                    grants.append((node.name, self._grant(node, window, bound[node.rank])))
        if not grants and not self.waiting and self.first < self._limit:
            next_ = ", ".join(f"{node.name} {min(node.next, node.first)}" for node in self._nodes.values())
            raise ProtocolError(f"no node can move before the end, {self.end}, though they wait for {next_}")
        return grants

    @property
    def over(self) -> Outcome | None:
        """Why the run has ended, once `ready` has nothing to grant and nobody runs; else None."""
        nodes = self._nodes.values()
        if not self._open or any(node.frozen is not None for node in nodes):
            return None
        first = min(min(node.next, node.first) for node in nodes)
        if self._finished and first >= self.end:
            return Outcome.FINISHED
        if first == FOREVER:
            return Outcome.QUIET
        return Outcome.BOUND if first >= self.end else None

    @property
    def first(self) -> Tag:
        """The earliest thing that a node which does not run has before it; FOREVER if there is none."""
        idle = (node for node in self._nodes.values() if node.frozen is None)
        return min((min(node.next, node.first) for node in idle), default=FOREVER)

    def extend(self, end: Tag) -> None:
        """Move a time bound that was not reached yet, or only now, to a later one; an end that was said stays."""
        if not self._finished:
            self.end = max(self.end, end)

    def scheduled(self, names: Iterable[str]) -> Tag:
        """The earliest thing that these nodes have before them; FOREVER if they only react."""
        return min(min(self._nodes[name].next, self._nodes[name].first) for name in names)

    @property
    def waiting(self) -> dict[str, int]:
        """Nodes that have an outstanding GRANT, with its gseq."""
        return {node.name: node.gseq for node in self._nodes.values() if node.frozen is not None}

    def _node(self, name: str) -> _Node:
        if name not in self._nodes:
            raise ProtocolError(f"{name} is not a node of this run: they are {', '.join(self._nodes)}")
        return self._nodes[name]

    def _take(self, node: _Node, said: Hello | Done) -> None:
        """What a node says of its future; an empty offer is silent at next_j whatever `quiet` says."""
        for event in said.offer:
            if event.source != node.name or event.tag != said.next:
                raise ProtocolError(
                    f"{node.name} offers {event.source}.{event.port} at {event.tag}: an offer holds its own "
                    f"events at its next tag, {said.next}"
                )
        node.next, node.offer = said.next, said.offer
        node.quiet = said.quiet if said.offer else max(said.quiet, succ(said.next))

    def _commit(self) -> list[Tag]:
        """Commit to the fixpoint; returns o_j of all nodes."""
        bound = [node.earliest for node in self._nodes.values()]
        changed = True
        while changed:
            changed = False
            for node in self._nodes.values():
                free = node.offer and not node.committed and node.frozen is None and node.next < self._limit
                if free and node.next <= node.first and node.next <= self._window(node, bound):
                    node.committed = changed = True
                    bound[node.rank] = node.earliest
                    for receiver in [r for event in node.offer for r in self._hold(event)]:
                        bound[receiver.rank] = receiver.earliest
        return bound

    def _window(self, node: _Node, bound: list[Tag]) -> Tag:
        """B_i of the header, below end and horizon; `plus` is written out, for nothing runs more often."""
        t, k = self._limit
        for rank, (wait, steps) in node.ways:
            earliest = bound[rank]
            reach = earliest.t + wait
            if reach <= t:
                step = steps if wait else earliest.k + steps
                if reach < t or step < k:
                    t, k = reach, step
        return Tag(t, k)

    def _hold(self, event: Event) -> list[_Node]:
        """Put an event into its receivers' bags and among those that wait to leave."""
        if (event.source, event.port) == self._finish:
            self.end, self._finished = min(self.end, Tag(event.t + 1)), True
            self._limit = min(self._limit, self.end)
        heappush(self._held, (event.order, event))
        receivers = self._receivers.get((event.source, event.port), [])
        for node, into in receivers:
            insort(node.pending, Delivery(event, into), key=_place)
            node.change()
        return [node for node, _ in receivers]

    def _grant(self, node: _Node, window: Tag, earliest: Tag) -> Grant:
        inputs = node.pending[: _before(node.pending, window)]
        node.frozen, node.until, node.gseq = earliest, window, node.gseq + 1
        return Grant(node.gseq, window, node.echo, node.committed, inputs)


def _place(delivery: Delivery) -> tuple[Order, str]:
    return delivery.event.order, delivery.port


def _before(pending: list[Delivery], tag: Tag) -> int:
    """How many of them lie before `tag`."""
    return bisect_left(pending, tag, key=lambda delivery: delivery.event.tag)
