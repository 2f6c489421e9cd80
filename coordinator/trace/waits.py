"""Chains of waiting: a node is held by one that is held by a third, down to the one that all of them wait for."""

from __future__ import annotations

from collections import Counter
from typing import NamedTuple

from .timeline import Timeline

COORDINATOR = "coordinator"  # the end of a chain in which no node is granted


class Chain(NamedTuple):
    """Who waited, for whom that one waited, ..., who worked meanwhile; and for how long in all [ns]."""

    nodes: tuple[str, ...]
    ns: int


def chains(timeline: Timeline) -> list[Chain]:
    """All chains of the run, the longest first; each node's waiting counts in the chain that it stands at the head of.

    A chain ends at a node that is granted, or with the coordinator, which has the DONE that everybody waits for.
    """
    total: Counter[tuple[str, ...]] = Counter()
    cuts = sorted({cut for lane in timeline.lanes.values() for span in lane.grants for cut in span[:2]})
    for node, lane in timeline.lanes.items():
        n = 0
        for span in lane.held:
            while n < len(cuts) and cuts[n] <= span.begin:
                n += 1
            begin, k = span.begin, n
            while begin < span.end:
                end = min(span.end, cuts[k]) if k < len(cuts) else span.end
                total[_chain(timeline, node, (begin + end) // 2)] += end - begin
                begin, k = end, k + 1
    return [Chain(nodes, ns) for nodes, ns in sorted(total.items(), key=lambda item: (-item[1], item[0]))]


def _chain(timeline: Timeline, node: str, at: int) -> tuple[str, ...]:
    found = [node]
    while True:
        by = timeline.holder(found[-1], at)
        if by is None or by in found:
            return (*found, COORDINATOR)
        found.append(by)
        if timeline.granted(by, at):
            return tuple(found)
