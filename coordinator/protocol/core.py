"""The coordinator: conservative Parallel DEVS, one round trip per decision, no null messages, no I/O, no clock.

A node is a model, or several that share a process and are known by the name of the first. PROTOCOL.md defines the
terms and proves correctness; the numbers are those of its steps.
  (1) HELLO   each node reports next, offer = lambda(next), quiet, and the lookahead of each out port
  (2) WINDOW  B_i = min over j != i of says_j + D[j][i] and hears_j + R[j][i]; D and R from `distance`
              says_j = succ(next_j) once its offer is committed, else quiet_j; hears_j = tag of its first input
  (3) COMMIT  to a fixpoint: the offer of an idle i with next_i <= B_i and next_i <= hears_i goes into the
              receivers' bags at next_i
  (4) GRANT   to an idle i with first_i = min(next_i, hears_i) < B_i and, if first_i = next_i, an offer that is
              empty or committed: it may do everything before B_i; a node that is AHEAD of others waits for them
  (5) DONE    events sent by the node go into the receivers' bags; then as in (1)
  (6) FLOOR   events below all o_j = min(says_j, hears_j + L_j) are released through `on_event`, in total order; events
              that no other node receives, when they are below first_j of their node
  (7) END     no node runs, and nothing is left before the end
No B_i ever falls: a blocked node need not be re-evaluated before the node that blocks it has moved.
"""

from collections.abc import Callable, Iterable, Mapping, Sequence
from heapq import heappop, heappush

from heavylift.kernel.errors import ModelError, ProtocolError
from heavylift.nodes.devs import FOREVER, NEVER, Event, Tag, after, succ
from heavylift.nodes.devs.execution.rules import LIMIT

from .distance import Coupling, NodeState, checked, distances, paths_to
from .invariants import CycleWatch, check_done, check_hello
from .messages import Fail, Grant, GrantDone, Hello, RunEnd

AHEAD = 256  # of what a node has said: what may be held while it goes on


class Coordinator:
    """Conservative time coordination without any transport: decides which nodes may advance to which logical time.

    Call `hello` for each node's HELLO and `done` for each DONE, and send the grants that `ready` returns, until `over`
    is set.
    """

    def __init__(
        self,
        nodes: Iterable[str],
        couplings: Iterable[tuple[str, str, str, str]],
        end: Tag = FOREVER,
        finish: tuple[str, str] | None = None,
        on_event: Callable[[Event], None] = lambda event: None,
        outside: Iterable[tuple[str, str, str, str]] = (),
        microsteps: int = LIMIT,
        models: Mapping[str, Sequence[str]] | None = None,
    ) -> None:
        """Create the coordinator. `models`: the models of each node; without them each node is one model. Couplings are
        between models; `outside`: couplings (source, port, model, its port) from sources that are not nodes.

        The run covers events before `end`; an event on the port `finish` = (model, port) ends it at its time.
        """
        own = models or {name: (name,) for name in nodes}
        self._nodes = {name: NodeState(name, i, own[name]) for i, name in enumerate(sorted(own))}
        self._by_rank = list(self._nodes.values())
        self._home = {model: self._nodes[name] for name in own for model in own[name]}
        self._couplings = [Coupling(*coupling) for coupling in couplings]
        self._receivers: dict[tuple[str, str], list[NodeState]] = {}
        self._finish, self._finished = finish, False
        self.end, self._limit, self._on_event = end, end, on_event
        self.last = Tag(0)  # of all transitions that are done
        self.floor = Tag(0)  # nothing below it comes any more
        self._n = len(self._nodes)
        self._tags = [FOREVER] * (3 * self._n)  # says of all nodes, then their hears, then their o
        self._floors = [FOREVER] * self._n  # of all nodes: what comes from there is not earlier
        self._held: list[Event] = []  # heap of events that have not left yet
        self._look: dict[int, NodeState] = {}  # whose rights may have changed
        self._ahead: dict[int, NodeState] = {}  # who could move, and waits until others have done what it has said
        self._dones = self.running = 0  # all so far; nodes that have an outstanding GRANT
        self._cycles = CycleWatch(self._couplings, microsteps)
        self._open = False  # whether all have said HELLO
        self._injected = set[str]()  # models that hear of somebody who is no node
        for source, port, target, into in outside:
            if target not in self._home:
                raise ProtocolError(f"coupling {source}.{port} -> {target}.{into}: there is no node {target}")
            self._injected.add(target)
            self._receives(source, port, self._home[target])

    def hello(self, name: str, hello: Hello) -> None:
        """Register a started node (step 1 of the protocol); the last node to start opens the run."""
        node = self._node(name)
        if node.greeted:
            raise ProtocolError(
                f"{node.who} sent HELLO twice: two nodes have this name, or an earlier process has reconnected"
            )
        # the lookahead of every port is needed before the first window can be computed
        node.greeted, node.lookahead = True, hello.lookahead
        check_hello(node, hello)
        self._take(node, hello)
        if all(other.greeted for other in self._by_rank):
            self._begin()

    def _begin(self) -> None:
        """Compute receivers and lookaheads after all HELLOs."""
        nodes, home = self._by_rank, self._home
        for source, port, target, _ in checked(self._couplings, home):
            self._receives(source, port, home[target])
        outward = {*self._receivers, self._finish}
        ahead = {port: ns for node in nodes for port, ns in node.lookahead.items()}
        for node in nodes:
            own = [(model, port) for model, port in filter(None, outward) if model in node.models]
            node.inner = frozenset(node.lookahead) - {f"{model}.{port}" for model, port in own}
            # an empty list: nothing of this node is heard by others, so that it never holds them back
            node.least = min((ahead.get(f"{model}.{port}", 0) for model, port in own), default=NEVER)
            self._note(node)
        D, R = distances([sorted(node.models) for node in nodes], self._couplings, ahead, self._finish, self._injected)
        for i, node in enumerate(nodes):
            node.ways, node.echo = paths_to(i, D, R, [other.least for other in nodes]), D[i].get(i)
        self._open, self._look = True, dict(enumerate(nodes))

    def _receives(self, source: str, port: str, node: NodeState) -> None:
        """Register that a node receives the events of a model's port."""
        if source not in node.models and node not in (known := self._receivers.setdefault((source, port), [])):
            known.append(node)

    def done(self, name: str, done: GrantDone) -> None:
        """Process the DONE message of a node (step 5 of the protocol)."""
        node = self._node(name)
        check_done(node, done, self._tags[node.rank])
        # what the node has processed no longer counts as ahead of its sender
        for event in node.drop(done.reached):
            self._release(event)
        node.running, node.committed, node.until = False, False, done.reached
        # decisions are numbered by DONEs, for the trace of who waited for whom
        self.running -= 1
        self._dones += 1
        self.last = max(self.last, done.last)
        self._take(node, done)
        for event in done.spoken:
            self._hold(event)
        self._moved(node)

    def working(self, name: str, t_ns: int) -> None:
        """Record that a node has published samples up to `t_ns` [ns] within its grant (step 6 of the protocol)."""
        node = self._node(name)
        if node.running:
            for tags, at in ((self._tags, 2 * self._n + node.rank), (self._floors, node.rank)):
                # samples show how far a node has come within its grant, so that events below can be released early
                tags[at] = max(tags[at], min(Tag(t_ns), node.until))
            self._leave()

    def ready(self, horizon: Tag = FOREVER) -> list[tuple[str, Grant]]:
        """Commit offers, release events, and return the grants of all nodes that can advance; no grant exceeds
        `horizon`."""
        if not self._open:
            return []
        before, self._limit = self._limit, min(self.end, horizon)
        # a longer horizon may free nodes that had reached the old one
        if self._limit > before:
            self._look = dict(enumerate(self._by_rank))
        able: dict[int, NodeState] = {}
        # until nothing changes: a commit may allow another one at the same tag
        while self._look:  # (3)
            rank, node = self._look.popitem()
            if not node.running and node.first < self._limit:
                able[rank] = node
                if node.uncommitted and self._window(node, node.next):
                    self._commit(node)
        # before time advances: a cycle without delay would commit for ever
        self._cycles.check()
        self._leave()
        able, self._ahead = self._ahead | able, {}
        least, grants = None, []
        for rank in sorted(able):  # (4)
            node = able[rank]
            if node.first >= self._limit or node.uncommitted:
                continue
            # a node whose events nobody has consumed yet waits, so that memory stays bounded
            if node.ahead >= AHEAD and node.first > (least := least or min(x.first for x in self._by_rank)):
                self._ahead[rank] = node
                continue
            if window := self._window(node, succ(node.first)):
                grants.append((node.name, self._grant(node, window)))
        # cannot happen if lookaheads are kept (PROTOCOL.md); reported rather than waiting for ever
        if not grants and not self.running and self.first < self._limit:
            next_ = ", ".join(f"{node.who} {node.first}" for node in self._by_rank)
            raise ProtocolError(f"no node can advance to the end, {self.end}, although events are pending: {next_}")
        return grants

    @property
    def over(self) -> RunEnd | None:
        """The reason why the run has ended, once `ready` grants nothing and no node works (step 7 of the protocol);
        otherwise None."""
        if not self._open or self.running or self.first < self.end:
            return None
        if self._finished:
            return RunEnd.FINISHED
        return RunEnd.QUIET if self.first == FOREVER else RunEnd.BOUND

    @property
    def first(self) -> Tag:
        """The earliest pending logical time of all nodes that have no grant; FOREVER if nothing is pending."""
        return min((node.first for node in self._by_rank if not node.running), default=FOREVER)

    def failed(self, name: str, fail: Fail) -> ModelError:
        """Return the error for a node's FAIL: the zero-delay cycle that the node is part of, or else its sentence."""
        node = self._node(name)
        if self._open and node.running:
            # a model may fail after it has sent: what it sent before belongs to the recording
            for event in fail.spoken:
                if event.source in node.models and node.first <= event.tag <= fail.tag:
                    self._hold(event)
            self._floors[node.rank] = max(self._floors[node.rank], succ(fail.tag))
            self._leave()
        cycles = (self._cycles.sentence(model, fail.tag) for model in sorted(node.models))
        return ModelError(next(filter(None, cycles), fail.sentence))

    def scheduled(self, names: Iterable[str]) -> Tag:
        """Return the earliest pending logical time of these models' nodes; FOREVER if none has a scheduled event."""
        return min(self._home[name].first for name in names)

    def held(self, name: str) -> list[tuple[int, str]]:
        """Return the nodes that began to block this node since the last call, as pairs (number of DONE messages so far,
        name)."""
        return self._node(name).blocked_by()

    def _node(self, name: str) -> NodeState:
        if name not in self._nodes:
            raise ProtocolError(f"{name} is not a node of this run; its nodes are {', '.join(self._nodes)}")
        return self._nodes[name]

    def _take(self, node: NodeState, text: Hello | GrantDone) -> None:
        """Update next, offer and quiet of a node from its message; a node with an empty offer sends nothing at next,
        whatever `quiet` says."""
        node.next, node.offer = text.next, text.offer
        node.quiet = text.quiet if text.offer else max(text.quiet, succ(text.next))
        self._note(node)

    def _note(self, node: NodeState) -> None:
        """Update the bounds of dependent nodes after a node changed."""
        rank, n, tags = node.rank, self._n, self._tags
        tags[rank] = o = succ(node.next) if node.committed else node.quiet
        tags[n + rank] = hears = node.hears
        # o: the earliest output, of itself or as reaction to its first input
        tags[2 * n + rank] = o = min(o, after(hears, node.least)) if hears[0] <= o[0] else o
        node.first = first = min(node.next, hears)
        # a node with ports that only its own models hear may still send inner events at its first tag
        self._floors[rank] = first if node.inner else o

    def _window(self, node: NodeState, need: Tag) -> Tag | None:
        """(2) Return the bound B_i of a node, limited by the end; None if it is below `need`: then the node that blocks
        it is recorded."""
        t, k = self._limit
        tags = self._tags
        for source, wait, steps in node.ways:  # `plus` is written out, for nothing runs more often
            tag = tags[source]
            reach = tag[0] + wait
            if reach <= t:
                step = steps if wait else tag[1] + steps
                if reach < t or step < k:
                    t, k = reach, step
                    if (t, k) < need:
                        self._by_rank[source % self._n].hold_back(node, self._dones)
                        return None
        return Tag(t, k)

    def _commit(self, node: NodeState) -> None:
        """(3) Commit the offer of a node, since no input can invalidate it any more."""
        node.committed = True
        self._note(node)
        for event in node.offer:
            self._hold(event)
        self._moved(node)

    def _moved(self, node: NodeState) -> None:
        """Re-evaluate the nodes that waited for this one."""
        self._look[node.rank] = node
        self._look |= node.holds
        node.holds = {}

    def _hold(self, event: Event) -> None:
        """Put an event into its receivers' bags and into the queue of events to be released."""
        at = event.source, event.port
        if at == self._finish:
            # events at the finish time itself are still part of the run
            self.end, self._finished = min(self.end, Tag(event.t + 1)), True
            self._limit = min(self._limit, self.end)
        self._cycles.note(event)
        heappush(self._held, event)
        receivers = self._receivers.get(at, ())
        if (home := self._home.get(event.source)) is not None:
            # one for the queue, one for each receiver that has to process it
            home.ahead += 1 + len(receivers)
        for node in receivers:
            if node.put(event):
                self._note(node)
                self._look[node.rank] = node

    def _leave(self) -> None:
        """(6) Release committed events below the global floor."""
        # never backwards, as released events are recorded
        self.floor = max(self.floor, min(min(self._floors), self._limit))
        held, floor = self._held, self.floor
        while held and (held[0].t, held[0].k) < floor:
            event = heappop(held)
            self._release(event)
            self._on_event(event)

    def _release(self, event: Event) -> None:
        """Record that an event was released to the outside, or processed by one of its receivers."""
        if event.source in self._home:
            self._home[event.source].ahead -= 1

    def _grant(self, node: NodeState, window: Tag) -> Grant:
        node.running, node.until, node.gseq = True, window, node.gseq + 1
        self.running += 1
        return Grant(node.gseq, window, node.echo, node.committed, node.send(window))
