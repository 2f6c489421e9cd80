"""The trace of a run for people and, with the same numbers, as plain data."""

from __future__ import annotations

from collections import Counter
from typing import Any

from heavylift.recordings.format.text import table

from .timeline import COORDINATOR, Lane, Timeline, chains

SHOWN = 8  # chains in the text


def data(timeline: Timeline) -> dict[str, Any]:
    """Seconds, counts and bytes of each node; chains of waiting; lookaheads as declared and as observed."""
    wall = timeline.wall
    return {
        "wall_s": wall * 1e-9,
        "coordinator_alone_s": timeline.alone * 1e-9,
        "grants": sum(len(lane.grants) for lane in timeline.lanes.values()),
        "nodes": [_node(lane, wall) for lane in timeline.lanes.values()],
        "chains": [{"nodes": list(chain.nodes), "s": chain.ns * 1e-9} for chain in chains(timeline)],
        "lookahead": timeline.slack,
    }


def _node(lane: Lane, wall: int) -> dict[str, Any]:
    granted = sum(grant.end - grant.begin for grant in lane.grants)
    by: Counter[str] = Counter()
    for span in lane.held:
        by[span.by] += span.end - span.begin
    held = sum(by.values())
    return {
        "node": lane.node,
        "process": lane.process,
        "grants": len(lane.grants),
        "inputs": sum(grant.inputs for grant in lane.grants),
        "outputs": sum(grant.outputs for grant in lane.grants),
        "bytes": lane.bytes,
        "busy_s": lane.busy_s,
        "granted_s": granted * 1e-9,
        "held_s": held * 1e-9,
        "idle_s": (wall - granted - held) * 1e-9,
        "held_by": {node: ns * 1e-9 for node, ns in sorted(by.items(), key=lambda item: (-item[1], item[0]))},
    }


def text(timeline: Timeline) -> str:
    """Tables: nodes, the longest chains of waiting, ports with their lookahead."""
    found = data(timeline)
    wall = found["wall_s"] or 1.0
    counts = ("grants", "inputs", "outputs")
    head = ("node", "process", *counts, "kB", "works s", "granted s", "held s", "idle s", "held by")
    rows = [
        (
            node["node"],
            node["process"],
            *(str(node[key]) for key in counts),
            f"{node['bytes'] / 1e3:.1f}",
            *(f"{node[key]:.3f}" for key in ("busy_s", "granted_s", "held_s", "idle_s")),
            ", ".join(f"{by} {100 * s / node['held_s']:.0f} %" for by, s in list(node["held_by"].items())[:2]),
        )
        for node in found["nodes"]
    ]
    alone = found["coordinator_alone_s"]
    lines = [
        f"{found['wall_s']:.3f} s from the first GRANT to the last DONE, {found['grants']} grants; for {alone:.3f} s "
        f"({100 * alone / wall:.0f} %) no node was granted: the coordinator decided or recorded",
        "",
        table(head, rows),
        "",
        "works: the node's own work; granted: from GRANT to DONE, with both messages' way; held: it had something to",
        "do, but another node's next event might have come before; idle: it had nothing to do",
    ]
    longest = found["chains"][:SHOWN]
    if longest:
        ways = [(f"{c['s']:.3f}", f"{100 * c['s'] / wall:.0f} %", _told(c["nodes"])) for c in longest]
        lines += ["", "longest waits, each with whom it was for:", table(("s", "of all", "who"), ways)]
    longer = [x for x in found["lookahead"] if x["observed_ns"] > x["declared_ns"]]
    if found["lookahead"]:
        ports = [
            (x["port"], f"{x['declared_ns'] / 1e6:g}", f"{x['observed_ns'] / 1e6:g}", str(x["count"])) for x in longer
        ]
        told = f"{len(longer)} of {len(found['lookahead'])} ports would have kept a longer lookahead in this run"
        lines += ["", f"{told}{':' if longer else ''}"]
        lines += [table(("port", "declared ms", "possible ms", "outputs"), ports)] if longer else []
    return "\n".join(lines)


def _told(nodes: list[str]) -> str:
    end = f"the {COORDINATOR}" if nodes[-1] == COORDINATOR else f"{nodes[-1]} at work"
    return " <- ".join([*nodes[:-1], end])
