"""`heavylift command` ends with what the commander answers: begun, with the time, or refused, with exit code 1."""

import json
import signal
import subprocess
from pathlib import Path

import pytest
from heavylift.coordinator.live import RunOrder, order
from running import HEAVYLIFT, PATIENCE_s, command, found, going, said
from sledge import SLEDGE

WORDS = "pusher: drive 6 m/min by 50 mm"
BUSY = "pusher gets an order while its drive (sledge.yaml:13:5) is not done; wait for `moves done` or end that order"


def first_line(process: subprocess.Popen[str]) -> str:
    assert process.stderr is not None
    return process.stderr.readline()


def test_an_operator_command_to_a_paused_run_is_answered_after_the_run_continues(tmp_path: Path) -> None:
    """The pusher is busy for three seconds, then the run rests for an hour."""
    (tmp_path / "sledge.yaml").write_text(SLEDGE.replace("wait: 2 s", "wait: 1 h"))
    with going(tmp_path, "run", "sledge.yaml", "--rate", "5"):
        run = found(tmp_path / "sledge.mcap")
        at = order(run, RunOrder("pause")).removeprefix("paused at ")
        message = f"the run is paused at {at}; the command takes effect there when the run continues\n"

        code, out, errors = said(tmp_path, "command", "sledge.mcap", WORDS, "--wait", "0.2 s")
        assert (code, out) == (1, "")
        assert errors == f"{message}heavylift: {WORDS}: no answer within 0.2 s: {message}"

        code, out, errors = said(tmp_path, "command", "sledge.mcap", WORDS, "--wait", "0")
        assert (code, errors) == (0, "")
        assert out.endswith(" s, when the run continues\n")

        with command(tmp_path, "command", "sledge.mcap", WORDS, "--json") as waiting:
            assert first_line(waiting).startswith("the run is paused at ")
            assert order(run, RunOrder("step", by_ns=10**9)).startswith("paused at ")
            out, errors = waiting.communicate(timeout=PATIENCE_s)
        assert waiting.returncode == 1
        answer = json.loads(out)
        assert answer["done"] is False
        assert answer["t_s"] == pytest.approx(float(at.removesuffix(" s")), abs=1e-8)
        assert f"refused: command: {BUSY}" in answer["said"]
        assert errors == f"heavylift: {answer['said']}\n"

        assert order(run, RunOrder("step", by_ns=4 * 10**9)).startswith("paused at ")
        with command(tmp_path, "command", "sledge.mcap", WORDS) as waiting:
            assert first_line(waiting).startswith("the run is paused at ")
            order(run, RunOrder("continue"))
            out, errors = waiting.communicate(timeout=PATIENCE_s)
        assert (waiting.returncode, errors) == (0, "")
        assert out.startswith(f"{WORDS}: began at ")


def test_an_operator_command_is_answered_even_if_the_run_ends_before_the_command_takes_effect(tmp_path: Path) -> None:
    (tmp_path / "sledge.yaml").write_text(SLEDGE.replace("wait: 2 s", "wait: 1 h"))
    with going(tmp_path, "run", "sledge.yaml", "--rate", "5") as process:
        run = found(tmp_path / "sledge.mcap")
        order(run, RunOrder("pause"))
        with command(tmp_path, "command", "sledge.mcap", WORDS) as waiting:
            assert first_line(waiting).startswith("the run is paused at ")
            process.send_signal(signal.SIGINT)
            _, errors = waiting.communicate(timeout=PATIENCE_s)
        assert waiting.returncode == 1
        assert errors == "heavylift: the run has ended\n"


@pytest.mark.parametrize("wait", ["3 kg", "-1 s"])
def test_an_invalid_waiting_time_for_the_answer_to_an_operator_command_is_refused(tmp_path: Path, wait: str) -> None:
    called = [HEAVYLIFT, "command", "x.mcap", WORDS, f"--wait={wait}"]
    done = subprocess.run(called, cwd=tmp_path, capture_output=True, text=True, timeout=PATIENCE_s)
    assert (done.returncode, done.stderr.count("\n")) == (1, 1)
    assert done.stderr.startswith("heavylift: --wait")
