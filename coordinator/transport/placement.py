"""Which process hosts which nodes: one process per node, unless the scene or the command line says otherwise.

A placement is a function of the scene and the command line alone, and it changes no byte of a run's digest:
nodes that share a process take turns there, in the order in which their messages arrive.

    placement:                       a scene's key: process -> its nodes; all others get a process of their own
      yard-a: [west, loader-1]
    --place "west,loader-1=yard-a"   the same on the command line, laid over the scene's
    --remote yard-a                  somebody starts this process on another host
    --processes 4                    nodes dealt out over four processes; the kernel has one to itself
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

from heavylift.kernel.errors import SceneError

__all__ = ["Placement", "place"]


@dataclass(frozen=True)
class Placement:
    """Process -> the nodes that it hosts, in the order in which processes are started."""

    processes: Mapping[str, tuple[str, ...]]
    remote: frozenset[str] = frozenset()
    """Processes that somebody starts on another host."""

    @classmethod
    def apart(cls, nodes: Iterable[str]) -> Placement:
        """A process for each node, of the same name."""
        return cls({node: (node,) for node in nodes})

    @classmethod
    def spread(cls, nodes: Sequence[str], count: int, alone: str) -> Placement:
        """The nodes dealt out over `count` processes; the node `alone` has one to itself if there are two or more."""
        count = min(count, len(nodes))
        if count == len(nodes):
            return cls.apart(nodes)
        others = [node for node in nodes if node != alone or count == 1]
        hands = count - (len(others) < len(nodes))
        hosts = {f"process-{i + 1}": tuple(others[i::hands]) for i in range(hands)}
        return cls(hosts if len(others) == len(nodes) else {**hosts, alone: (alone,)})

    @classmethod
    def of(cls, nodes: Sequence[str], hosts: Mapping[str, str]) -> Placement:
        """`hosts`: node -> process; a node that is not named there has a process of its own name."""
        found: dict[str, tuple[str, ...]] = {}
        for node in nodes:
            process = hosts.get(node, node)
            found[process] = (*found.get(process, ()), node)
        return cls(found)

    @property
    def nodes(self) -> tuple[str, ...]:
        """All nodes."""
        return tuple(node for nodes in self.processes.values() for node in nodes)

    @property
    def process_of(self) -> dict[str, str]:
        """Node -> its process."""
        return {node: process for process, nodes in self.processes.items() for node in nodes}

    def told(self, process: str, host: str = "") -> str:
        """Subject of a sentence about all nodes of a process: "node west is", or "nodes a, b (process yard) are"."""
        nodes, at = self.processes[process], f" on host {host}" if host else ""
        if nodes == (process,):
            return f"node {process}{at} is"
        kind, verb = ("nodes", "are") if len(nodes) > 1 else ("node", "is")
        return f"{kind} {', '.join(nodes)} (process {process}{at}) {verb}"


def place(
    nodes: Sequence[str],
    alone: str,
    scene: Mapping[str, str],
    given: Sequence[str] = (),
    count: int = 0,
    remote: Iterable[str] = (),
) -> Placement:
    """The placement of a run: a number of processes, or the scene's hosts with those of `--place` laid over them.

    `remote`: processes, or nodes that are alone in theirs, that somebody starts on another host.
    """
    placement = _place(nodes, alone, scene, given, count)
    for process in remote:
        if process not in placement.processes:
            known = ", ".join(placement.processes)
            raise SceneError(f"--remote '{process}': there is no process '{process}'; the processes are {known}")
    return Placement(placement.processes, frozenset(remote))


def _place(nodes: Sequence[str], alone: str, scene: Mapping[str, str], given: Sequence[str], count: int) -> Placement:
    if count and given:
        raise SceneError("--processes and --place say two things about the same nodes, give one of them")
    if count < 0:
        raise SceneError(f"--processes {count}: a run needs at least one process")
    if count:
        return Placement.spread(nodes, count, alone)
    told: dict[str, str] = {}
    for text in given:
        names, equals, process = (part.strip() for part in text.partition("="))
        hosted = [name.strip() for name in names.split(",")]
        if not (equals and process and all(hosted)):
            raise SceneError(f"--place '{text}': write nodes and their process, such as --place 'west,east=yard-a'")
        for node in hosted:
            if node not in nodes:
                raise SceneError(f"--place '{text}': there is no node '{node}'; the nodes are {', '.join(nodes)}")
            if node in told:
                raise SceneError(f"--place '{text}': node '{node}' is placed twice, name it once")
            told[node] = process
    return Placement.of(nodes, {**scene, **told})
