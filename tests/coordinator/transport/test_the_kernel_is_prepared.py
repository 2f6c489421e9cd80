"""A process waits to become the kernel, with what the kernel alone imports; it is missed by nobody if it is gone."""

import os
import signal
import subprocess
import sys
import time

import pytest
from heavylift.coordinator.supervision.processes import Processes
from heavylift.coordinator.transport.hub import Hub
from of_the_system import PATIENCE_s, gone, running

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="watches processes in /proc, which only Linux has")

NODES = ("west", "kernel")
COORDINATOR = """
from heavylift.coordinator.supervision.processes import Processes
with Processes(["echo_node"], ahead=["wave"]) as processes:
    print(processes._keeper.pid, flush=True)
    input()
"""


def waiting(keeper: int) -> int:
    """The process that the keeper has forked before any order."""
    deadline = time.monotonic() + PATIENCE_s
    while time.monotonic() < deadline:
        with open(f"/proc/{keeper}/task/{keeper}/children") as children:
            if found := children.read().split():
                return int(found[0])
        time.sleep(0.01)
    raise AssertionError("the keeper forks nobody")


def started(processes: Processes) -> dict[str, int]:
    """The processes of both nodes as they tell it themselves; all have ended in order."""
    with Hub(NODES, directory=processes.directory) as hub:
        processes.start(hub, {node: ("echo_node",) for node in NODES})
        assert {hub.receive(PATIENCE_s) for _ in NODES} == {(node, b"hello") for node in NODES}
        for node in NODES:
            hub.send(node, b"pid")
        told = dict(hub.receive(PATIENCE_s) or ("", b"") for _ in NODES)
        hub.dismiss(b"stop")
        processes.end()
    assert processes._exits == dict.fromkeys(NODES, 0)
    return {node: int(pid) for node, pid in told.items()}


@pytest.mark.parametrize("module", ["wave", "no_such_module"])  # which the kernel itself tells when it imports it
def test_who_waits_becomes_the_kernel_and_no_other(module: str) -> None:
    with Processes(["echo_node"], ahead=[module]) as processes:
        spare = waiting(processes._keeper.pid)
        pids = started(processes)
    assert pids["kernel"] == spare != pids["west"]
    assert pids == processes.pids


def test_one_that_was_killed_is_not_waited_for() -> None:
    with Processes(["echo_node"], ahead=["wave"]) as processes:
        spare = waiting(processes._keeper.pid)
        os.kill(spare, signal.SIGKILL)
        assert gone(spare)
        assert spare not in started(processes).values()


@pytest.mark.parametrize("state", ["waiting", "stopped"])
def test_it_does_not_outlive_a_coordinator_that_gives_no_order(state: str) -> None:
    coordinator = subprocess.Popen(
        [sys.executable, "-c", COORDINATOR],
        env={**os.environ, "PYTHONPATH": os.path.dirname(__file__)},
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
    )
    assert coordinator.stdout is not None
    keeper = int(coordinator.stdout.readline())
    spare = waiting(keeper)
    if state == "stopped":
        os.kill(spare, signal.SIGSTOP)
    assert running(spare)
    coordinator.kill()
    coordinator.communicate()
    assert gone(keeper, spare)
