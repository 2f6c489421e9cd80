"""What a successor is reported: all that has been answered, in order, or a checkpoint in place of what was before
it."""

from __future__ import annotations

from pathlib import Path

import pytest
from heavylift.coordinator.supervision import ReplayLog


@pytest.fixture
def log(tmp_path: Path) -> ReplayLog:
    log = ReplayLog(tmp_path / "west.journal")
    log.sent(b"WELCOME")
    log.answered(b"HELLO")
    return log


def say(log: ReplayLog, *numbers: int) -> None:
    for n in numbers:
        log.sent(b"GRANT %d" % n)
        log.answered(b"DONE %d" % n)


def pairs(*numbers: int) -> list[tuple[bytes, bytes]]:
    return [(b"GRANT %d" % n, b"DONE %d" % n) for n in numbers]


GREETING = (b"WELCOME", b"HELLO")


def test_a_node_that_never_received_a_welcome_has_no_replay_log(tmp_path: Path) -> None:
    log = ReplayLog(tmp_path / "west.journal")
    assert list(log.retell()) == []
    log.sent(b"WELCOME")
    assert list(log.retell()) == []
    assert (log.last, log.open) == (b"WELCOME", True)


def test_the_replay_log_repeats_all_answered_messages(log: ReplayLog) -> None:
    say(log, 1, 2, 3)
    assert list(log.retell()) == [GREETING, *pairs(1, 2, 3)]
    assert not log.open


def test_the_replay_log_sends_pending_messages_after_the_answered_ones(log: ReplayLog) -> None:
    say(log, 1, 2)
    log.sent(b"GRANT 3")
    assert list(log.retell()) == [GREETING, *pairs(1, 2)]
    assert (log.last, log.open) == (b"GRANT 3", True)


def test_a_checkpoint_of_a_node_replaces_all_earlier_messages_in_its_replay_log(log: ReplayLog) -> None:
    say(log, 1, 2)
    log.kept(b"CHECKPOINT 2")
    assert list(log.retell()) == [GREETING, (b"CHECKPOINT 2", b"DONE 2")]
    say(log, 3)
    assert list(log.retell()) == [GREETING, (b"CHECKPOINT 2", b"DONE 2"), *pairs(3)]


def test_a_checkpoint_that_arrives_while_a_message_is_unanswered_leaves_this_message_in_the_replay_log(
    log: ReplayLog,
) -> None:
    say(log, 1, 2)
    log.sent(b"GRANT 3")
    log.kept(b"CHECKPOINT 2")
    assert list(log.retell()) == [GREETING, (b"CHECKPOINT 2", b"DONE 2")]
    log.answered(b"DONE 3")
    say(log, 4)
    assert list(log.retell()) == [GREETING, (b"CHECKPOINT 2", b"DONE 2"), *pairs(3, 4)]


@pytest.mark.parametrize("heard", range(5))
def test_a_message_that_is_sent_to_a_node_during_the_replay_of_its_log_is_not_replayed(
    log: ReplayLog, heard: int
) -> None:
    say(log, 1, 2, 3)
    message = log.retell()
    before = [next(message) for _ in range(heard)]
    log.sent(b"GRANT 4")
    assert [*before, *message] == [GREETING, *pairs(1, 2, 3)]
    assert (log.last, log.open) == (b"GRANT 4", True)


def test_the_replay_log_of_a_node_is_deleted_at_the_end_of_the_run(log: ReplayLog, tmp_path: Path) -> None:
    say(log, 1)
    log.close()
    assert list(tmp_path.iterdir()) == []
