"""Coordinator and nodes in one thread, without transport: the protocol alone, for tests and trials.

Every message goes through its wire form. With a random generator, DONEs are
taken in random order, which may not change what the models do.
"""

from collections.abc import Iterable, Mapping
from random import Random

from heavylift.kernel.errors import ModelError, ProtocolError
from heavylift.nodes.devs import FOREVER, Tag

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
    turns(coordinator, by_name, FOREVER, order)
    assert coordinator.over is not None
    return coordinator.over


def turns(
    coordinator: Coordinator, nodes: Mapping[str, Node], until: Tag, order: Random | None = None, wired: bool = True
) -> int:
    """All that nodes which have said HELLO do before a tag; the number of grants."""
    answers, grants = list[tuple[str, Done]](), 0
    while True:
        for name, grant in coordinator.ready(until):
            answers.append((name, answer(nodes[name], grant, coordinator, wired)))
            grants += 1
        if not answers:
            return grants
        coordinator.done(*answers.pop(order.randrange(len(answers)) if order else -1))


def answer(node: Node, grant: Grant, coordinator: Coordinator, wired: bool = True) -> Done:
    """Grant a node and return its DONE, encoded and decoded if `wired`; raises the error of a FAIL."""
    text = node.handle(decode(encode(grant)) if wired else grant)
    if isinstance(text, Fail):
        raise coordinator.failed(node.name, text) from node.cause
    again = decode(encode(text)) if wired and text is not None else text
    if not isinstance(again, Done):
        raise ProtocolError(f"{node.name} answered GRANT {grant.gseq} with {text!r}")
    return again
