"""Coordinator and nodes in one thread, without transport: the protocol alone, each message in its wire form."""

from collections.abc import Iterable
from random import Random

from heavylift.coordinator.protocol import Coordinator, Fail, Grant, GrantDone, Node, RunEnd, decode, encode
from heavylift.kernel import ModelError
from heavylift.nodes.devs import FOREVER


def run_in_memory(coordinator: Coordinator, nodes: Iterable[Node], order: Random | None = None) -> RunEnd:
    """Run to the end, with DONEs in random order; raises ModelError with the sentence of a node that fails."""
    order = order or Random(0)
    by_name = {node.name: node for node in nodes}
    for name in order.sample(sorted(by_name), len(by_name)):
        hello = by_name[name].hello()
        if isinstance(hello, Fail):
            raise ModelError(hello.sentence) from by_name[name].cause
        coordinator.hello(name, hello)
    answers: list[tuple[str, GrantDone]] = []
    while True:
        for name, grant in coordinator.ready(FOREVER):
            answers.append((name, answer(by_name[name], grant, coordinator)))
        if not answers:
            break
        coordinator.done(*answers.pop(order.randrange(len(answers))))
    assert coordinator.over is not None
    return coordinator.over


def answer(node: Node, grant: Grant, coordinator: Coordinator) -> GrantDone:
    """Grant a node and return its DONE, both in their wire form; raises the error of a FAIL."""
    text = node.handle(decode(encode(grant)))
    if isinstance(text, Fail):
        raise coordinator.failed(node.name, text) from node.cause
    again = decode(encode(text)) if text is not None else text
    assert isinstance(again, GrantDone), f"{node.name} answered GRANT {grant.gseq} with {text!r}"
    return again
