"""A hub with its node processes for one test, and what the operating system says about them."""

import os
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, suppress

import pytest
from heavylift.coordinator.hub import Hub
from heavylift.coordinator.processes import Processes

Start = Callable[..., tuple[Hub, Processes]]


@pytest.fixture
def start() -> Iterator[Start]:
    """`start(west=("burst", "20000"), east=())`: a run with these echo nodes, which have said hello."""
    with ExitStack() as stack:

        def go(fork: bool = True, hello: bool = True, **nodes: tuple[str, ...]) -> tuple[Hub, Processes]:
            hub = stack.enter_context(Hub(nodes))
            processes = Processes(["echo_node"], fork=fork)
            stack.callback(processes.end, grace=0.0)
            processes.start(hub, {node: ("echo_node", *what) for node, what in nodes.items()})
            if hello:
                assert {hub.receive(10) for _ in nodes} == {(node, b"hello") for node in nodes}
            return hub, processes

        yield go


def running(pid: int) -> bool:
    """Whether this process exists and is no zombie."""
    try:
        with open(f"/proc/{pid}/stat") as stat:
            return stat.read().rpartition(")")[2].split()[0] != "Z"
    except OSError:
        return False


def gone_within(seconds: float, *pids: int) -> bool:
    """Whether all these processes have ended in time."""
    deadline = time.monotonic() + seconds
    while any(running(pid) for pid in pids):
        if time.monotonic() > deadline:
            return False
        time.sleep(0.01)
    return True


def sockets(pid: int) -> set[str]:
    """The inodes of all open sockets of a process."""
    found = set()
    for fd in os.listdir(f"/proc/{pid}/fd"):
        with suppress(FileNotFoundError):
            target = os.readlink(f"/proc/{pid}/fd/{fd}")
            if target.startswith("socket:["):
                found.add(target[8:-1])
    return found


def network_sockets(pid: int) -> list[str]:
    """The TCP, UDP and raw sockets of a process, as lines of /proc/net."""
    inodes, found = sockets(pid), []
    for kind in ("tcp", "tcp6", "udp", "udp6", "raw", "raw6"):
        with open(f"/proc/{pid}/net/{kind}") as table:
            found += [f"{kind} {line}" for line in table.readlines()[1:] if line.split()[9] in inodes]
    return found
