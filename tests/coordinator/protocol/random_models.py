"""Random coupled models whose every transition depends on all that a Parallel DEVS may depend on.

The state is a hash of everything that happened: kinds, bags with their order, elapsed times. Up to 30 atomics stand up
to four levels deep, with a custom `confluent`, zero waits, a lookahead of its own for each port, silent transitions,
schedules left standing, fan-out and fan-in, feedback inside and between groups, and couplings and atomics that come
and go. Groups (the children of the root) become nodes. `flat` is the truth; `distributed` the protocol on our own code.
"""

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, nullcontext
from hashlib import blake2b
from random import Random
from typing import Any, NamedTuple
from unittest.mock import patch

from cut_grants import Cut
from heavylift.coordinator.protocol import (
    Bye,
    Coordinator,
    Coupling,
    Node,
    RunEnd,
    StopRun,
    core as core_module,
    node as node_module,
)
from heavylift.nodes.devs import Atomic, Bag, Coupled, Event, In, Message, Model, Port, Simulator, Tag, Transition
from heavylift.nodes.devs.execution import Wire
from in_memory import run_in_memory

END = 60  # [ns]
MICROSTEPS = 250
CALM = 12  # microstep from which on nobody waits for nothing, so that time passes
DEPTH = 4  # levels of models below the root
TIGHT = (1, 2, 3)  # events of a node that may be held, and events and tags of a grant
Logs = dict[str, list[Transition]]
Build = Callable[[int], Coupled]


class Number(Message):
    value: int


def number(*of: object) -> int:
    return int.from_bytes(blake2b(repr(of).encode(), digest_size=6).digest(), "little")


class Chaotic(Atomic):
    """Speaks by y and z, each with its lookahead, and only if what it says was scheduled for so long."""

    a, b = In(Number), In(Number)

    def __init__(self, name: str, lookaheads: tuple[int, int], shapes: bool) -> None:
        super().__init__(name)
        self.lookaheads, self.shapes = lookaheads, shapes
        self.y, self.z = (self.add_out(port, Number, ahead) for port, ahead in zip("yz", lookaheads, strict=True))

    def start(self) -> None:
        self.s, self.due, self.room, self.last = number(self.path), -1, 0, 0
        if self.s % 5:
            self.plan(self.s % 4)

    def plan(self, wait: int) -> None:
        self.due, self.room = self.now.t + wait, wait
        self.hold_in(wait)

    def output(self) -> None:
        r = self.s // 100
        y, z = (ahead <= self.room for ahead in self.lookaheads)
        if r % 5 < 3 and (z if r % 2 else y):
            (self.z if r % 2 else self.y).send(Number(r % 1000))
        if r % 7 == 0 and y and z:
            self.y.send(Number(r % 999))
            self.z.send(Number(r % 998))

    def internal(self) -> None:
        self.move("i", 0, None)
        if self.shapes and self.s % 3 == 0:
            self.shape()

    def external(self, e: int, x: Bag) -> None:
        self.move("e", e, x)

    def confluent(self, x: Bag) -> None:
        self.move("c", 0, x)

    def move(self, kind: str, e: int, x: Bag | None) -> None:
        bag = [(port.name, number.value) for port in x for number in x[port]] if x else []
        self.s = number(self.s, kind, e, bag)
        r = self.s % 11
        if r < 2:
            self.due = -1
            self.passivate()
        elif kind != "e" or r < 9 or self.due < 0:
            wait = [0, 0, 1, 2, 3, 5, 7, 0, 9][r - 2]
            self.plan(wait if wait or self.now.k < CALM else 1)
        else:
            self.room = self.due - self.now.t  # the schedule stands, but what it will say was not known before

    def result(self) -> Number:
        return Number(number(self.s, self.now))

    def shape(self) -> None:
        """Couple two siblings or part them; let a new atomic come, or the last of them go."""
        home = self.parent
        assert isinstance(home, Coupled)
        born = sorted(name for name in home.children if name.startswith("new"))
        if self.s % 5 == 0 and len(born) < 2:
            home.add(Chaotic(f"new{self.s}", self.lookaheads, False))
        elif self.s % 7 == 0 and born:
            home.remove(born[-1])
        sources = [p for m in home.children.values() for p in _ports(m, "yzuv")]
        targets = [p for m in home.children.values() for p in _ports(m, "abpq")]
        source, target = sources[self.s // 11 % len(sources)], targets[self.s // 13 % len(targets)]
        if source.owner is not target.owner and source.owner.name not in born and target.owner.name not in born:
            if (source, target) in home.couplings:
                home.disconnect(source, target)
            else:
                home.connect(source, target)


def build(seed: int, most: int = 5, densities: Sequence[float] = (0.15, 0.3, 0.5)) -> Coupled:
    """The same model for the same seed, always newly made, of 2 groups to so many."""
    r = Random(seed)
    zero, shaped = r.random() < 0.3, r.random() < 0.25
    root = Coupled("yard")
    homes = [root.add(Coupled(f"g{g}")) for g in range(r.randint(2, most))]
    atomics = max(len(homes), r.choice([4, 6, 8, 10, 14, 20, 30]))
    for _ in range(r.choice([0, 1, 3, 6])):
        home = r.choice(homes)
        if home.path.count(".") < DEPTH - 1:
            homes.append(home.add(Coupled(f"sub{len(home.children)}")))
    for i in range(atomics):
        home = homes[i] if i < len(root.children) else r.choice(homes)
        lookaheads = (0, 0) if zero else (r.choice([0, 1, 2, 4]), r.choice([0, 1, 4, 6]))
        home.add(Chaotic(f"m{i}", lookaheads, shaped and i < len(root.children)))
    _open(homes)
    _couple(root, r, r.choice(densities))
    if r.random() < 0.4:  # a source: the others hear of it long before they come there
        for source, target in list(root.couplings):
            if target.owner is homes[0]:
                root.disconnect(source, target)
    return root


def build_deep(seed: int) -> Coupled:
    """Up to 30 atomics in 2 to 5 groups, with up to four levels of coupled models."""
    r = Random(seed)
    zero, root = r.random() < 0.4, Coupled("yard")
    for g in range(r.randint(2, 5)):
        homes = [root.add(Coupled(f"g{g}"))]
        for n in range(r.randint(0, 3)):
            home = r.choice(homes)
            if home.path.count(".") < 3:
                homes.append(home.add(Coupled(f"s{n}")))
        for i in range(r.randint(1, 6)):
            ahead = 0 if zero else r.choice([0, 1, 2, 4])
            r.choice(homes).add(Chaotic(f"m{i}", (ahead, ahead), shapes=False))
        _open(homes)
    _couple(root, r, r.choice([0.06, 0.12]), 0.25)
    return root


def _open(homes: Sequence[Coupled]) -> None:
    """Ports of groups: two in, two out."""
    for home in homes:
        for p in "pq":
            home.add_in(p, Number)
        for p in "uv":
            home.add_out(p, Number)


def _couple(model: Coupled, r: Random, density: float, inside: float = 0.0) -> None:
    children = list(model.children.values())
    for child in children:
        if isinstance(child, Coupled):
            _couple(child, r, inside or min(0.35, 1.1 / max(1, len(child.children))), inside)
    sources = [p for m in children for p in _ports(m, "yzuv")] + _ports(model, "pq")
    targets = [p for m in children for p in _ports(m, "abpq")] + _ports(model, "uv")
    for source in sources:
        for target in targets:
            if source.owner is not target.owner and r.random() < density:
                model.connect(source, target)


def _ports(model: Model, names: str) -> list[Port[Any]]:
    return [port for name, port in model.ports.items() if name in names]


def _collect(logs: Logs) -> Callable[[Transition], None]:
    return lambda line: logs.setdefault(line.path, []).append(line)


def flat(seed: int, end: int = END, build: Build = build) -> Logs:
    """The truth: the whole model in one simulator."""
    logs: Logs = {}
    simulator = Simulator(build(seed), log=_collect(logs), microsteps=MICROSTEPS)
    simulator.start()
    simulator.run(end)
    return logs


def told(seed: int, end: int = END, build: Build = build) -> dict[str, Message]:
    """The results of the whole model in one simulator."""
    simulator = Simulator(build(seed), microsteps=MICROSTEPS)
    simulator.start()
    simulator.run(end)
    return simulator.results(end)


def build_ring(seed: int) -> Coupled:
    """Up to twelve groups in a ring, and few other couplings between them."""
    root = build(seed, 12, (0.0, 0.0, 0.03))
    homes = list(root.children.values())
    for source, target in zip(homes, [*homes[1:], homes[0]], strict=True):
        if (source.ports["u"], target.ports["p"]) not in root.couplings:
            root.connect(source.ports["u"], target.ports["p"])
    return root


def placed(groups: Sequence[str], seed: int) -> dict[str, list[str]]:
    """Groups dealt out to nodes of one to six of them, neighbours or any, each node by the name of its first."""
    r, left, found = Random(seed), list(groups), dict[str, list[str]]()
    while left:
        count = min(len(left), r.choice([1, 2, 2, 3, 3, 4, 5, 6]))
        some = left[:count] if seed % 2 else r.sample(left, count)
        found[some[0]] = some
        left = [group for group in left if group not in some]
    return found


def parts(
    seed: int, logs: Logs, build: Build = build, wires: Sequence[Wire] = (), together: int | None = None
) -> tuple[dict[str, Simulator], list[Coupling]]:
    """One simulator per group, or per node of a random placement, and the couplings between groups.

    `wires`: couplings from who is no group.
    """
    root = build(seed)
    couplings = [Coupling(s.owner.name, s.name, t.owner.name, t.name) for s, t in root.couplings]
    known = [*couplings, *wires]
    hosts = {name: [name] for name in root.children} if together is None else placed(list(root.children), together)
    simulators = {
        node: Simulator([root.children[name] for name in names], _collect(logs), MICROSTEPS, wires=known)
        for node, names in hosts.items()
    }
    return simulators, couplings


class Ahead:
    """A node that works ahead silently below `until`, as the mechanics kernel does."""

    def __init__(self, simulator: Simulator) -> None:
        self.simulator = simulator

    def __getattr__(self, name: str) -> Any:
        return getattr(self.simulator, name)

    def advance(self, tag: Tag, bag: Sequence[Event], until: Tag) -> None:
        self.simulator.advance(tag, bag)
        while self.simulator.next_time < until and not self.simulator.outputs():
            self.simulator.advance(self.simulator.next_time)


@contextmanager
def bounds(ahead: int, spoken: int, tags: int) -> Iterator[None]:
    """Other bounds of what a node may say and do before it waits for others."""
    with patch.object(core_module, "AHEAD", ahead), patch.multiple(node_module, SPOKEN=spoken, TAGS=tags):
        yield


class Run(NamedTuple):
    logs: Logs
    events: list[Event]
    outcome: RunEnd
    end: Tag
    results: dict[str, Message]


def distributed(
    seed: int,
    order: int = 0,
    cut: bool = False,
    ahead: bool = False,
    finish: tuple[str, str] | None = None,
    build: Build = build,
    tight: bool = False,
    together: int | None = None,
) -> Run:
    """The model cut into its groups, DONEs in random order; `tight`: grants are short and nobody may be far ahead;
    `together`: seed of a placement of several groups in a node."""
    logs: Logs = {}
    events: list[Event] = []
    simulators, couplings = parts(seed, logs, build, [(*finish, "", "")] if finish else [], together)
    models = {node: [m.name for m in simulator.models] for node, simulator in simulators.items()}
    coordinator = Coordinator(simulators, couplings, Tag(END), finish, events.append, models=models)
    nodes = [Node(name, Ahead(s) if ahead else s) for name, s in simulators.items()]
    with bounds(*TIGHT) if tight else nullcontext():
        chance = Random(order)
        outcome = run_in_memory(coordinator, [Cut(node, chance) for node in nodes] if cut else nodes, chance)
    left = [node.handle(StopRun(coordinator.end)) for node in nodes]
    results = {result.path: result.value for bye in left if isinstance(bye, Bye) for result in bye.results}
    return Run(logs, events, outcome, coordinator.end, results)
