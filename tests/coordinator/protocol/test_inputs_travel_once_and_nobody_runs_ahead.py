"""A run is linear in its events and bounded in memory: inputs travel once, grants end, who is ahead waits."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import nullcontext, suppress
from itertools import pairwise
from random import Random

import msgspec
import pytest
from heavylift.coordinator.protocol import AHEAD, SPOKEN, TAGS, Coordinator, Grant, GrantDone, Node, core as core_module
from heavylift.kernel import ModelError
from heavylift.nodes.devs import FOREVER, Atomic, Bag, Event, In, Message, Out, Simulator, Tag
from heavylift.nodes.devs.execution import SILENT, Wire
from in_memory import answer
from mutants import MUTANTS
from random_models import TIGHT, bounds, parts


class Tick(Message):
    n: int


class Clock(Atomic):
    """Ticks for ever; or never says so."""

    out = Out(Tick)

    def __init__(self, name: str, period: int, silent: bool = False) -> None:
        super().__init__(name)
        self.period, self.silent = period, silent

    def start(self) -> None:
        self.hold_in(self.period)

    def output(self) -> None:
        if not self.silent:
            self.out.send(Tick(self.now.t))

    def internal(self) -> None:
        self.hold_in(self.period)


class Listener(Atomic):
    """Notes what it hears and when; `answers`: echoes it 2 ns later."""

    into, out = In(Tick), Out(Tick)

    def __init__(self, name: str, lookahead: int = 0, answers: bool = False) -> None:
        super().__init__(name)
        self.out.lookahead, self.answers = lookahead, answers

    def start(self) -> None:
        self.heard = list[tuple[int, int]]()
        self.hold_in(3)  # and says nothing then

    def external(self, e: int, x: Bag) -> None:
        self.heard += [(self.now.t, tick.n) for tick in x[self.into]]
        if self.answers:
            self.hold_in(2)

    def output(self) -> None:
        if self.heard and self.answers:
            self.out.send(Tick(-1))

    def internal(self) -> None:
        self.passivate()


Show = Callable[[str, Grant], None]


def rounds(core: Coordinator, nodes: dict[str, Node], n: int, each: Show, seed: int = 0) -> None:
    """So many DONEs, in random order or (0) always that of the first by name; `each` grant is shown."""
    order = Random(seed)
    for name, node in nodes.items():
        core.hello(name, node.hello())  # type: ignore[arg-type]
    answers: list[tuple[str, GrantDone]] = []
    for _ in range(n):
        for name, grant in core.ready():
            each(name, grant)
            answers.append((name, answer(nodes[name], grant, core)))
        if not answers:
            return
        core.done(*answers.pop(order.randrange(len(answers)) if seed else answers.index(min(answers))))


def nodes_of(wires: Sequence[Wire], *models: Atomic) -> dict[str, Node]:
    return {model.name: Node(model.name, Simulator(model, wires=wires or None)) for model in models}


def sent(seed: int) -> list[tuple[str, Event]]:
    """Who is sent which inputs in all grants of a random model whose grants are short."""
    simulators, couplings = parts(seed, {})
    message: list[tuple[str, Event]] = []
    nodes = {name: Node(name, simulator) for name, simulator in simulators.items()}
    core = Coordinator(nodes, couplings, Tag(60))
    with bounds(*TIGHT):
        rounds(core, nodes, 10_000, lambda name, grant: message.extend((name, d) for d in grant.inputs), 1 + seed)
    return message


def test_the_coordinator_sends_each_input_of_a_node_in_exactly_one_grant(monkeypatch: pytest.MonkeyPatch) -> None:
    truth = [sent(seed) for seed in range(10)]
    assert [len(message) for message in truth] == [len(set(message)) for message in truth]
    assert sum(map(len, truth)) > 300
    # all pending inputs with every grant, to nodes that keep none, is as right, but quadratic
    MUTANTS["inputs_are_sent_with_every_grant"](monkeypatch)
    MUTANTS["inputs_that_were_not_reached_are_forgotten"](monkeypatch)
    again = [sent(seed) for seed in range(10)]
    assert [set(message) for message in again] == [set(message) for message in truth]
    assert sum(map(len, again)) > sum(map(len, truth))


@pytest.mark.parametrize("name", ["", "new_inputs_come_behind_those_that_are_kept"])
def test_a_node_answers_a_message_before_it_handles_later_messages(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """The source has said 10, 20, 30 ... before b hears of 10 and speaks; c's answer of 14 comes before the 20."""
    if name:
        MUTANTS[name](monkeypatch)
    b, c = Listener("b", answers=True), Listener("c", answers=True)
    wires = [("a", "out", "b", "into"), ("b", "out", "c", "into"), ("c", "out", "b", "into")]
    nodes = nodes_of(wires, Clock("a", 10), b, c)
    with suppress(ModelError) if name else nullcontext():
        rounds(Coordinator(nodes, wires, Tag(25)), nodes, 100, lambda name, grant: None)
    assert (b.heard == [(10, 10), (14, -1), (18, -1), (20, 20), (22, -1), (24, -1)]) is not bool(name)


def test_a_node_returns_its_grant_after_a_limited_number_of_events() -> None:
    node = nodes_of([], Clock("a", 1))["a"]
    node.hello()
    done = node.handle(Grant(1, FOREVER, None, False, []))
    assert isinstance(done, GrantDone)
    assert (len(done.spoken), done.reached, done.next) == (SPOKEN, Tag(SPOKEN, 1), Tag(SPOKEN + 1))


def test_a_node_without_outputs_returns_its_grant_after_a_limited_number_of_logical_times() -> None:
    node = nodes_of([], Clock("a", 1, silent=True))["a"]
    node.hello()
    for gseq in (1, 2):
        done = node.handle(Grant(gseq, FOREVER, None, False, []))
        assert isinstance(done, GrantDone)
        assert (done.spoken, done.reached) == ([], Tag(gseq * ((TAGS - 1) * SILENT + 1), 1))


NETWORKS = {
    "one that listens": ([Listener("b")], ["b"]),
    "one that is busy with itself": ([Listener("b"), Clock("c", 5)], ["b"]),
    "one whose lookahead lets events leave before it has heard them": ([Listener("b", lookahead=10**6)], ["b"]),
    "many": ([Listener(f"b{i}") for i in range(5)], [f"b{i}" for i in range(5)]),
}


@pytest.mark.parametrize("network", NETWORKS)
@pytest.mark.parametrize("bounded", [True, False])
def test_a_model_that_sends_without_end_does_not_advance_far_ahead_of_the_other_models(
    network: str, bounded: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """It always answers first: what it has said and others have not done exceeds the bound by a grant at most."""
    if not bounded:
        monkeypatch.setattr(core_module, "AHEAD", 10**9)
    others, hear = NETWORKS[network]
    wires = [("a", "out", name, "into") for name in hear]
    nodes = nodes_of(wires, Clock("a", 1), *others)
    core = Coordinator(nodes, wires)
    most = 0

    def each(name: str, grant: Grant) -> None:
        nonlocal most
        most = max(most, core._nodes["a"].ahead, len(core._held))

    rounds(core, nodes, 40, each)
    assert (most <= AHEAD + (SPOKEN + 1) * (1 + len(hear))) is bounded, most


@pytest.mark.parametrize("seed", range(5))
def test_even_with_the_shortest_time_grants_time_advances_in_any_model(seed: int) -> None:
    simulators, couplings = parts(seed, {})
    nodes = {name: Node(name, simulator) for name, simulator in simulators.items()}
    core, floors = Coordinator(nodes, couplings), list[Tag]()
    with bounds(1, 1, 1):
        rounds(core, nodes, 2_000, lambda name, grant: floors.append(core.floor), 1 + seed)
    assert all(a <= b for a, b in pairwise(floors))
    assert core.over is not None or floors[-1].t > floors[len(floors) // 2].t


def test_samples_from_a_node_that_is_still_computing_allow_earlier_events_of_other_nodes_to_be_released() -> None:
    """a is at 700 in a grant without an end: what b has said up to there leaves, and nothing of a's can come before."""
    left: list[int] = []
    core = Coordinator("ab", [], on_event=lambda event: left.append(event.t))
    a, b = Node("a", Simulator(Clock("a", 400)), samples=True), Node("b", Simulator(Clock("b", 250)))
    for node in (a, b):
        core.hello(node.name, node.hello())  # type: ignore[arg-type]
    grants = dict(core.ready())
    assert (grants["a"].until, left) == (FOREVER, [])
    core.done("b", answer(b, grants["b"], core))
    core.ready()
    assert (core.floor, left) == (Tag(400), [250])
    done = a.handle(msgspec.structs.replace(grants["a"], committed=False))
    assert isinstance(done, GrantDone)
    assert (done.reached, len(done.spoken)) == (Tag(400, 1), 1)
    core.working("a", 700)
    assert (core.floor, left) == (Tag(700), [250, 400, 500])
    core.working("a", 600)  # told twice, by a successor
    assert core.floor == Tag(700)
