"""Coordinator and nodes in one thread, without transport: the protocol alone, for tests and trials.

Every message goes through its wire form, unless a run is not `wired`. With a random generator, DONEs are
taken in random order, and grants can be cut at random; neither may change what the models do.
"""

from collections.abc import Iterable, Mapping
from random import Random

import msgspec
from heavylift.kernel.errors import ModelError, ProtocolError
from heavylift.nodes.devs import Tag, after, succ

from .core import Coordinator, Outcome
from .messages import Done, Fail, Grant, decode, encode
from .node import Node


def run_in_memory(
    coordinator: Coordinator, nodes: Iterable[Node], order: Random | None = None, cut: bool = False, wired: bool = True
) -> Outcome:
    """Run to the end; a node that fails raises ModelError with its sentence."""
    order = order or Random(0)
    by_name = {node.name: node for node in nodes}
    for name in order.sample(sorted(by_name), len(by_name)):
        hello = by_name[name].hello()
        if isinstance(hello, Fail):
            raise ModelError(hello.sentence)
        coordinator.hello(name, hello)
    return go_on(coordinator, by_name, order, cut, wired)


def go_on(
    coordinator: Coordinator, by_name: Mapping[str, Node], order: Random, cut: bool = False, wired: bool = True
) -> Outcome:
    """The same of nodes that have said HELLO, again if the end has been moved."""
    answers: list[tuple[str, Done]] = []
    while True:
        for name, grant in coordinator.ready():
            node = by_name[name]
            if cut:
                grant = _cut(grant, node, order)
            answers.append((name, answer(node, grant, coordinator, wired)))
        outcome = coordinator.over
        if outcome is not None:
            return outcome
        name, done = answers.pop(order.randrange(len(answers)))
        coordinator.done(name, done)


def answer(node: Node, grant: Grant, coordinator: Coordinator, wired: bool = True) -> Done:
    """The DONE of a node, by way of the wire if it is `wired`; what a FAIL says is raised."""
    said = node.handle(decode(encode(grant)) if wired else grant)
    if isinstance(said, Fail):
        raise coordinator.failed(node.name, said)
    again = decode(encode(said)) if wired and said is not None else said
    if not isinstance(again, Done):
        raise ProtocolError(f"{node.name} answered GRANT {grant.gseq} with {said!r}")
    return again


def _cut(grant: Grant, node: Node, order: Random) -> Grant:
    """The same grant, perhaps with an earlier end, yet late enough to do one tag."""
    tag = min([node.first, *(event.tag for event in grant.inputs)])
    end: Tag = order.choice([grant.until, succ(tag), after(tag, 1 + order.randrange(5))])
    return msgspec.structs.replace(grant, until=min(end, grant.until))
