"""What a successor is reported: all that has been answered, in order, or a checkpoint in place of what was before
it."""

from __future__ import annotations

from pathlib import Path

import pytest
from heavylift.coordinator.supervision import ReplayLog


@pytest.fixture
def log(tmp_path: Path) -> ReplayLog:
    log = ReplayLog(tmp_path / "west.journal")
    log.message(b"WELCOME")
    log.answered(b"HELLO")
    return log


def say(log: ReplayLog, *numbers: int) -> None:
    for n in numbers:
        log.message(b"GRANT %d" % n)
        log.answered(b"DONE %d" % n)


def pairs(*numbers: int) -> list[tuple[bytes, bytes]]:
    return [(b"GRANT %d" % n, b"DONE %d" % n) for n in numbers]


GREETING = (b"WELCOME", b"HELLO")


def test_who_was_never_greeted_is_reported_nothing(tmp_path: Path) -> None:
    log = ReplayLog(tmp_path / "west.journal")
    assert list(log.retell()) == []
    log.message(b"WELCOME")
    assert list(log.retell()) == []
    assert (log.last, log.open) == (b"WELCOME", True)


def test_all_that_was_answered_is_reported_again(story: ReplayLog) -> None:
    say(story, 1, 2, 3)
    assert list(story.retell()) == [GREETING, *pairs(1, 2, 3)]
    assert not story.open


def test_what_waits_for_an_answer_comes_after_it(story: ReplayLog) -> None:
    say(story, 1, 2)
    story.message(b"GRANT 3")
    assert list(story.retell()) == [GREETING, *pairs(1, 2)]
    assert (story.last, story.open) == (b"GRANT 3", True)


def test_a_checkpoint_takes_the_place_of_what_was_before_it(story: ReplayLog) -> None:
    say(story, 1, 2)
    story.kept(b"CHECKPOINT 2")
    assert list(story.retell()) == [GREETING, (b"CHECKPOINT 2", b"DONE 2")]
    say(story, 3)
    assert list(story.retell()) == [GREETING, (b"CHECKPOINT 2", b"DONE 2"), *pairs(3)]


def test_a_checkpoint_may_come_while_a_message_waits(story: ReplayLog) -> None:
    say(story, 1, 2)
    story.message(b"GRANT 3")
    story.kept(b"CHECKPOINT 2")
    assert list(story.retell()) == [GREETING, (b"CHECKPOINT 2", b"DONE 2")]
    story.answered(b"DONE 3")
    say(story, 4)
    assert list(story.retell()) == [GREETING, (b"CHECKPOINT 2", b"DONE 2"), *pairs(3, 4)]


@pytest.mark.parametrize("heard", range(5))
def test_an_idle_node_may_be_reported_more_while_its_successor_listens(story: ReplayLog, heard: int) -> None:
    say(story, 1, 2, 3)
    message = story.retell()
    before = [next(message) for _ in range(heard)]
    story.message(b"GRANT 4")
    assert [*before, *message] == [GREETING, *pairs(1, 2, 3)]
    assert (story.last, story.open) == (b"GRANT 4", True)


def test_the_end_leaves_no_file(story: ReplayLog, tmp_path: Path) -> None:
    say(story, 1)
    story.close()
    assert list(tmp_path.iterdir()) == []
