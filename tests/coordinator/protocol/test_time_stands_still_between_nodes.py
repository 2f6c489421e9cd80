"""Messages that go around between nodes without a delay end the run, and the way that they took is named."""

from collections.abc import Mapping, Sequence
from random import Random

import pytest
from heavylift.coordinator.protocol import Coordinator, Node
from heavylift.kernel import ModelError
from heavylift.nodes.devs import Atomic, Bag, Coupled, Event, In, Message, Out, Simulator, Slack, Tag, encode, ms, succ
from heavylift.nodes.devs.execution import LONGER
from in_memory import run_in_memory

LIMIT = 200


class Ball(Message):
    n: int


class Player(Atomic):
    """Passes a ball on at once, after `rests` waits of zero; serves at the time `serve` [ns]."""

    into, out, aside = In(Ball), Out(Ball), Out(Ball)

    def __init__(self, name: str, serve: int | None = None, rests: int = 0) -> None:
        super().__init__(name)
        self.serve, self.rests = serve, rests

    def start(self) -> None:
        self.left = 0
        if self.serve is not None:
            self.hold_in(self.serve)

    def external(self, e: int, x: Bag) -> None:
        self.left = self.rests
        self.hold_in(0)

    def output(self) -> None:
        if not self.left:
            self.out.send(Ball(1))
            self.aside.send(Ball(2))

    def internal(self) -> None:
        self.left -= 1
        if self.left >= 0:
            self.hold_in(0)
        else:
            self.passivate()


def ended(players: Sequence[Player], couplings: Sequence[tuple[str, str, str, str]], order: int = 0) -> str:
    nodes = [Node(p.name, Simulator(p, microsteps=LIMIT, wires=couplings)) for p in players]
    core = Coordinator([p.name for p in players], couplings, microsteps=LIMIT)
    with pytest.raises(ModelError) as error:
        run_in_memory(core, nodes, Random(order))
    return str(error.value)


def ways(*names: str) -> list[tuple[str, str, str, str]]:
    """Once around these players."""
    return [(a, "out", b, "into") for a, b in zip(names, [*names[1:], names[0]], strict=True)]


@pytest.mark.parametrize("order", range(3))
def test_a_zero_delay_cycle_between_two_nodes_is_reported_by_name(order: int) -> None:
    assert ended([Player("b"), Player("a", serve=ms(5))], ways("a", "b"), order) == (
        "a, b at (0.005 s, 200): zero-time loop between nodes, 200 microsteps in which no time passes: "
        "a.out -> b.into, b.out -> a.into; let one of them hold for more than 0 ns" + LONGER
    )


@pytest.mark.parametrize("order", range(3))
def test_a_zero_delay_cycle_of_three_nodes_is_reported_even_if_a_fourth_node_receives_its_messages(order: int) -> None:
    players = [Player("c"), Player("a", serve=ms(5)), Player("b"), Player("x")]
    assert ended(players, [*ways("c", "b", "a"), ("b", "aside", "x", "into")], order) == (
        "a, c, b at (0.005 s, 200): zero-time loop between nodes, 200 microsteps in which no time passes: "
        "a.out -> c.into, c.out -> b.into, b.out -> a.into; let one of them hold for more than 0 ns" + LONGER
    )


@pytest.mark.parametrize("order", range(3))
def test_a_zero_delay_cycle_inside_another_cycle_is_reported_by_name(order: int) -> None:
    """a, b and c go around; b and c go around faster."""
    players = [Player("a", serve=ms(5)), Player("b"), Player("c")]
    assert ended(players, [*ways("a", "b", "c"), ("c", "aside", "b", "into")], order) == (
        "b, c at (0.005 s, 200): zero-time loop between nodes, 200 microsteps in which no time passes: "
        "b.out -> c.into, c.aside -> b.into; let one of them hold for more than 0 ns" + LONGER
    )


@pytest.mark.parametrize("rests", [1, 2, 7])
def test_nodes_that_reach_the_microstep_limit_by_exchanging_messages_are_reported_by_name(rests: int) -> None:
    assert ended([Player("a", serve=ms(5), rests=rests), Player("b")], ways("a", "b")).endswith(
        ", 200): zero-time loop between nodes, 200 microsteps in which no time passes: "
        "a.out -> b.into, b.out -> a.into; let one of them hold for more than 0 ns" + LONGER
    )


def test_a_cycle_without_delay_inside_one_node_is_reported_with_its_atomic_models() -> None:
    pair = Coupled("pair")
    left, right = pair.add(Player("left", serve=ms(5))), pair.add(Player("right"))
    pair.connect(left.out, right.into)
    pair.connect(right.out, left.into)
    pair.connect(right.aside, pair.add_out("out", Ball))
    nodes = [Node("pair", Simulator(pair, microsteps=LIMIT)), Node("x", Simulator(Player("x"), microsteps=LIMIT))]
    with pytest.raises(ModelError) as error:
        run_in_memory(Coordinator(["pair", "x"], [("pair", "out", "x", "into")], microsteps=LIMIT), nodes)
    assert "between nodes" not in str(error.value)
    assert "pair" in str(error.value)
    assert "200 microsteps without time passing" in str(error.value)


class Chatterbox:
    """Speaks at every microstep, without a limit of its own."""

    lookahead: Mapping[str, int] = {"a.out": 0}
    slack: list[Slack] = []  # noqa: RUF012
    last = Tag(0)

    def results(self, end: Tag) -> dict[str, Message]:
        return {}

    def start(self) -> None:
        self.next_time = self.quiet = Tag(5)

    def outputs(self) -> list[Event]:
        return [Event(*self.next_time, "a", "out", 0, "Ball", encode(Ball(1)))]

    def among(self) -> list[Event]:
        return []

    def advance(self, tag: Tag, bag: Sequence[Event], until: Tag) -> None:
        self.next_time = self.quiet = succ(tag)


def test_a_node_without_a_microstep_limit_of_its_own_is_reported_by_name_if_time_stands_still() -> None:
    wires = ways("a", "b")
    core = Coordinator(["a", "b"], wires, microsteps=LIMIT)
    nodes = [Node("a", Chatterbox()), Node("b", Simulator(Player("b", rests=10**6), microsteps=10**6, wires=wires))]
    with pytest.raises(ModelError) as error:
        run_in_memory(core, nodes)
    assert str(error.value) == (
        "a at (0.000000005 s, 200): port out has spoken at 200 microsteps in which no time passes; "
        "let it hold for more than 0 ns" + LONGER
    )
