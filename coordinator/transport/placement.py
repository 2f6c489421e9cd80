"""Placement of models in processes: one process per model, unless the scene or the command line says otherwise.

A placement depends on the scene and the command line alone, and does not change the digest of a run. Models that share
a process are one node of the protocol, named after the first of them; the kernel is always a node of its own.

    placement:                       a scene's key: process -> its nodes; all others get a process of their own
      yard-a: [west, block]
    --place "west,block=yard-a"      the same on the command line, overrides the scene
    --remote yard-a                  this process is started on another host by a user
    --external yard-a                an external program, started by a user, takes its place
    --processes 4                    models in their order over four processes; the kernel has one of its own
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

from heavylift.kernel.errors import SceneError
from heavylift.nodes.models import KERNEL

MANY = 128  # processes; of more, `check` suggests fewer


@dataclass(frozen=True)
class Placement:
    """Assignment of models to processes: process -> its models, in the order in which processes start."""

    processes: Mapping[str, tuple[str, ...]]
    remote: frozenset[str] = frozenset()
    """Processes that a user starts on another host."""
    external: frozenset[str] = frozenset()
    """Processes replaced by external programs, which a user starts."""

    @classmethod
    def apart(cls, models: Iterable[str]) -> "Placement":
        """Return the placement in which each model has a process of its own, with the model's name."""
        return cls({model: (model,) for model in models})

    @classmethod
    def spread(cls, models: Sequence[str], count: int) -> "Placement":
        """Return a placement of the models in `count` processes, in the given order; one of several processes runs
        only the kernel."""
        count = min(count, len(models))
        if count == len(models):
            return cls.apart(models)
        others = [model for model in models if model != KERNEL or count == 1]
        hands = count - (len(others) < len(models))
        cuts = [i * len(others) // hands for i in range(hands + 1)]
        hosts = {f"process-{i + 1}": tuple(others[cuts[i] : cuts[i + 1]]) for i in range(hands)}
        return cls(hosts if len(others) == len(models) else {**hosts, KERNEL: (KERNEL,)})

    @classmethod
    def of(cls, models: Sequence[str], hosts: Mapping[str, str]) -> "Placement":
        """Return the placement that runs each model in its process in `hosts`, or else in a process with the model's
        name."""
        found: dict[str, tuple[str, ...]] = {}
        for model in models:
            process = hosts.get(model, model)
            found[process] = (*found.get(process, ()), model)
        return cls(found)

    @property
    def models(self) -> tuple[str, ...]:
        """All models of the placement."""
        return tuple(model for models in self.processes.values() for model in models)

    @property
    def crowd(self) -> str:
        """Return a sentence that suggests how very many nodes of a scene can share processes; "" for a scene with
        few nodes."""
        if (count := len(self.processes)) <= MANY:
            return ""
        return f"a run starts {count} processes: `--processes auto` takes as many as pay, `--processes 4` four"

    @property
    def awaited(self) -> frozenset[str]:
        """The processes that are started by others and for which the coordinator waits: remote and external ones."""
        return self.remote | self.external

    @cached_property
    def hosted(self) -> dict[str, dict[str, tuple[str, ...]]]:
        """For each process, the nodes that run in it, each with its models."""
        return {process: nodes_of(models) for process, models in self.processes.items()}

    @cached_property
    def nodes(self) -> dict[str, tuple[str, ...]]:
        """All nodes, each with its models."""
        return {node: models for nodes in self.hosted.values() for node, models in nodes.items()}

    @cached_property
    def process_of(self) -> dict[str, str]:
        """Name of the process in which each node runs, by node."""
        return {node: process for process, nodes in self.hosted.items() for node in nodes}

    def described(self, process: str, host: str = "") -> str:
        """Return the subject and verb of a sentence about a process, such as "node west is" or "nodes a, b (process
        yard) are"."""
        nodes, at = self.processes[process], f" on host {host}" if host else ""
        if nodes == (process,):
            return f"node {process}{at} is"
        kind, verb = ("nodes", "are") if len(nodes) > 1 else ("node", "is")
        return f"{kind} {', '.join(nodes)} (process {process}{at}) {verb}"


def nodes_of(models: Sequence[str]) -> dict[str, tuple[str, ...]]:
    """Return the nodes of one process, each with its models: one node for the kernel, one for all other models."""
    together = tuple(model for model in models if model != KERNEL)
    found = {together[0]: together} if together else {}
    return {**found, KERNEL: (KERNEL,)} if KERNEL in models else found


def place(
    nodes: Sequence[str],
    scene: Mapping[str, str],
    given: Sequence[str] = (),
    count: int = 0,
    remote: Iterable[str] = (),
    external: Iterable[str] = (),
) -> Placement:
    """Return the placement of a run: by a number of processes, or as the scene states it, overridden by `--place`.

    `remote`: processes, or nodes that are alone in theirs, that users start on another host; `external`: processes that
    users replace by external programs.
    """
    placement = Placement(_place(nodes, scene, given, count).processes, frozenset(remote), frozenset(external))
    for option, processes in (("--remote", placement.remote), ("--external", placement.external)):
        for process in sorted(processes):
            if process not in placement.processes:
                known = ", ".join(placement.processes)
                raise SceneError(f"{option} '{process}': there is no process '{process}'; the processes are {known}")
    for process in sorted(placement.external):
        if process in placement.remote:
            raise SceneError(f"--external '{process}': an external program joins on this host; leave out --remote")
        if KERNEL in placement.processes[process]:
            raise SceneError(f"--external '{process}': the kernel cannot be an external program; name another process")
    return placement


def _place(nodes: Sequence[str], scene: Mapping[str, str], given: Sequence[str], count: int) -> Placement:
    if count and given:
        raise SceneError("--processes and --place both assign nodes to processes; give one of them")
    if count < 0:
        raise SceneError(f"--processes {count}: a run needs at least one process")
    if count:
        return Placement.spread(nodes, count)
    message: dict[str, str] = {}
    for text in given:
        names, equals, process = (part.strip() for part in text.partition("="))
        hosted = [name.strip() for name in names.split(",")]
        if not (equals and process and all(hosted)):
            raise SceneError(f"--place '{text}': write nodes and their process, such as --place 'west,east=yard-a'")
        for node in hosted:
            if node not in nodes:
                raise SceneError(f"--place '{text}': there is no node '{node}'; the nodes are {', '.join(nodes)}")
            if node in message:
                raise SceneError(f"--place '{text}': node '{node}' is placed twice; name it only once")
            message[node] = process
    return Placement.of(nodes, {**scene, **message})
