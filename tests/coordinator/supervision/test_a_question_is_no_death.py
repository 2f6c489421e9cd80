"""A long step and a process that is stopped for a while are asked about; who gets on may go on."""

from __future__ import annotations

import os
import signal
import sys
import threading

import pytest
from heavylift.coordinator.protocol import Alive
from heavylift.coordinator.run import run_models
from heavylift.coordinator.supervision import StallDetector, Succession, os_limits as vigil
from trouble import MODELS, pid, play, strike

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="watches processes in /proc, which only Linux has")


class Seen:
    """A process that a test makes up."""

    def __init__(self) -> None:
        self.letter, self.sign, self.message = "R", Alive(0), list[str]()
        self.answers = True
        self.vigil = StallDetector(10.0, self, lambda process: self.sign if self.answers else None, self.message.append)

    def pid(self, process: str) -> int:
        return 1234

    def state(self, process: str) -> str:
        return self.letter

    def place(self, process: str) -> str:
        return 'File "crane.py", line 7 in external'

    def at(self, now: float) -> str | None:
        """What is found out at this time of a process that has owed an answer since time 0."""
        return self.vigil.lost("west", 0.0, now)


def test_a_node_receives_no_liveness_query_before_the_deadline_for_its_answer() -> None:
    seen = Seen()
    seen.answers = False
    assert seen.at(9.9) is None
    assert seen.message == []


def test_a_node_that_makes_progress_may_compute_for_longer_than_the_deadline() -> None:
    seen = Seen()
    for n in range(1, 100):
        seen.sign = Alive(n)
        assert seen.at(10.0 * n) == ""


def test_a_node_without_progress_between_two_liveness_queries_counts_as_lost_and_its_line_of_code_is_reported() -> None:
    seen = Seen()
    seen.sign = Alive(5)
    assert seen.at(10.0) == ""
    assert seen.at(15.0) is None
    assert seen.at(20.0) == 'its process has done no step for 10 s, at File "crane.py", line 7 in external'


def test_a_node_has_the_full_deadline_to_answer_each_message() -> None:
    seen = Seen()
    seen.sign = Alive(5)
    assert seen.at(10.0) == ""
    assert seen.vigil.lost("west", 12.0, 20.0) is None
    assert seen.vigil.lost("west", 12.0, 22.0) == ""


def test_a_node_that_does_not_answer_a_liveness_query_counts_as_lost() -> None:
    seen = Seen()
    seen.answers = False
    assert seen.at(10.0) == (
        'its process has not said for 10 s that it is alive, at File "crane.py", line 7 in external'
    )


@pytest.mark.parametrize("held", ["by the system's", "by Python's"])
def test_a_process_held_by_a_debugger_has_no_deadline(held: str) -> None:
    seen = Seen()
    seen.letter, seen.sign = ("t", Alive(5)) if held == "by the system's" else ("R", Alive(5, traced=True))
    assert [seen.at(10.0 * n) for n in range(1, 5)] == [""] * 4
    assert set(seen.message) == {"a debugger holds process west; the run waits for it"}


def test_a_stopped_process_is_reported_early_and_counts_as_lost_at_the_deadline() -> None:
    seen = Seen()
    seen.letter = "T"
    assert seen.at(1.0) is None
    assert seen.message == []
    assert seen.at(3.0) is None
    assert seen.at(4.0) is None
    assert seen.message == ["process 1234 of west is stopped; `kill -CONT 1234`, or it is replaced in 7 s"]
    assert seen.at(10.0) == "its process 1234 is stopped (SIGSTOP) and was not continued within 10 s"


def digest() -> str:
    return run_models(f"{MODELS}:build", in_process=True).digest


def test_a_node_answers_queries_during_a_step_longer_than_the_deadline(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("DOOM", "dawdle")
    run, notes = play({}, "doomed", deadline=0.5)
    assert (run.digest, notes) == (digest(), [])


def test_a_process_that_is_stopped_and_continued_stays_in_the_run(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(vigil, "NOTICE_s", 0.1)

    def rest(hub: Succession) -> None:
        one = pid(hub, "east")
        os.kill(one, signal.SIGSTOP)
        threading.Timer(0.4, os.kill, (one, signal.SIGCONT)).start()

    run, notes = play({60: rest}, deadline=30.0)
    assert run.digest == digest()
    assert [note.split("`")[0] for note in notes] == [notes[0].split("`")[0]]
    assert "of east is stopped; " in notes[0]


def test_a_process_that_stays_stopped_is_replaced() -> None:
    run, notes = play({60: strike("east", number=signal.SIGSTOP)}, deadline=0.3)
    assert run.digest == digest()
    assert len(notes) == 1
    assert "is stopped (SIGSTOP) and was not continued within 0.3 s" in notes[0]
