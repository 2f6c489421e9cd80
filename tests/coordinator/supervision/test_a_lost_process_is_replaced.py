"""Processes are killed at any point of a run, one or many of them, and the run is the same to the last byte."""

from __future__ import annotations

import os
import random
import re
import signal
import sys
import threading
import time
from pathlib import Path

import pytest
from heavylift.coordinator.run import ModelRun, run_models
from heavylift.coordinator.supervision import Processes
from heavylift.kernel import ProtocolError
from trouble import MODELS, Troubled, both, keeper, pid, play, strike

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="watches processes in /proc, which only Linux has")

MESSAGES = 126  # of the undisturbed run: three WELCOMEs, 120 GRANTs, three STOPs


@pytest.fixture(scope="module")
def undisturbed_run() -> ModelRun:
    """In this process."""
    return run_models(f"{MODELS}:build", in_process=True)


@pytest.fixture(scope="module")
def digest(undisturbed_run: ModelRun) -> str:
    """Of the undisturbed run."""
    return undisturbed_run.digest


def replaced(notes: list[str]) -> list[str]:
    return [note.split()[1] for note in notes if " is replaced" in note]


@pytest.mark.parametrize("seed", range(3))
def test_processes_killed_at_random_times_are_replaced(digest: str, seed: int) -> None:
    rng = random.Random(seed)
    points = rng.sample(range(1, MESSAGES + 1), 8)
    victims = {point: rng.choice(["north", "east", "south"]) for point in points}
    run, notes = play({point: strike(victim) for point, victim in victims.items()})
    assert (run.digest, run.grants) == (digest, 120)
    assert replaced(notes)


@pytest.mark.parametrize(("point", "what"), [(1, "the start"), (4, "the first grant"), (MESSAGES, "the last message")])
def test_processes_killed_at_the_start_and_end_of_a_run_are_replaced(digest: str, point: int, what: str) -> None:
    run, notes = play({point: strike("north", "east", "south")})
    assert run.digest == digest
    assert len(set(replaced(notes))) >= 2 or point == MESSAGES  # who has said all that it had to say may die


def test_a_message_about_a_lost_process_states_the_node_and_the_time_and_the_cause(digest: str) -> None:
    run, notes = play({60: strike("east", number=signal.SIGSEGV)})
    assert re.fullmatch(
        r"node east is replaced at t = 0\.1\d\d s: its process was ended by signal 11 \(SIGSEGV\)", *notes
    )
    assert run.digest == digest


def test_two_node_processes_lost_at_the_same_time_are_both_replaced(digest: str) -> None:
    run, notes = play({50: strike("north", "south")})
    assert (run.digest, sorted(replaced(notes))) == (digest, ["north", "south"])


def test_a_replacement_process_that_is_killed_during_its_replay_is_replaced_again(digest: str) -> None:
    message: list[int] = []

    def twice(hub: Troubled) -> None:
        strike("east")(hub)
        first = pid(hub, "east")
        say = hub._report

        def and_again(node: str, life: object, payload: bytes) -> None:
            say(node, life, payload)
            message.append(1)
            if node == "east" and len(message) == 10 and pid(hub, "east") != first:
                strike("east")(hub)

        hub._report = and_again  # type: ignore[method-assign]

    run, notes = play({100: twice})  # type: ignore[dict-item]
    assert (run.digest, replaced(notes)) == (digest, ["east", "east"])


KEPT = r"its process is gone, since the process manager was lost: "
KILLED = r"it was ended by signal 9 \(SIGKILL\)"
STOPPED = r"its process \d+ is stopped \(SIGSTOP\) and was not continued within 1 s"


@pytest.mark.parametrize("point", [70, MESSAGES], ids=["run", "exit"])
@pytest.mark.parametrize("number", [signal.SIGKILL, signal.SIGSTOP], ids=["killed", "stopped"])
@pytest.mark.large(beyond=3)
def test_the_loss_of_the_process_manager_when_no_longer_needed_does_not_change_the_digest(
    digest: str, point: int, number: int
) -> None:
    run, notes = play({point: keeper(number)}, deadline=1.0)
    assert (run.digest, notes) == (digest, [])


@pytest.mark.parametrize("point", [1, 3, 70, MESSAGES], ids=["start", "all welcomed", "run", "exit"])
@pytest.mark.parametrize(("number", "how"), [(signal.SIGKILL, KILLED), (signal.SIGSTOP, STOPPED)])
@pytest.mark.large(beyond=5)
def test_a_lost_process_manager_is_replaced_when_a_process_must_be_started(
    digest: str, point: int, number: int, how: str
) -> None:
    run, notes = play({point: both(strike("south"), keeper(number))}, deadline=1.0)
    assert run.digest == digest
    message = [note.split(": ", 1)[1] for note in notes]
    slow = r"its process has (not said|done no step) for 1 s.*"  # on a loaded machine
    told_so = rf"{KEPT}{how}|it left the run|its process (was ended by|has ended, and) .*|{slow}"
    assert [each for each in message if not re.fullmatch(told_so, each)] == []
    if point == 70:
        assert set(replaced(notes)) == {"east", "north", "south"}


def test_a_stopped_process_manager_that_continues_before_the_deadline_is_not_replaced(digest: str) -> None:
    def soon(hub: Troubled) -> None:
        threading.Timer(0.3, keeper(signal.SIGCONT), (hub,)).start()

    run, notes = play({70: both(strike("south"), keeper(signal.SIGSTOP), soon)}, deadline=30.0)  # type: ignore[arg-type]
    assert (run.digest, replaced(notes)) == (digest, ["south"])


def test_a_run_ends_with_an_error_if_its_process_manager_is_lost_repeatedly() -> None:
    with pytest.MonkeyPatch.context() as patch:
        original = Processes._launch

        def doomed(crew: Processes) -> None:
            original(crew)
            crew._keeper.kill()

        patch.setattr(Processes, "_launch", doomed)
        with pytest.raises(ProtocolError) as message:
            play({})
    assert re.fullmatch(
        rf"node \w+ is gone.*: {KEPT}{KILLED}; 3 successive processes were lost "
        "at the same point of the run; start the run again",
        str(message.value),
    )


def test_after_a_checkpoint_a_replacement_process_replays_fewer_messages(digest: str) -> None:
    undisturbed = MESSAGES
    run, _ = play({120: strike("south")})
    assert run.digest == digest
    whole = Troubled.last.said - undisturbed
    run, _ = play({120: strike("south")}, KEEP_s=0.0, KEEP_GRANTS=5)
    assert run.digest == digest
    assert whole > 35  # some forty GRANTs
    assert Troubled.last.said - undisturbed <= 2 + 5  # WELCOME, CHECKPOINT, and at most five GRANTs
    run, notes = play({n: strike("south", "east") for n in (30, 60, 90, 120)}, KEEP_s=0.0, KEEP_GRANTS=1)
    assert (run.digest, len(notes)) == (digest, 8)


def test_a_node_whose_process_is_lost_at_the_end_of_the_run_still_reports_its_results(
    undisturbed_run: ModelRun,
) -> None:
    for points in ((30, 60), range(MESSAGES - 2, MESSAGES + 1)):
        run, _ = play({point: strike("south", "east") for point in points})
        assert (run.results, len(run.results)) == (undisturbed_run.results, 3)


def test_a_process_of_several_nodes_is_replaced_with_all_of_them(undisturbed_run: ModelRun, digest: str) -> None:
    run, notes = play({40: strike("yard")}, places=["north,east=yard"])
    assert (run.digest, run.results) == (digest, undisturbed_run.results)
    assert [note.split(" at t")[0] for note in notes] == ["nodes north, east (process yard) are replaced"]
    strikes = {n: strike("yard") for n in (12, 24, 40)}
    run, notes = play(strikes, places=["north,east=yard"], KEEP_s=0.0, KEEP_GRANTS=1)
    assert (run.digest, len(notes)) == (digest, 3), "from checkpoints, too"


def test_a_run_with_replaced_processes_leaves_no_temporary_file_or_process_behind() -> None:
    _, notes = play({30: strike("north"), 60: strike("east")})
    hub = Troubled.last
    assert len(notes) == 2
    assert not hub.directory.path.exists()
    time.sleep(0.05)
    assert not any(Path(f"/proc/{pid}").exists() for pid in hub._crew.pids.values() if pid != os.getpid())
