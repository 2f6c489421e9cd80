"""Path lookahead: the least delay from an output or input of one node to an arrival at another.

A delay is (ns, microsteps); a positive lookahead restarts the microsteps, as in `after`, and a lookahead of zero costs
one. From model a straight to model b it is w[a][b], the least lookahead of those out ports of a that are coupled to b.
A node is one model or several; with sums of w over coupling paths between models, which may lead through nodes,
  R[j][i] = least sum from a model of j with inputs from other nodes to one of i: from an input of j to the bag of i
  D[j][i] = the same from an out port of j to other nodes, without its w: from an output of j to the bag of i
and D[i][i] is the shortest cycle through others. Shortest paths after Dijkstra (`chain` is monotone and never
shortens), from each node once; the bound is that of Chandy and Misra, summed over paths.

Also the coordinator's state of one node: what it has promised for its future, and its pending inputs.
"""

from bisect import bisect_left, insort
from collections.abc import Collection, Iterable, Mapping, Sequence
from heapq import heappop, heappush
from operator import attrgetter
from typing import NamedTuple

from heavylift.kernel.errors import ProtocolError
from heavylift.nodes.devs import FOREVER, NEVER, Event, Tag

from .messages import Delay

Matrix = list[dict[int, Delay]]  # [from][to]; no entry = no path
ZERO: Delay = (0, 0)
END: Delay = (1, 0)  # a run ends with the time of its finish event


class Coupling(NamedTuple):
    """A coupling: an event of `source` on `port` enters the bag of port `into` of `target` at the same logical time."""

    source: str
    port: str
    target: str
    into: str


def plus(tag: Tag, delay: Delay | None) -> Tag:
    """Return the logical time `tag` plus a delay; FOREVER if the delay is None, since then there is no path."""
    if delay is None:
        return FOREVER
    wait, steps = delay
    # without delay only microsteps add up
    if wait == 0:
        return Tag(tag.t, tag.k + steps) if tag.t < NEVER else FOREVER
    # any positive delay restarts the microsteps, as time advance does in superdense time
    return Tag(tag.t + wait, steps) if wait < NEVER - tag.t else FOREVER


def chain(first: Delay, second: Delay) -> Delay:
    """Return the sum of two delays, each in ns and microsteps."""
    return (first[0], first[1] + second[1]) if second[0] == 0 else (first[0] + second[0], second[1])


def reaction(lookahead: int) -> Delay:
    """Return the delay from an input of a node to an output on a port that has this lookahead [ns]."""
    return (lookahead, 0) if lookahead > 0 else (0, 1)


def distances(
    nodes: Sequence[Collection[str]],
    couplings: Iterable[Coupling],
    lookaheads: Mapping[str, int],
    finish: tuple[str, str] | None = None,
    heard: Iterable[str] = (),
) -> tuple[Matrix, Matrix]:
    """Return the matrices of least delays between nodes, from an output (D) or an input (R) of a node to an arrival at
    another.

    `nodes`: their models; `lookaheads` by "model.port"; `heard`: models with input from outside. The port `finish`
    reaches each node after 1 ns.
    """
    home = [rank for rank, models in enumerate(nodes) for _ in models]
    place = {model: i for i, model in enumerate(model for models in nodes for model in models)}
    w: Matrix = [{} for _ in (*home, *nodes)]
    text: Matrix = [{} for _ in nodes]  # from what a node says to models of others
    hears: Matrix = [{} for _ in nodes]  # its models that others speak to
    paths_to = [(source, port, place[target], ZERO) for source, port, target, _ in checked(couplings, place)]
    if finish:  # the end of each node is one more place
        paths_to += [(*finish, len(home) + rank, END) for rank in range(len(nodes))]
    for source, port, b, delay in paths_to:
        a, lookahead = place[source], lookaheads.get(f"{source}.{port}", 0)
        if lookahead < NEVER:
            _shorten(w[a], b, chain(reaction(lookahead), delay))
        # events between models of one node do not pass through the coordinator
        if b >= len(home) or home[a] != home[b]:
            if lookahead < NEVER:
                _shorten(text[home[a]], b, delay)
            if b < len(home):
                hears[home[b]][b] = ZERO
    for model in heard:
        hears[home[place[model]]][place[model]] = ZERO
    home += range(len(nodes))
    reached = _reached(w, home)
    D, R = ([_nearest(row, reached) for row in rows] for rows in (text, hears))
    # a node needs no bound from its own inputs: they are in its bag
    return D, [{i: delay for i, delay in row.items() if i != j} for j, row in enumerate(R)]


def paths_to(i: int, D: Matrix, R: Matrix, least: Sequence[int]) -> list[tuple[int, int, int]]:
    """Return all paths by which events of other nodes can reach node i, with their delays.

    Each is (index of a logical time, delay in ns, delay in microsteps).

    The index of node j is j for its next output `says`, n + j for its next input `hears`, and 2n + j for its earliest
    output o.

    o_j = min(says_j, hears_j + least lookahead of j) replaces the other two if the port of j with its least lookahead
    leads to i.
    """
    n, found = len(D), []
    for j in range(n):
        if j != i and i in D[j]:
            heard = R[j].get(i)
            # both paths merge where the least lookahead is that of the port that leads to i
            if heard == chain(reaction(least[j]), D[j][i]):
                found.append((2 * n + j, *D[j][i]))
            else:
                found += [(j, *D[j][i])] + ([(n + j, *heard)] if heard else [])
    return found


def _reached(edges: Matrix, home: Sequence[int]) -> dict[int, dict[int, Delay]]:
    """Return the shortest delays from each place to each reachable node. Places with many edges are searched first, and
    their results are combined for other places."""
    found: dict[int, dict[int, Delay]] = {}
    for a in sorted(range(len(edges)), key=lambda a: -len(edges[a])):
        # neighbours all known: combine their reach in place of another search
        if all(b in found for b in edges[a]):
            found[a] = {**_nearest(edges[a], found), home[a]: ZERO}
        else:
            found[a] = _searched(a, edges, home)
    return found


def _nearest(begin: Mapping[int, Delay], reached: Mapping[int, Mapping[int, Delay]]) -> dict[int, Delay]:
    """Return the shortest delays to all nodes by way of the places in `begin`, given the delay to each of these places
    and the delays from each place onwards in `reached`."""
    found: dict[int, Delay] = {}
    for b, (wait, steps) in begin.items():
        for i, (more, k) in reached[b].items():
            distance = (wait + more, k) if more else (wait, steps + k)  # as `chain`, for all pairs of nodes
            if i not in found or distance < found[i]:
                found[i] = distance
    return found


def _searched(a: int, edges: Matrix, home: Sequence[int]) -> dict[int, Delay]:
    """Return the shortest delays from a place to each reachable node."""
    found: dict[int, Delay] = {}
    done = set[int]()
    ahead = [(ZERO, a)]
    while ahead:
        delay, a = heappop(ahead)
        if a not in done:
            # a place is final when it is taken from the heap (Dijkstra); later entries are longer
            done.add(a)
            found.setdefault(home[a], delay)
            for b, more in edges[a].items():
                if b not in done:
                    heappush(ahead, (chain(delay, more), b))
    return found


def _shorten(row: dict[int, Delay], to: int, delay: Delay) -> None:
    row[to] = min(delay, row.get(to, delay))


def checked(couplings: Iterable[Coupling], known: Collection[str]) -> Iterable[Coupling]:
    """Yield the couplings; raises ProtocolError for a coupling from or to an unknown model, or from a model to
    itself."""
    for coupling in couplings:
        source, port, target, into = coupling
        if source not in known or target not in known:
            unknown = target if source in known else source
            raise ProtocolError(f"coupling {source}.{port} -> {target}.{into}: there is no node {unknown}")
        if source == target:
            raise ProtocolError(
                f"coupling {source}.{port} -> {target}.{into}: both ports belong to one node; couple them inside it"
            )
        yield coupling


NAMED = 4  # models of a node that are named in a sentence


def together(models: Sequence[str]) -> str:
    """Return the names of a node's models as one short text."""
    more = f" and {len(models) - NAMED + 1} others" if len(models) > NAMED else ""
    return ", ".join(models[: NAMED - 1] if more else models) + more


class NodeState:
    """The coordinator's knowledge of one node, with the names that PROTOCOL.md uses."""

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
    def uncommitted(self) -> bool:
        """Whether the node's next event is an offer of outputs that is not yet committed."""
        return bool(self.offer) and not self.committed and self.next <= self.hears

    def put(self, event: Event) -> bool:
        """Queue an input of the node in total order; return whether it is now the earliest one."""
        insort(self._pending, event)
        insort(self._fresh, event)
        if self._pending[0] is not event:
            return False
        self.hears = event.tag
        return True

    def send(self, until: Tag) -> list[Event]:
        """Return the inputs before `until` that have not been sent yet, and mark them as sent."""
        return _before(self._fresh, until)

    def drop(self, reached: Tag) -> list[Event]:
        """Remove and return the inputs before `reached`, which the node has processed."""
        done = _before(self._pending, reached)
        if done:
            self.hears = self._pending[0].tag if self._pending else FOREVER
        return done

    def hold_back(self, other: "NodeState", dones: int) -> None:
        """Record that this node now blocks node `other`; `dones`: number of DONE messages of all nodes so far."""
        self.holds[other.rank] = other
        if not other._held or other._held[-1][1] != self.name:
            other._held.append((dones, self.name))

    def blocked_by(self) -> list[tuple[int, str]]:
        """Return the nodes that began to block this node since the last call, as pairs (number of DONE messages so far,
        name)."""
        held, self._held = self._held, []
        return held


def _before(inputs: list[Event], tag: Tag) -> list[Event]:
    """Remove the inputs before this logical time from a sorted list, and return them."""
    if not inputs:
        return []
    n = bisect_left(inputs, tag, key=attrgetter("tag"))
    found = inputs[:n]
    del inputs[:n]
    return found
