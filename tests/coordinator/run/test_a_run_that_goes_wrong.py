"""Whatever stops a run ends in one sentence, a finished recording, no process left and an exit code that is not 0."""

import os
import re
import signal
import subprocess
import sys
import time
from contextlib import suppress
from pathlib import Path

import pytest
from command import HEAVYLIFT, PATIENCE_s, all_of_node, descendants, finish, gone, start, until
from heavylift.nodes.scene import bundled
from heavylift.recordings import Recording


def test_ctrl_c_completes_the_recording_and_ends_all_processes(tmp_path):
    run = start(tmp_path, "run", "turnover", "--rate", "100")
    until(run, "load")
    processes = descendants(run.pid)
    assert len(processes) == 12  # the keeper, ten models, the kernel
    run.send_signal(signal.SIGINT)
    _, error = run.communicate(timeout=PATIENCE_s)
    assert run.returncode == 130
    assert error.splitlines()[-1].startswith("heavylift: stopped by the user at ")
    assert gone(processes)
    recording = Recording(tmp_path / "turnover.mcap")
    assert recording.result["status"] == "failed"
    assert [e.value["name"] for e in recording.events("commander", "stage")][:2] == ["take up slack", "load"]


IMPATIENT = """
import sys

class CtrlC:
    def find_spec(self, name, path, target=None):
        if name == "typer":
            raise KeyboardInterrupt

sys.meta_path.insert(0, CtrlC())
from heavylift.coordinator.cli import main
main()
"""


def test_ctrl_c_during_start_up_ends_with_a_one_sentence_error():
    done = subprocess.run([sys.executable, "-c", IMPATIENT], capture_output=True, text=True, timeout=PATIENCE_s)
    assert (done.returncode, done.stderr) == (130, "heavylift: stopped\n")


@pytest.mark.large
def test_a_node_whose_replacement_processes_are_all_killed_is_reported_by_name(tmp_path):
    run = start(tmp_path, "run", "turnover")
    until(run, "load")
    while run.poll() is None:
        for pid in all_of_node(descendants(run.pid), "loader-4"):
            with suppress(ProcessLookupError):
                os.kill(pid, signal.SIGKILL)
        time.sleep(0.001)
    *_, sentence = run.communicate()[1].splitlines()
    assert run.returncode == 1
    assert re.match(r"heavylift: node loader-4 is gone at t = \d+\.\d{3} s: its process was ended by", sentence)
    assert "signal 9 (SIGKILL); 3 successive processes were lost at the same point" in sentence
    assert Recording(tmp_path / "turnover.mcap").result["status"] == "failed"


MISTAKE = """\
from heavylift.nodes.models.parts.rigging import BlockSupports

def notice(self, event):
    return self.closed_ / 0

BlockSupports.notice = notice
"""


@pytest.mark.parametrize("where", [[], ["--in-process"]], ids=["processes", "one process"])
@pytest.mark.large(beyond=1)
def test_an_error_in_model_code_is_reported_with_the_path_of_the_model_and_the_time(tmp_path, where):
    """Python imports `sitecustomize` before anything else: the supports of every process have the mistake."""
    (tmp_path / "mistake").mkdir()
    (tmp_path / "mistake" / "sitecustomize.py").write_text(MISTAKE)
    code, _, error = finish(tmp_path, "run", "lift", *where, PYTHONPATH=str(tmp_path / "mistake"))
    assert code == 1
    assert "Traceback" not in error
    text = [line for line in error.splitlines() if line.startswith("heavylift: ")]
    assert text == error.splitlines()[-1:]
    found = re.fullmatch(r"heavylift: block\.block-body\.supports at \((\S+) s, 0\): (.*)", text[0])
    assert found, text
    wrong = "external() raised AttributeError: 'BlockSupports' object has no attribute 'closed_'"
    assert found[2] == f"{wrong} (sitecustomize.py:4)"
    assert 9.0 < float(found[1]) < 30.0  # the first support opens during lift-off
    result = Recording(tmp_path / "lift.mcap").result
    assert result["status"] == "failed"
    assert text[0] == f"heavylift: {result['reason']}"


def test_no_node_outlives_a_killed_coordinator(tmp_path):
    run = start(tmp_path, "run", "turnover")
    until(run, "load")
    processes = descendants(run.pid)
    run.kill()
    assert gone(processes)
    run.communicate()


@pytest.mark.large
def test_a_second_run_cannot_overwrite_a_recording_in_progress_and_the_first_run_continues(tmp_path):
    first = start(tmp_path, "run", "turnover", "-o", "both.mcap")
    until(first, "take up slack")
    code, _, error = finish(tmp_path, "run", "lift", "-o", "both.mcap", "--force")
    assert code == 2
    assert error == (
        "heavylift: both.mcap.part: another run is writing this file; wait for it or choose another name with -o\n"
    )
    assert first.poll() is None
    first.send_signal(signal.SIGINT)
    first.communicate()


def test_an_order_that_a_model_cannot_carry_out_is_reported_with_its_line_in_the_scene(tmp_path):
    again = "  - stage: again\n    all hooks: hook\n  - stage: up"
    text = bundled()["lift"].read_text().replace("  - stage: up", again)
    (tmp_path / "twice.yaml").write_text(text)
    code, _, error = finish(tmp_path, "run", "twice.yaml")
    assert code == 1
    assert "twice.yaml:" in error
    assert "Traceback" not in error


def test_a_run_whose_condition_never_holds_ends_with_an_error_that_names_the_condition(tmp_path):
    (tmp_path / "never.yaml").write_text(
        """heavylift: 1
name: never
mechanism:
  bodies:
    load: {mass: 1 t}
  joints:
    slide: {type: prismatic, child: load, axis: [0, 0, 1]}
  ropes:
    rope: {start: {body: world, at: [0 m, 0 m, 10 m]}, end: {body: load}, EA: 1 MN, length: 9.9 m, damping: 30 kN s/m}
actions:
  - stage: wait for what never comes
    when: all ropes slack
    wait: 1 s
"""
    )
    code, message, error = finish(tmp_path, "run", "never.yaml")
    assert code == 1
    assert error.splitlines()[-1].startswith("heavylift: still waiting for all ropes slack (rope is taut) since 0 s")
    first = message.splitlines()[0]
    assert first.startswith("verdict: RED: ")
    assert first.endswith("; worst: the run did not reach its end")


def no_folder(tmp_path):
    return "no/such/folder"


def a_file_in_the_way(tmp_path):
    (tmp_path / "results").write_text("a file")
    return "results"


def no_permission(tmp_path):
    if os.geteuid() == 0:
        pytest.skip("root may write everywhere")
    (tmp_path / "locked").mkdir(mode=0o555)
    return "locked"


@pytest.mark.parametrize("obstacle", [no_folder, a_file_in_the_way, no_permission])
def test_output_files_that_cannot_be_written_are_named_before_the_run(tmp_path, obstacle):
    folder = obstacle(tmp_path)
    before = sorted(tmp_path.rglob("*"))
    code, out, error = finish(tmp_path, "run", "pendulum", "-o", f"{folder}/x.mcap")
    assert (code, out, error.count("\n")) == (1, "", 1)
    assert error.startswith("heavylift: ")
    assert folder in error
    assert sorted(tmp_path.rglob("*")) == before


def test_the_error_for_a_misspelt_scene_name_suggests_the_right_name(tmp_path):
    code, _, error = finish(tmp_path, "run", "turnovr")
    assert code == 1
    assert "turnover" in error


def test_an_invalid_command_line_is_reported_in_one_sentence(tmp_path):
    code, _, error = finish(tmp_path, "rum", "turnover")
    assert code == 2
    assert error.startswith("heavylift: No such command 'rum'")


@pytest.mark.parametrize("arguments", [["doctor", "--help"], ["--help"]])
def test_a_full_disk_is_reported_in_one_sentence_if_the_output_of_a_command_is_redirected_to_it(tmp_path, arguments):
    with Path("/dev/full").open("w") as full:
        done = subprocess.run([HEAVYLIFT, *arguments], cwd=tmp_path, stdout=full, stderr=subprocess.PIPE, text=True)
    assert done.returncode == 1
    assert done.stderr == (
        "heavylift: standard output cannot be written (No space left on device); make room there or send it elsewhere\n"
    )


def test_closing_the_output_pipe_of_a_command_after_some_output_is_not_an_error(tmp_path):
    process = start(tmp_path, "--help")
    process.stdout.close()
    assert process.stderr.read() == ""
    assert process.wait(PATIENCE_s) == 141
