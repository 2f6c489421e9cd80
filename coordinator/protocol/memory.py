"""Coordinator and nodes in one thread, without transport: the protocol alone, for tests and trials.

Every message goes through its wire form. With a random generator, DONEs are
taken in random order, which may not change what the models do.
"""

from collections.abc import Iterable
from random import Random

from heavylift.kernel.errors import ModelError, ProtocolError

from .core import Coordinator, RunEnd
from .messages import Done, Fail, Grant, decode, encode
from .node import Node


def run_in_memory(coordinator: Coordinator, nodes: Iterable[Node], order: Random | None = None) -> RunEnd:
    """Run to the end; a node that fails raises ModelError with its sentence."""
    order = order or Random(0)
    by_name = {node.name: node for node in nodes}
    for name in order.sample(sorted(by_name), len(by_name)):
        hello = by_name[name].hello()
        if isinstance(hello, Fail):
            raise ModelError(hello.sentence) from by_name[name].cause
        coordinator.hello(name, hello)
    answers: list[tuple[str, Done]] = []
    while True:
        for name, grant in coordinator.ready():
            answers.append((name, answer(by_name[name], grant, coordinator)))
        outcome = coordinator.over
        if outcome is not None:
            return outcome
        name, done = answers.pop(order.randrange(len(answers)))
        coordinator.done(name, done)


def answer(node: Node, grant: Grant, coordinator: Coordinator, wired: bool = True) -> Done:
    """The DONE of a node, by way of the wire if it is `wired`; what a FAIL says is raised."""
    said = node.handle(decode(encode(grant)) if wired else grant)
    if isinstance(said, Fail):
        raise coordinator.failed(node.name, said) from node.cause
    again = decode(encode(said)) if wired and said is not None else said
    if not isinstance(again, Done):
        raise ProtocolError(f"{node.name} answered GRANT {grant.gseq} with {said!r}")
    return again
