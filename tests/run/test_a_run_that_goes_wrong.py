"""Whatever stops a run ends in one sentence, a finished recording, no process left and an exit code that is not 0."""

import os
import signal

from command import descendants, finish, gone, start, until
from heavylift.nodes.scene import bundled
from heavylift.recordings import Recording

SENTENCE_WITHIN_s = 2.0


def test_ctrl_c_finishes_the_recording_and_takes_all_processes_along(tmp_path):
    run = start(tmp_path, "run", "turnover")
    until(run, "travel")
    processes = descendants(run.pid)
    assert len(processes) == 12  # the keeper, ten models, the kernel
    run.send_signal(signal.SIGINT)
    _, error = run.communicate(timeout=SENTENCE_WITHIN_s)
    assert run.returncode == 130
    assert error.splitlines()[-1].startswith("heavylift: stopped by the user at ")
    assert gone(processes)
    recording = Recording(tmp_path / "turnover.mcap")
    assert recording.result["status"] == "failed"
    assert [e.value["name"] for e in recording.events("commander", "stage")][:2] == ["take up slack", "load"]


def test_a_killed_model_is_named(tmp_path):
    run = start(tmp_path, "run", "turnover")
    until(run, "load")
    processes = descendants(run.pid)
    victim = next(p for p in processes if not descendants(p))
    os.kill(victim, signal.SIGKILL)
    _, error = run.communicate(timeout=SENTENCE_WITHIN_s)
    assert run.returncode == 1
    assert "is gone at t = " in error.splitlines()[-1]
    assert "signal 9 (SIGKILL)" in error.splitlines()[-1]
    assert gone(processes)
    assert Recording(tmp_path / "turnover.mcap").result["status"] == "failed"


def test_no_node_outlives_a_killed_coordinator(tmp_path):
    run = start(tmp_path, "run", "turnover")
    until(run, "load")
    processes = descendants(run.pid)
    run.kill()
    assert gone(processes)
    run.communicate()


def test_a_second_run_into_the_same_file_is_refused_and_the_first_goes_on(tmp_path):
    first = start(tmp_path, "run", "turnover", "-o", "both.mcap")
    until(first, "take up slack")
    code, _, error = finish(tmp_path, "run", "lift", "-o", "both.mcap")
    assert code == 1
    assert error == (
        "heavylift: both.mcap.part: another run is writing this file; wait for it or choose another name with -o\n"
    )
    assert first.poll() is None
    first.send_signal(signal.SIGINT)
    first.communicate()


def test_a_model_that_contradicts_itself_says_where(tmp_path):
    again = "  - stage: again\n    all hooks: hook\n  - stage: up"
    text = bundled()["lift"].read_text().replace("  - stage: up", again)
    (tmp_path / "twice.yaml").write_text(text)
    code, _, error = finish(tmp_path, "run", "twice.yaml")
    assert code == 1
    assert "twice.yaml:" in error
    assert "Traceback" not in error


def test_a_condition_that_never_comes_ends_the_run_with_what_it_waits_for(tmp_path):
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
    code, _, error = finish(tmp_path, "run", "never.yaml")
    assert code == 1
    assert error.splitlines()[-1].startswith("heavylift: still waiting for all ropes slack (rope is taut) since 0 s")


def test_outputs_that_cannot_be_written_are_named_before_anything_runs(tmp_path):
    code, _, error = finish(tmp_path, "run", "pendulum", "-o", "no/such/folder/x.mcap")
    assert (code, error.count("\n")) == (1, 1)
    assert "no/such/folder" in error


def test_a_misspelt_scene_is_answered_with_the_right_name(tmp_path):
    code, _, error = finish(tmp_path, "run", "turnovr")
    assert code == 1
    assert "turnover" in error


def test_a_wrong_command_line_is_one_sentence(tmp_path):
    code, _, error = finish(tmp_path, "rum", "turnover")
    assert code == 2
    assert error.startswith("heavylift: No such command 'rum'")
