"""The trace of a run as Chrome trace-event JSON, which Perfetto (ui.perfetto.dev) and other viewers read.

One track per node, grouped by process: slices `granted` and `held by X`; one track of the coordinator: from a DONE to
the last GRANT that followed it.  Arrows lead from there to what was granted and back from its end; counters show how
many nodes are granted and the simulation time reached.  Rules: "Trace Event Format" (Chromium), times in microseconds;
arrows begin and end inside slices, the events stand in the order of time.
"""

from __future__ import annotations

from bisect import bisect_right
from typing import Any

from heavylift.recordings.format.text import GENERATOR

from .timeline import COORDINATOR, Timeline

Entry = dict[str, Any]


def trace_events(timeline: Timeline) -> Entry:
    """The whole file as plain data."""
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
    """From each DONE to the last GRANT before the next DONE."""
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
            for kind, at, (a, b) in (
                ("GRANT", g.begin, ((1, 1), (pid, tid))),
                ("DONE", g.end, ((pid, tid), (1, 1))),
            ):
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
