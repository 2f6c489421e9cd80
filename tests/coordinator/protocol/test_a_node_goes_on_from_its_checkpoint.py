"""A node that is replaced between two grants by a twin with its checkpoint, again and again, shows nothing of it."""

from __future__ import annotations

from collections.abc import Callable
from random import Random

import pytest
from cut_grants import Cut
from heavylift.coordinator.protocol import (
    AnyMessage,
    Checkpoint,
    Coordinator,
    Fail,
    Grant,
    GrantDone,
    Hello,
    Node,
    decode,
    encode,
    node as node_module,
)
from heavylift.nodes.devs import Atomic, Event, Message, Out, Simulator, Tag
from in_memory import run_in_memory
from random_models import END, Logs, distributed, parts

MODELS = range(40)


class Mortal(Node):
    """Is replaced before a grant now and then."""

    def __init__(self, name: str, simulators: Callable[[], dict[str, Simulator]], random: Random) -> None:
        super().__init__(name, simulators()[name])
        self._simulators, self._random, self.lives = simulators, random, 1

    def handle(self, message: AnyMessage) -> AnyMessage | None:  # type: ignore[override]
        if isinstance(message, Grant) and message.gseq > 1 and self._random.random() < 0.3:
            self._die()
        return super().handle(message)

    def _die(self) -> None:
        last = self._done
        state = Node.handle(self, Checkpoint(self._gseq))
        assert isinstance(state, Checkpoint)
        assert state.state, state.why
        twin = Node(self.name, self._simulators()[self.name])
        assert isinstance(twin.hello(), Hello)
        assert twin.handle(decode(encode(state))) == last
        vars(self).update(vars(twin))
        self.lives += 1


def disturbed(seed: int, together: int | None = None) -> tuple[Logs, list[Event], int]:
    """Logs and events of a model whose nodes are replaced, whose grants are cut, and how many lives they had;
    `together`: seed of a placement of several groups in a node."""
    logs: Logs = {}
    events: list[Event] = []
    simulators, couplings = parts(seed, logs, together=together)
    models = {node: [m.name for m in simulator.models] for node, simulator in simulators.items()}
    nodes = [Mortal(name, lambda: parts(seed, logs, together=together)[0], Random(seed)) for name in simulators]
    core = Coordinator(simulators, couplings, Tag(END), None, events.append, models=models)
    chance = Random(seed)
    run_in_memory(core, [Cut(node, chance) for node in nodes], chance)
    return logs, events, sum(node.lives for node in nodes)


@pytest.mark.large
@pytest.mark.parametrize(("shared", "least"), [(False, 400), (True, 200)], ids=["alone", "in groups"])
def test_a_node_restored_from_its_checkpoint_reproduces_every_event_of_the_undisturbed_run(
    shared: bool, least: int
) -> None:
    lives = 0
    for seed in MODELS:
        truth = distributed(seed)
        logs, events, lived = disturbed(seed, seed if shared else None)
        assert (logs, events) == (truth.logs, truth.events), seed
        lives += lived
    assert lives > least


def test_the_test_detects_a_checkpoint_that_omits_the_queued_inputs_of_a_node(monkeypatch: pytest.MonkeyPatch) -> None:
    assert all(disturbed(seed)[0] == distributed(seed).logs for seed in range(5))
    monkeypatch.setattr(node_module, "sorted", lambda kept: [], raising=False)
    assert not all(disturbed(seed)[0] == distributed(seed).logs for seed in range(5))


class Clocked(Message):
    n: int


class Secret(Atomic):
    """Keeps a function that no other process could find."""

    out = Out(Clocked)

    def start(self) -> None:
        self.law = lambda n: n + 1
        self.n = 0
        self.hold_in(1)

    def output(self) -> None:
        self.out.send(Clocked(self.n))

    def internal(self) -> None:
        self.n = self.law(self.n)
        self.hold_in(1)


def test_a_state_that_cannot_be_saved_is_reported_and_the_node_continues_its_run() -> None:
    node = Node("secret", Simulator(Secret("secret")))
    node.hello()
    assert isinstance(node.handle(Grant(1, Tag(5), None, False, [])), GrantDone)
    answer = node.handle(Checkpoint(1))
    assert isinstance(answer, Checkpoint)
    assert answer.state == b""
    assert answer.why.startswith("secret: no snapshot can be taken (Secret.start.<locals>.<lambda> cannot be saved")
    assert isinstance(node.handle(Grant(2, Tag(9), None, False, [])), GrantDone)


def test_a_checkpoint_whose_bytes_hold_no_saved_state_is_refused() -> None:
    node = Node("secret", Simulator(Secret("secret")))
    node.hello()
    assert isinstance(node.handle(Checkpoint(1, b"spoiled")), Fail)
