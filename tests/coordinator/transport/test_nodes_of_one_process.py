"""Several nodes in one process: one session and one inbox, each with its own sequence, all with one end."""

import os
import signal

import pytest
from heavylift.coordinator.supervision import Processes
from heavylift.coordinator.transport import Hub, Placement
from heavylift.kernel import ProtocolError


def begin(hub: Hub, processes: Processes) -> None:
    processes.start(hub, {process: ("echo_node",) for process in hub.placement.processes})
    assert {hub.receive(5) for _ in hub.nodes} == {(node, b"hello") for node in hub.nodes}


def test_messages_to_all_nodes_of_a_process_arrive_at_the_right_node_in_order() -> None:
    placement = Placement({"yard": ("west", "kernel"), "north": ("north",)})
    with Processes(["echo_node"]) as processes, Hub(placement, directory=processes.directory) as hub:
        begin(hub, processes)
        for number in range(100):
            for node in ("west", "kernel"):
                hub.send(node, b"%s %d" % (node.encode(), number))
        assert [hub.receive(5) for _ in range(200)] == [
            (node, b"%s %d" % (node.encode(), number)) for number in range(100) for node in ("west", "kernel")
        ]
        hub.send("kernel", b"sample")
        assert hub.receive(5) == ("kernel", b"sample")
        assert hub.samples() == [("kernel", b"batch %d" % number) for number in range(3)]


def test_the_end_of_a_process_ends_all_its_nodes() -> None:
    placement = Placement({"yard": ("west", "kernel"), "gate": ("north",)})
    with Processes(["echo_node"]) as processes, Hub(placement, directory=processes.directory) as hub:
        begin(hub, processes)
        os.kill(processes.pids["yard"], signal.SIGKILL)
        with pytest.raises(ProtocolError) as error:
            hub.receive(5)
        assert str(error.value) == (
            "nodes west, kernel (process yard) are gone: its process was ended by signal 9 (SIGKILL); start the run "
            "again"
        )
