"""A node dies, a coordinator dies, Ctrl-C: a sentence or an end, and nothing is left behind or hangs."""

import gc
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
from heavylift.coordinator.supervision import Processes
from heavylift.coordinator.transport import Hub, RunDirectory
from heavylift.kernel import ProtocolError
from of_the_system import PATIENCE_s, Start, gone, running

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="watches processes in /proc, which only Linux has")

COORDINATOR = """
from heavylift.coordinator.transport.hub import Hub
from heavylift.coordinator.supervision.processes import Processes
with Processes(["echo_node"]) as processes, Hub(["west", "east"], directory=processes.directory) as hub:
    processes.start(hub, {node: ("echo_node",) for node in hub.nodes})
    hub.receive(60), hub.receive(60)
    print(hub.directory.path, processes._keeper.pid, *processes.pids.values(), flush=True)
    hub.receive()
"""


def sentence(hub: Hub) -> str:
    with pytest.raises(ProtocolError) as error:
        hub.receive(PATIENCE_s)
    return str(error.value)


def test_a_killed_node_is_named_with_its_signal_and_the_simulation_time(start: Start) -> None:
    hub, processes = start(west=(), east=())
    hub.when = lambda: "t = 12.5 s"
    os.kill(processes.pids["west"], signal.SIGKILL)
    assert sentence(hub) == (
        "node west is gone at t = 12.5 s: its process was ended by signal 9 (SIGKILL); start the run again"
    )
    assert "node west is gone" in sentence(hub)  # and again, whoever asks


def test_the_error_for_an_exception_in_a_node_ends_with_the_last_line_of_the_traceback(start: Start) -> None:
    hub, processes = start(west=(), east=())
    hub.send("east", b"raise")
    assert sentence(hub) == (
        "node east is gone: its process ended with exit code 1 and last wrote "
        '"RuntimeError: a rope was pushed"; start the run again'
    )
    assert "Traceback" in processes.output("east")


def test_a_node_process_that_ends_before_joining_is_reported_by_name(start: Start) -> None:
    hub, _ = start(hello=False, west=(), east=("raise-early",))
    with pytest.raises(ProtocolError, match='exit code 1 and last wrote "ValueError: the model has no mass"'):
        hub.send("east", b"x")


def test_messages_sent_before_the_end_of_a_process_arrive_before_its_loss_is_reported(start: Start) -> None:
    hub, _ = start(hello=False, west=("say-and-die",))
    assert hub.receive(PATIENCE_s) == ("west", b"hello")
    assert hub.receive(PATIENCE_s) == ("west", b"my last words")
    assert "node west is gone: its process ended with exit code 3" in sentence(hub)


def test_a_coordinator_reports_a_process_that_ended_while_the_coordinator_was_computing(start: Start) -> None:
    hub, processes = start(west=())
    os.kill(processes.pids["west"], signal.SIGSEGV)
    time.sleep(0.5)
    assert "signal 11 (SIGSEGV)" in sentence(hub)


def test_a_run_that_ends_without_failure_leaves_no_process_or_temporary_file_behind(start: Start) -> None:
    hub, processes = start(west=(), east=())
    hub.dismiss(b"stop")
    processes.end()
    hub.close()
    assert not any(running(pid) for pid in (*processes.pids.values(), processes._keeper.pid))
    assert not hub.directory.path.exists()
    assert processes._exits == {"west": 0, "east": 0}


@pytest.mark.parametrize("state", ["deaf", "stopped"])
def test_a_node_process_that_does_not_end_after_the_run_is_killed(start: Start, state: str) -> None:
    hub, processes = start(west=("deaf",) if state == "deaf" else ())
    if state == "stopped":
        os.kill(processes.pids["west"], signal.SIGSTOP)
    hub.dismiss(b"stop")
    processes.end()
    hub.close()
    assert not running(processes.pids["west"])


def launch() -> tuple["subprocess.Popen[str]", Path, list[int]]:
    """A coordinator in a process of its own, its run directory, and the ids of its keeper and nodes."""
    coordinator = subprocess.Popen(
        [sys.executable, "-c", COORDINATOR],
        env={**os.environ, "PYTHONPATH": os.path.dirname(__file__)},
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        process_group=0,
    )
    assert coordinator.stdout is not None
    directory, *pids = coordinator.stdout.readline().split()
    return coordinator, Path(directory), [int(pid) for pid in pids]


def vanished(directory: Path) -> bool:
    """Whether a directory goes."""
    deadline = time.monotonic() + PATIENCE_s
    while directory.exists() and time.monotonic() < deadline:
        time.sleep(0.01)
    return not directory.exists()


def test_all_processes_of_a_run_end_when_its_coordinator_is_killed() -> None:
    coordinator, directory, pids = launch()
    assert all(running(pid) for pid in pids)
    coordinator.kill()
    coordinator.wait()
    assert gone(*pids)
    assert vanished(directory)


@pytest.mark.parametrize("before", ["stopped", "dead"])
@pytest.mark.parametrize("whom", ["keeper", "nodes", "all"])
def test_a_process_ends_with_its_coordinator_even_without_a_notification(before: str, whom: str) -> None:
    coordinator, directory, (keeper, *nodes) = launch()
    number = signal.SIGSTOP if before == "stopped" else signal.SIGKILL
    os.kill(coordinator.pid, signal.SIGSTOP)  # it must not replace anybody
    for pid in {"keeper": [keeper], "nodes": nodes, "all": [keeper, *nodes]}[whom]:
        os.kill(pid, number)
    coordinator.kill()
    coordinator.wait()
    assert gone(keeper, *nodes)
    if (before, whom) == ("dead", "all"):  # nobody was left who could
        assert directory.exists()
        RunDirectory.chosen().make().remove()  # but the next run does
    assert vanished(directory)


def test_ctrl_c_interrupts_a_coordinator_that_waits_for_messages() -> None:
    coordinator, directory, pids = launch()
    os.killpg(coordinator.pid, signal.SIGINT)
    _, errors = coordinator.communicate(timeout=PATIENCE_s)
    assert errors.count("KeyboardInterrupt") == 1
    assert not any(running(pid) for pid in pids)
    assert not directory.exists()


def test_without_a_process_manager_the_nodes_continue_and_a_lost_node_is_reported_by_name(start: Start) -> None:
    hub, processes = start(west=(), east=())
    processes._keeper.kill()
    hub.send("west", b"still here")
    assert hub.receive(PATIENCE_s) == ("west", b"still here")
    os.kill(processes.pids["west"], signal.SIGKILL)
    assert sentence(hub) == (
        "node west is gone: its process is gone, since the process manager was lost: it was ended by signal 9 "
        "(SIGKILL); start the run again"
    )
    processes.end()
    assert gone(*processes.pids.values())


def test_a_process_manager_that_cannot_start_reports_why() -> None:
    with Processes(["no_such_module"]) as processes, Hub(["west"], directory=processes.directory) as hub:
        processes.start(hub, {"west": ("echo_node",)})
        assert "it ended with exit code 1 and last wrote \"ModuleNotFoundError: No module named 'no_s" in sentence(hub)


def test_a_stopped_process_manager_does_not_delay_the_end(start: Start) -> None:
    hub, processes = start(**{f"node{number}": () for number in range(3)})
    os.kill(processes._keeper.pid, signal.SIGSTOP)
    processes._order(do="signal", signal=0, name="x" * 200_000)  # more than its pipe holds
    hub.dismiss(b"stop")
    hub.close()
    processes.end()
    assert gone(processes._keeper.pid, *processes.pids.values())
    assert not processes.directory.path.exists()


def test_twelve_node_processes_start_and_answer_and_end() -> None:
    nodes = [f"node{number}" for number in range(12)]
    with Processes(["echo_node"]) as processes, Hub(nodes, directory=processes.directory) as hub:
        processes.start(hub, {node: ("echo_node",) for node in nodes})
        assert {hub.receive(PATIENCE_s) for _ in nodes} == {(node, b"hello") for node in nodes}
        hub.dismiss(b"stop")
        processes.end()


def test_the_directory_of_a_run_whose_coordinator_is_gone_is_removed() -> None:
    """A signal may arrive between its making and whoever removes it."""
    path = RunDirectory.chosen().make().path
    gc.collect()
    assert not path.exists()
