"""A twin of a node that begins at a checkpoint answers what follows, and sends samples, as the node: to the byte."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from random import Random

import msgspec
import pytest
from heavylift.coordinator.participants import KernelNode, RowFrames, configured, wiring
from heavylift.coordinator.protocol import Checkpoint, Grant, Hello, Node, OpenCoordinator, decode, encode
from heavylift.nodes.devs import Simulator, Tag, after
from heavylift.nodes.models import KERNEL, build
from heavylift.nodes.plan import Plan
from heavylift.nodes.scene import load
from heavylift.nodes.scenes import bundled
from in_memory import run_in_memory

SPAN_ns = 60 * 10**9  # of each scene that is run
LONGEST_ns = 10**10  # of a grant
EVERY = 2  # grants of a node between two checkpoints, about
MOST = 12  # checkpoints of a node
FOLLOWED = 8  # grants that a twin is given, too
LONG = ("in-turn", "turnover-untuned")
SCENES = [pytest.param(x, marks=pytest.mark.large) if x in LONG else x for x in sorted(bundled())]


@dataclass
class Replica:
    """One node of a scene, and the batches of samples that it has sent."""

    node: Node
    batches: list[bytes]
    left: int = FOLLOWED
    sent: int = 0


def replicas(plan: Plan, only: str = "") -> Iterator[Replica]:
    models, wires = build(plan), wiring(plan)
    for name, model in models.items():
        if only in ("", name):
            simulator = Simulator([model], microsteps=plan.microsteps, watched=False, wires=wires.all)
            yield Replica(Node(name, simulator), [])
    if only in ("", KERNEL):
        batches: list[bytes] = []
        kernel = KernelNode(configured(plan, models), RowFrames(batches.append), foretells=True)
        yield Replica(Node(KERNEL, kernel, kernel.finish, samples=True), batches)


@dataclass
class Watched:
    """Plays a node; from random checkpoints on, twins are told the same."""

    plan: Plan
    own: Replica
    random: Random
    twins: list[Replica] = field(default_factory=list)
    checkpoints: int = 0

    @property
    def name(self) -> str:
        return self.own.node.name

    def hello(self) -> object:
        return self.own.node.hello()

    def handle(self, message: Grant) -> object:
        first = min([self.own.node.first, *(event.tag for event in message.inputs)])
        until = min(message.until, after(first, 1 + self.random.randrange(LONGEST_ns)))
        message = msgspec.structs.replace(message, until=until)
        if message.gseq > 1 and self.checkpoints < MOST and self.random.randrange(EVERY) == 0:
            self._begin_twin()
        answer = self.own.node.handle(message)
        for twin in self.twins:
            where = f"{self.name}, grant {message.gseq}, {FOLLOWED - twin.left} after its checkpoint"
            assert twin.node.handle(decode(encode(message))) == answer, where
            assert twin.batches == self.own.batches[twin.sent :], where
            twin.left -= 1
        self.twins = [twin for twin in self.twins if twin.left]
        return answer

    def _begin_twin(self) -> None:
        state = self.own.node.handle(Checkpoint(0))
        assert isinstance(state, Checkpoint)
        if not state.state:
            return
        (twin,) = replicas(self.plan, self.name)
        assert isinstance(twin.node.hello(), Hello)
        twin.batches.clear()
        twin.sent = len(self.own.batches)
        assert twin.node.handle(decode(encode(state))) == self.own.node._done, f"{self.name} {state.gseq}"
        self.twins.append(twin)
        self.checkpoints += 1


@pytest.mark.parametrize("name", SCENES)
@pytest.mark.large(beyond=12)
def test_a_process_restored_from_any_checkpoint_gives_the_same_answers_and_samples(name: str) -> None:
    plan = load(name).plan
    wires = wiring(plan)
    nodes = [Watched(plan, own, Random(i)) for i, own in enumerate(replicas(plan))]
    models = {node.name: [node.name] for node in nodes}
    core = OpenCoordinator(
        models,
        wires.couplings,
        Tag(SPAN_ns),
        wires.finish,
        outside=wires.outside,
        microsteps=plan.microsteps,
        models=models,
    )
    run_in_memory(core, nodes)  # type: ignore[arg-type]
    assert sum(node.checkpoints for node in nodes) > 3
