"""Path lookahead: how soon what one node says or hears can make something arrive at another one.

A delay is (ns, microsteps); a positive lookahead restarts the microsteps, as in `after`, and a lookahead of zero costs
one. From j straight to m it is w[j][m], the least lookahead of those out ports of j that are coupled to m. With them
  R[j][i] = least sum of w over coupling paths from j to i: from what j hears to the bag of i
  D[j][i] = the same without its first w: from what j says to the bag of i; 0 if they are coupled
and D[i][i] is the shortest cycle through others. Shortest paths after Dijkstra (`chain` is monotone and never
shortens); the bound is that of Chandy and Misra, summed over paths.
"""

from collections.abc import Iterable, Mapping, Sequence
from heapq import heapify, heappop, heappush
from typing import NamedTuple

from heavylift.kernel.errors import ProtocolError
from heavylift.nodes.devs import FOREVER, NEVER, Tag

from .messages import Delay

Matrix = list[dict[int, Delay]]  # [from][to]; no entry = no path
ZERO: Delay = (0, 0)
END: Delay = (1, 0)  # a run ends with the time of its finish event


class Coupling(NamedTuple):
    """What `source` says on `port` lies in the bag of the in port `into` of `target`, at the same tag."""

    source: str
    port: str
    target: str
    into: str


def plus(tag: Tag, delay: Delay | None) -> Tag:
    """The tag that lies a delay after `tag`; without a path that is never."""
    if delay is None:
        return FOREVER
    wait, steps = delay
    if wait == 0:
        return Tag(tag.t, tag.k + steps) if tag.t < NEVER else FOREVER
    return Tag(tag.t + wait, steps) if wait < NEVER - tag.t else FOREVER


def chain(first: Delay, second: Delay) -> Delay:
    """One delay after the other."""
    return (first[0], first[1] + second[1]) if second[0] == 0 else (first[0] + second[0], second[1])


def reaction(lookahead: int) -> Delay:
    """From an input to the outputs that it can cause by a port with this lookahead [ns]."""
    return (lookahead, 0) if lookahead > 0 else (0, 1)


def distances(
    nodes: list[str],
    couplings: Iterable[Coupling],
    lookaheads: Mapping[str, Mapping[str, int]],
    finish: tuple[str, str] | None = None,
) -> tuple[Matrix, Matrix]:
    """D and R of the header. Each node hears of the end, said on port `finish`, as of a message that takes 1 ns."""
    rank = {name: i for i, name in enumerate(nodes)}
    said: Matrix = [{} for _ in nodes]  # from what j says over one coupling
    w: Matrix = [{} for _ in nodes]
    ways = [(source, port, target, ZERO) for source, port, target, _ in _checked(couplings, rank)]
    ways += [(*finish, name, END) for name in nodes] if finish else []
    for source, port, target, delay in ways:
        j, m, lookahead = rank[source], rank[target], lookaheads[source].get(port, 0)
        if lookahead < NEVER:
            _shorten(said[j], m, delay)
            _shorten(w[j], m, chain(reaction(lookahead), delay))

    R = [_reached(j, w) for j in range(len(nodes))]
    D = [dict(row) for row in said]
    for j, row in enumerate(said):
        for m, delay in row.items():
            for i, more in R[m].items():
                _shorten(D[j], i, chain(delay, more))
    return D, R


def ways(i: int, D: Matrix, R: Matrix, least: Sequence[int]) -> list[tuple[int, int, int]]:
    """All that can reach i, as (number of a tag, ns, microsteps); tags: says_j at j, hears_j at n + j, o_j at 2n + j.

    o_j = min(says_j, hears_j + least lookahead of j) stands for both where one port of j leads to i as soon as any.
    """
    n, found = len(D), []
    for j in range(n):
        if j != i and i in D[j]:
            if R[j][i] == chain(reaction(least[j]), D[j][i]):
                found.append((2 * n + j, *D[j][i]))
            else:
                found += [(j, *D[j][i]), (n + j, *R[j][i])]
    return found


def _reached(j: int, edges: Matrix) -> dict[int, Delay]:
    """Shortest ways from j; also back to j, through others."""
    found: dict[int, Delay] = {}
    ahead = [(delay, m) for m, delay in edges[j].items()]
    heapify(ahead)
    while ahead:
        delay, m = heappop(ahead)
        if m not in found:
            found[m] = delay
            for i, more in edges[m].items():
                if i not in found:
                    heappush(ahead, (chain(delay, more), i))
    return found


def _shorten(row: dict[int, Delay], to: int, delay: Delay) -> None:
    row[to] = min(delay, row.get(to, delay))


def _checked(couplings: Iterable[Coupling], rank: Mapping[str, int]) -> Iterable[Coupling]:
    for coupling in couplings:
        source, port, target, into = coupling
        if source not in rank or target not in rank:
            unknown = target if source in rank else source
            raise ProtocolError(f"coupling {source}.{port} -> {target}.{into}: there is no node {unknown}")
        if source == target:
            raise ProtocolError(f"coupling {source}.{port} -> {target}.{into}: couple it inside the node")
        yield coupling
