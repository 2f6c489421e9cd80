"""Whoever sits at the terminal of a run pauses it, steps it, changes its rate and ends it by keys."""

import os
import pty
import subprocess
from pathlib import Path

import pytest
from heavylift.coordinator.live import Pace, RealTime
from heavylift.kernel import ProtocolError
from heavylift.nodes.devs import Tag
from heavylift.recordings import Recording
from running import HEAVYLIFT
from sledge import SLEDGE


def test_keys_pressed_in_the_terminal_pause_and_step_and_stop_the_run(tmp_path: Path) -> None:
    (tmp_path / "sledge.yaml").write_text(SLEDGE.replace("wait: 2 s", "wait: 1 h"))
    here, there = pty.openpty()
    arguments = [HEAVYLIFT, "run", "sledge.yaml", "--rate", "2"]
    with subprocess.Popen(arguments, cwd=tmp_path, stdin=there, stdout=there, stderr=subprocess.PIPE, text=True) as run:
        try:
            assert run.stderr is not None
            text = iter(run.stderr)
            assert "out" in next(text)
            for key, answer in ((b" ", "paused at "), (b"+", "4 x real time"), (b".", "paused at "), (b" ", "goes on")):
                os.write(here, key)
                assert next(line for line in text if "rest" not in line).startswith(answer), key
            os.write(here, b"q")
            assert any(line.startswith("ends at ") for line in text)
            assert run.wait() == 0
        finally:
            run.kill()
            os.close(here)
            os.close(there)
    recording = Recording(tmp_path / "sledge.mcap")
    assert [event.value["text"] for event in recording.events("operator")] == ["stop"]


def test_after_a_change_of_rate_the_clock_of_a_run_continues_from_the_present_time() -> None:
    wall = 0.0
    pace = RealTime(2.0, lambda: wall)
    assert pace.horizon(Tag(0)).t == 0
    wall = 3.0
    assert pace.change(0.5) == 1.0
    assert pace.horizon(Tag(0)).t == 6 * 10**9
    wall = 5.0
    assert pace.horizon(Tag(0)).t == 8 * 10**9


def test_the_rate_of_a_run_that_does_not_follow_the_clock_cannot_be_changed() -> None:
    with pytest.raises(ProtocolError, match="start it with --rate"):
        Pace().change(2.0)
