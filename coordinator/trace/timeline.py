"""Working and waiting times of a run, read from the recorded protocol messages; all times in ns since the first GRANT.

A node is *granted* from its GRANT to its DONE (its own work, and the transport of both messages); *held* while it has
pending work but another node's next event blocks it; else *idle*. `held` of a GRANT lists which node began to block it
after how many DONEs of all nodes, so that no clock is read when a run decides.

Chains of waiting: a node is blocked by one that is blocked by a third, down to the one that all of them wait for.
"""

from bisect import bisect_left
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, field
from itertools import pairwise
from pathlib import Path
from typing import Any, NamedTuple

import msgspec
from heavylift.coordinator.protocol.distance import together
from heavylift.coordinator.transport.placement import nodes_of
from heavylift.kernel.errors import RecordingError
from heavylift.recordings import Recording

PROTOCOL = "/protocol/"
COORDINATOR = "coordinator"  # the end of a chain in which no node is granted


class GrantSpan(NamedTuple):
    """One grant of a node: wall times of its GRANT and its DONE [ns], number of inputs and outputs, simulation time
    [ns]."""

    begin: int
    end: int
    gseq: int
    inputs: int
    outputs: int
    t_ns: int


class HeldTime(NamedTuple):
    """Interval of wall time [ns] in which a node could not be granted time because of possible events from node
    `by`."""

    begin: int
    end: int
    by: str


@dataclass
class Lane:
    """The activity of one node over wall time: its grants, the intervals in which it was blocked, and its working time
    [s]."""

    node: str
    process: str
    grants: list[GrantSpan] = field(default_factory=list)
    held: list[HeldTime] = field(default_factory=list)
    busy_s: float = 0.0
    bytes: int = 0


class _Summary(msgspec.Struct):
    wall_ns: int = -1
    gseq: int = 0
    inputs: int = 0
    spoken: int = 0
    offer: int = 0
    busy_s: float = 0.0
    held: list[tuple[int, str]] = []


class _Message(msgspec.Struct):
    kind: str
    node: str
    t_ns: int
    summary: _Summary
    raw: bytes


class Timeline:
    """Activity of all nodes of a recorded run over wall time; raises RecordingError if the recording has no protocol
    messages."""

    def __init__(self, path: str | Path) -> None:
        recording = Recording(path)
        placed: dict[str, list[str]] = recording.fact("placement", {})
        models: list[str] = recording.fact("nodes", [])
        placed = placed or {model: [model] for model in models}
        hosted = {node: (process, some) for process, all_ in placed.items() for node, some in nodes_of(all_).items()}
        self.path = Path(path)
        self.slack: list[dict[str, Any]] = recording.fact("slack", [])
        self._message = {node: together(some) for node, (_, some) in hosted.items()}
        order = sorted(hosted, key=lambda node: min(map(models.index, hosted[node][1])) if models else 0)
        self.lanes = {self._message[node]: Lane(self._message[node], hosted[node][0]) for node in order}
        """Lanes by node, in the order of the run."""
        with recording.reading():
            messages = sorted(_messages(recording), key=lambda message: message.summary.wall_ns)
        if not any(message.kind == "GRANT" for message in messages):
            raise RecordingError(
                f"{path}: has no GRANT message, so there is nothing to trace; record a run that gets past its start"
            )
        if messages[0].summary.wall_ns < 0:
            raise RecordingError(f"{path}: its protocol messages have no wall time; record the run again")
        self._read(messages)

    @property
    def wall(self) -> int:
        """Wall time from the first GRANT to the last DONE [ns]."""
        return max((grant.end for lane in self.lanes.values() for grant in lane.grants), default=0)

    @property
    def alone(self) -> int:
        """Wall time [ns] in which no node had a grant, so that only the coordinator worked."""
        free, reached = 0, 0
        for grant in sorted(grant for lane in self.lanes.values() for grant in lane.grants):
            free += max(0, grant.begin - reached)
            reached = max(reached, grant.end)
        return free

    def _read(self, messages: list[_Message]) -> None:
        first = next(message.summary.wall_ns for message in messages if message.kind == "GRANT")
        dones = [message.summary.wall_ns - first for message in messages if message.kind == "DONE"]
        granted: dict[str, _Message] = {}
        for message in messages:
            node = self._message.get(message.node, message.node)
            lane = self.lanes.setdefault(node, Lane(node, node))
            lane.bytes += len(message.raw)
            now, summary = message.summary.wall_ns - first, message.summary
            if message.kind == "GRANT":
                granted[message.node] = message
                begins = [dones[n - 1] if n else 0 for n, _ in summary.held] + [now]
                for (begin, end), (_, by) in zip(pairwise(begins), summary.held, strict=True):
                    if end > begin:
                        lane.held.append(HeldTime(begin, end, self._message.get(by, by)))
            elif message.kind == "DONE" and message.node in granted:
                asked = granted.pop(message.node)
                begin, outputs = asked.summary.wall_ns - first, summary.spoken + summary.offer
                lane.grants.append(GrantSpan(begin, now, summary.gseq, asked.summary.inputs, outputs, asked.t_ns))
            elif message.kind == "BYE":
                lane.busy_s = summary.busy_s

    def holder(self, node: str, at: int) -> str | None:
        """Return the node for which `node` waits at a wall time [ns]; None if it does not wait."""
        held = self.lanes[node].held
        n = bisect_left(held, at, key=lambda span: span.end)
        return held[n].by if n < len(held) and held[n].begin <= at else None

    def granted(self, node: str, at: int) -> bool:
        """Return whether a node has a GRANT at a wall time [ns]."""
        grants = self.lanes[node].grants
        n = bisect_left(grants, at, key=lambda span: span.end)
        return n < len(grants) and grants[n].begin <= at


def _messages(recording: Recording) -> Iterator[_Message]:
    decode = msgspec.json.Decoder(_Message).decode
    topics = [topic for topic in recording.topics if topic.startswith(PROTOCOL)]
    return (decode(raw.data) for raw in recording.messages(*topics))


class Chain(NamedTuple):
    """A chain of nodes in which each waits for the next; `ns`: total waiting time [ns]."""

    nodes: tuple[str, ...]
    ns: int


def chains(timeline: Timeline) -> list[Chain]:
    """Return all chains of waiting nodes with their total times, longest first.

    The waiting time of a node counts in the chain that begins with it. A chain ends at a node with a GRANT, or at the
    coordinator if that already has the DONE for which all wait.
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
