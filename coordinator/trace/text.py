"""The trace of a run as text for people, as plain data, and as Chrome trace-event JSON, which Perfetto reads.

One track per node, grouped by process: slices `granted` and `held by X`; one track of the coordinator: from a DONE to
the last GRANT that followed it. Arrows lead from there to the granted nodes and back from the end of a grant; counters
show the number of granted nodes and the simulation time. Format: "Trace Event Format" (Chromium), times in
microseconds; arrows begin and end inside slices, events are in the order of time.
"""

from bisect import bisect_right
from collections import Counter
from typing import Any

from heavylift.recordings.format.text import GENERATOR
from heavylift.recordings.sheets.sheet import listed

from .timeline import COORDINATOR, Lane, Timeline, chains

SHOWN = 8  # chains in the text


def data(timeline: Timeline) -> dict[str, Any]:
    """Return a trace as plain data: times [s], message counts and bytes of each node, chains of waiting nodes, declared
    and observed lookaheads."""
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
    """Return a trace as three tables: nodes, the longest chains of waiting nodes, and ports with their lookahead."""
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
        listed(head, rows),
        "",
        "works: the node's own work; granted: from GRANT to DONE, with both messages' way; held: it had something to",
        "do, but another node's next event might have come before; idle: it had nothing to do",
    ]
    longest = found["chains"][:SHOWN]
    if longest:
        distances = [(f"{c['s']:.3f}", f"{100 * c['s'] / wall:.0f} %", _described(c["nodes"])) for c in longest]
        lines += ["", "longest waits, each with whom it was for:", listed(("s", "of all", "who"), distances)]
    longer = [x for x in found["lookahead"] if x["observed_ns"] > x["declared_ns"]]
    if found["lookahead"]:
        ports = [
            (x["port"], f"{x['declared_ns'] / 1e6:g}", f"{x['observed_ns'] / 1e6:g}", str(x["count"])) for x in longer
        ]
        message = f"{len(longer)} of {len(found['lookahead'])} ports would have kept a longer lookahead in this run"
        lines += ["", f"{message}{':' if longer else ''}"]
        lines += [listed(("port", "declared ms", "possible ms", "outputs"), ports)] if longer else []
    return "\n".join(lines)


def _described(nodes: list[str]) -> str:
    end = f"the {COORDINATOR}" if nodes[-1] == COORDINATOR else f"{nodes[-1]} at work"
    return " <- ".join([*nodes[:-1], end])


Entry = dict[str, Any]


def trace_events(timeline: Timeline) -> Entry:
    """Return the whole trace as Chrome trace events, in plain data."""
    processes = {name: i + 2 for i, name in enumerate(dict.fromkeys(x.process for x in timeline.lanes.values()))}
    found: list[Entry] = [_name("process_name", 1, 0, COORDINATOR), _name("thread_name", 1, 1, "decides and records")]
    found += [_name("process_name", pid, 0, name) for name, pid in processes.items()]
    slices: list[Entry] = []
    where = {node: (processes[lane.process], i + 2) for i, (node, lane) in enumerate(timeline.lanes.items())}
    for node, lane in timeline.lanes.items():
        pid, tid = where[node]
        found.append(_name("thread_name", pid, tid, node))
        for g in lane.grants:
            facts = {"gseq": g.gseq, "inputs": g.inputs, "outputs": g.outputs, "t_s": g.t_ns / 1e9}
            slices.append(_slice("granted", g.begin, g.end, pid, tid, facts))
        slices += [_slice(f"held by {span.by}", span.begin, span.end, pid, tid, {}) for span in lane.held]
    slices += [_slice("decides", begin, end, 1, 1, {}) for begin, end in _decisions(timeline)]
    events = slices + _arrows(timeline, where) + _counters(timeline)
    events.sort(key=lambda e: e["ts"])
    return {"traceEvents": found + events, "displayTimeUnit": "ms", "otherData": {"generator": GENERATOR}}


def _decisions(timeline: Timeline) -> list[tuple[int, int]]:
    """Return the intervals from each DONE to the last GRANT before the next DONE [ns]."""
    grants = [grant for lane in timeline.lanes.values() for grant in lane.grants]
    begins = sorted(grant.begin for grant in grants)
    dones = [0, *sorted(grant.end for grant in grants)]
    found = []
    for n, done in enumerate(dones):
        last = bisect_right(begins, dones[n + 1]) if n + 1 < len(dones) else len(begins)
        found.append((done, max(done, begins[last - 1]) if last else done))
    return found


def _arrows(timeline: Timeline, where: dict[str, tuple[int, int]]) -> list[Entry]:
    found: list[Entry] = []
    for node, lane in timeline.lanes.items():
        pid, tid = where[node]
        for g in lane.grants:
            for kind, at, (a, b) in (("GRANT", g.begin, ((1, 1), (pid, tid))), ("DONE", g.end, ((pid, tid), (1, 1)))):
                arrow = {"name": kind, "cat": "protocol", "id": f"{kind} {node} {g.gseq}", "ts": at / 1e3}
                found.append({**arrow, "ph": "s", "pid": a[0], "tid": a[1]})
                found.append({**arrow, "ph": "f", "bp": "e", "pid": b[0], "tid": b[1]})
    return found


def _counters(timeline: Timeline) -> list[Entry]:
    grants = [grant for lane in timeline.lanes.values() for grant in lane.grants]
    steps = sorted([(g.begin, 1, g.t_ns) for g in grants] + [(g.end, -1, g.t_ns) for g in grants])
    running, reached, found = 0, 0, []
    for at, step, t_ns in steps:
        running, reached = running + step, max(reached, t_ns)
        counter = {"ph": "C", "ts": at / 1e3, "pid": 1, "tid": 1}
        found.append({**counter, "name": "nodes granted", "args": {"nodes": running}})
        found.append({**counter, "name": "simulation time", "args": {"s": reached / 1e9}})
    return found


def _slice(name: str, begin: int, end: int, pid: int, tid: int, facts: Entry) -> Entry:
    times = {"ts": begin / 1e3, "dur": (end - begin) / 1e3}
    return {"name": name, "cat": "node", "ph": "X", **times, "pid": pid, "tid": tid, "args": facts}


def _name(what: str, pid: int, tid: int, name: str) -> Entry:
    return {"name": what, "ph": "M", "ts": 0, "pid": pid, "tid": tid, "args": {"name": name}}
