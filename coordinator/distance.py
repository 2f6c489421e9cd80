"""Path lookahead: how soon what one node says can make another one speak.

D[j][i] = minimum over coupling paths from j to i of the summed lookaheads of the nodes between them; a
direct coupling costs nothing, a node between with zero lookahead costs one microstep. D[i][i] is the
shortest cycle through others. A delay is (ns, microsteps); a positive lookahead restarts the microsteps,
as in `after`. All-pairs shortest paths after Floyd and Warshall; the bound is that of Chandy and Misra,
summed over paths.
"""

from collections.abc import Iterable, Mapping
from typing import NamedTuple

from heavylift.kernel.errors import ProtocolError
from heavylift.nodes.devs import FOREVER, NEVER, Tag

from .messages import Delay

Matrix = list[list[Delay | None]]  # [from][to]; None = no path


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


def chain(first: Delay | None, second: Delay | None) -> Delay | None:
    """One delay after the other."""
    if first is None or second is None:
        return None
    if second[0] == 0:
        return first[0], first[1] + second[1]
    return min(first[0] + second[0], NEVER), second[1]


def distances(
    nodes: list[str], couplings: Iterable[Coupling], lookaheads: Mapping[str, int], finish: str | None = None
) -> Matrix:
    """D of the header. Each node hears of the end, said by node `finish`, as of a message that takes 1 ns."""
    rank = {name: i for i, name in enumerate(nodes)}
    D: Matrix = [[None] * len(nodes) for _ in nodes]
    if finish is not None:
        D[rank[finish]] = [(1, 0) for _ in nodes]
    for source, port, target, into in couplings:
        if source not in rank or target not in rank:
            unknown = target if source in rank else source
            raise ProtocolError(f"coupling {source}.{port} -> {target}.{into}: there is no node {unknown}")
        if source == target:
            raise ProtocolError(f"coupling {source}.{port} -> {target}.{into}: couple it inside the node")
        D[rank[source]][rank[target]] = (0, 0)

    through: list[Delay] = [(lookaheads[n], 0) if lookaheads[n] > 0 else (0, 1) for n in nodes]
    for k in range(len(nodes)):
        for a in range(len(nodes)):
            to_k = chain(D[a][k], through[k])
            if to_k is not None:
                for b in range(len(nodes)):
                    found, known = chain(to_k, D[k][b]), D[a][b]
                    if found is not None and (known is None or found < known):
                        D[a][b] = found
    return D
