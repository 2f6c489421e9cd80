"""A hub with its node processes for one test."""

from collections.abc import Iterator
from contextlib import ExitStack

import pytest
from heavylift.coordinator.supervision import Processes
from heavylift.coordinator.transport import Hub
from of_the_system import Start


@pytest.fixture
def start() -> Iterator[Start]:
    """`start(west=("burst", "20000"), east=())`: a run with these echo nodes, which have said hello."""
    with ExitStack() as stack:

        def go(fork: bool = True, hello: bool = True, **nodes: tuple[str, ...]) -> tuple[Hub, Processes]:
            processes = Processes(["echo_node"], fork=fork)
            stack.callback(processes.end, grace=0.0)
            hub = stack.enter_context(Hub(nodes, directory=processes.directory))
            processes.start(hub, {node: ("echo_node", *what) for node, what in nodes.items()})
            if hello:
                assert {hub.receive(10) for _ in nodes} == {(node, b"hello") for node in nodes}
            return hub, processes

        yield go
