"""Runs in this process, one after the other or one within another: memory, files and threads do not add up."""

from __future__ import annotations

import gc
import os
import threading
import time
from collections.abc import Callable
from pathlib import Path

import pytest
from heavylift.coordinator.transport import Hub, LocalHub, RunDirectory

RUNS = 30
ENDING_s = 10.0  # in which threads of the bus end on a busy machine
EACH_kB = 40  # what a run may leave in the allocator's pools; a session that is closed as it is leaves 60 to 110


def talk(hub: LocalHub) -> bytes:
    link = hub.link("a")
    link.serve(lambda data: link.send(data + b" heard"))
    hub.publish_event("a", "port", b"event")
    hub.send("a", b"word")
    got = hub.receive()
    assert got is not None
    return got[1]


def local() -> None:
    with LocalHub(["a", "b", "c", "d"]) as hub:
        assert talk(hub) == b"word heard"
    hub.close()  # a second time


def apart() -> None:
    with Hub(["a", "b", "c", "d"]) as hub:
        hub.serve("control", lambda query: None)
        hub.publish_event("a", "port", b"event")
    hub.close()


def left() -> tuple[int, int, int]:
    """Resident set [kB], open files, threads of this process."""
    gc.collect()
    lines = Path("/proc/self/status").read_text().splitlines()
    resident = next(int(line.split()[1]) for line in lines if line.startswith("VmRSS"))
    return resident, len(os.listdir("/proc/self/fd")), len(os.listdir("/proc/self/task"))


@pytest.mark.parametrize("run", [local, apart])
@pytest.mark.large(beyond=1)
def test_repeated_runs_in_one_process_leave_no_threads_files_or_memory_behind(run: Callable[[], None]) -> None:
    for _ in range(RUNS):
        run()
    before = left()
    for _ in range(RUNS):
        run()
    deadline = time.monotonic() + ENDING_s
    while (after := left())[1:] > before[1:] and time.monotonic() < deadline:
        time.sleep(0.1)
    assert (after[1] <= before[1], after[2] <= before[2]) == (True, True), (before, after)
    assert after[0] - before[0] < EACH_kB * RUNS


def test_two_runs_at_the_same_time_in_one_process_have_separate_sessions() -> None:
    with LocalHub(["a"]) as one, LocalHub(["a"]) as other:
        assert one._session is not other._session
        assert [talk(hub) for hub in (one, other)] == [b"word heard"] * 2


def test_a_new_run_removes_the_temporary_files_of_runs_that_were_killed(tmp_path: Path) -> None:
    left = {"0": [], "1": ["users"], "2": ["users", "operator", "hub.sock"], "3": ["hub.sock", "west.log"]}
    stays = {"a": ["thesis.txt"], "b": ["users", "thesis.txt"]}
    for last, names in (left | stays).items():
        (tmp_path / f"heavylift-0000000{last}").mkdir()
        for name in names:
            (tmp_path / f"heavylift-0000000{last}" / name).touch()
    (tmp_path / "heavylift-0000000c").symlink_to(tmp_path / "heavylift-0000000a")
    (tmp_path / "heavylift-0000000d").touch()
    living = RunDirectory(tmp_path / "heavylift-0000000e").make()
    new = RunDirectory(tmp_path / "heavylift-0000000f").make()
    assert {path.name[-1] for path in tmp_path.iterdir()} == {*"abcdef"}
    for directory in (living, new):
        directory.remove()
    assert {path.name[-1] for path in tmp_path.iterdir()} == {*"abcd"}


def test_closing_the_hub_of_a_run_leaves_no_thread_behind() -> None:
    """One that comes out of foreign code while Python ends aborts the process: "exception not rethrown"."""
    before = threading.enumerate()
    for _ in range(RUNS):
        apart()
        assert threading.enumerate() == before
