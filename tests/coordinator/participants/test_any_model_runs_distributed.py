"""A researcher's model, child by child in processes of their own, does what it does alone, log for log."""

import json
import queue
import re
import subprocess
import sys
from pathlib import Path

import pytest
from heavylift import run_models
from heavylift.coordinator.cli import main
from heavylift.coordinator.participants import built
from heavylift.coordinator.protocol import RunEnd
from heavylift.kernel import ModelError
from heavylift.nodes.devs import Simulator, Transition, ms
from heavylift.recordings import Recording
from rings import tokens, work

HERE = Path(__file__).parent
HEAVYLIFT = Path(sys.executable).parent / "heavylift"


def flat(build, until):
    lines: list[Transition] = []
    simulator = Simulator(build(), lines.append)
    simulator.start()
    simulator.run(until)
    return lines


@pytest.mark.parametrize("in_process", [False, True], ids=["processes", "one process"])
@pytest.mark.parametrize("build", [tokens, work])
def test_a_distributed_run_writes_the_same_log_as_the_flat_simulator(build, in_process):
    lines: list[Transition] = []
    run = run_models(build, until=0.101, in_process=in_process, log=lines.append)
    assert lines == flat(build, ms(101))
    assert len(lines) > 20
    assert run.outcome is RunEnd.BOUND


def test_a_devs_run_ends_when_all_its_models_are_passive():
    run = run_models("rings:work", in_process=True)
    assert run.outcome is RunEnd.QUIET
    assert run.sim_s == 0.205  # the job that was taken at 0.18 s


def test_the_recording_of_a_devs_run_contains_all_outputs_of_its_models(tmp_path):
    run = run_models(tokens, until=0.021, output=tmp_path / "ring.mcap", in_process=True)
    recording = Recording(tmp_path / "ring.mcap")
    text = [(e.t_ns, e.source, e.value["number"]) for e in recording.events()]
    sent = [
        (line.tag.t, line.path.split(".")[1], number.number) for line in flat(tokens, ms(21)) for _, number in line.sent
    ]
    assert text == sent
    assert len(text) == 8
    assert recording.result["digest"] == run.digest == run_models(tokens, until=0.021).digest


def command(*arguments, **more):
    return subprocess.run([HEAVYLIFT, "devs", *arguments], capture_output=True, text=True, timeout=60, **more)


def test_the_devs_command_runs_a_module_or_a_file(tmp_path):
    by_module = command("rings:tokens", "--until", "21 ms", "-o", str(tmp_path / "ring.mcap"), cwd=HERE)
    assert by_module.returncode == 0, by_module.stderr
    assert by_module.stdout.splitlines()[0] == "last event at 0.02 s; the time bound is reached"
    by_file = command(str(HERE / "rings.py") + ":tokens", "--until", "21 ms", "--in-process", cwd=tmp_path)
    assert by_file.stdout.splitlines()[2] == by_module.stdout.splitlines()[2] != ""


STUCK = """
import os, time
from heavylift.nodes.devs import Atomic, Coupled

class Stuck(Atomic):
    def start(self): self.hold_in(5)
    def internal(self):
        self.passivate()
        if not os.path.exists("seen"):
            open("seen", "w").close()
            time.sleep(3600)

def build():
    root = Coupled("yard")
    root.add(Stuck("stuck"))
    return root
"""


def test_a_node_that_exceeds_the_deadline_for_its_answer_is_replaced(tmp_path):
    (tmp_path / "stuck.py").write_text(STUCK)
    done = command("stuck.py:build", "--deadline", "1 s", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    assert (tmp_path / "seen").exists(), "the first one sleeps for an hour"
    assert done.stdout.startswith("last event at 0 s; ")
    assert done.stderr.startswith("node stuck is replaced at t = 0.000 s: its process ")
    refused = command("stuck.py:build", "--deadline", "soon", cwd=tmp_path)
    message = (
        "heavylift: --deadline 'soon': 'soon' is not a valid time: write a number and a unit of s, min, h, ms, days\n"
    )
    assert (refused.returncode, refused.stderr) == (1, message)


@pytest.mark.parametrize("where", [[], ["--in-process"]], ids=["processes", "one process"])
def test_an_exception_in_a_model_is_reported_with_the_path_of_the_model_and_the_time(where):
    done = command("rings:failing", *where, cwd=HERE)
    assert done.returncode == 1
    line = (HERE / "rings.py").read_text().partition("1 / (2")[0].count("\n") + 1
    message = f"workshop.divider at (2 s, 0): external() raised ZeroDivisionError: division by zero (rings.py:{line})"
    assert done.stderr == f"heavylift: {message}\n"


@pytest.mark.parametrize(
    ("reference", "sentence"),
    [
        (
            "rings",
            "'rings' does not refer to a model: write module:function, such as my_models:build or my_models:ring(4)",
        ),
        ("rings:tokens(open('x'))", "\"rings:tokens(open('x'))\" does not refer to a model: write module:function"),
        ("rings:tokens(4)", "rings:tokens(4): tokens() raised TypeError: tokens() takes 0 positional arguments"),
        ("rings:sand", "rings:sand: rings has no function sand; define one that returns a Coupled"),
        ("rungs:tokens", "there is no module rungs, neither in this folder nor installed"),
        ("rungs.py:tokens", "rungs.py: there is no such file"),
        ("rings:Job", "rings:Job: Job() raised TypeError: Missing required argument 'number'"),
        ("rings:ring", "rings:ring: ring() raised TypeError: ring() missing 3 required positional arguments"),
        ("builtins:dict", "builtins:dict: dict() returned dict; the function must return a Coupled"),
    ],
)
def test_an_object_that_is_not_a_devs_model_is_reported(reference, sentence, monkeypatch, capsys):
    monkeypatch.chdir(HERE)
    monkeypatch.setattr(sys, "argv", ["heavylift", "devs", reference])
    with pytest.raises(SystemExit) as ended:
        main()
    message = capsys.readouterr().err
    assert ended.value.code == 1
    assert message.startswith(f"heavylift: {sentence}")
    assert message.count("\n") == 1


def test_a_file_with_the_name_of_another_imported_module_is_reported(tmp_path, monkeypatch):
    (tmp_path / "queue.py").write_text("")
    monkeypatch.chdir(tmp_path)
    with pytest.raises(ModelError) as message:
        built("queue:build")
    assert str(message.value) == f"queue:build: queue is {queue.__file__}, which has no build; rename queue.py"


def test_a_script_that_runs_its_model_while_imported_is_reported(tmp_path):
    script = tmp_path / "study.py"
    script.write_text(
        "from heavylift import run_models\n"
        "from heavylift.nodes.zoo.token_ring import ring\n"
        "def build():\n    return ring(3, 1, 10)\n"
        "run_models(build, until=1e-7)\n"
    )
    done = subprocess.run([sys.executable, script], capture_output=True, text=True, timeout=60)
    assert "runs a model when it is imported" in done.stderr.splitlines()[-1]


def test_a_reference_to_a_function_that_builds_a_model_can_include_arguments():
    done = command("heavylift.nodes.zoo.token_ring:ring(4, tokens=2, hold=5_000_000)", "--until", "21 ms", "--json")
    assert json.loads(done.stdout)["digest"] == run_models(tokens, until=0.021, in_process=True).digest


def test_a_function_that_builds_a_model_is_refused_if_defined_inside_another_function():
    def build():
        return tokens()

    with pytest.raises(ModelError, match="other processes cannot import it"):
        run_models(build)


def test_nodes_that_share_a_process_give_the_log_of_the_flat_simulator():
    lines: list[Transition] = []
    run = run_models(tokens, until=0.101, processes=2, log=lines.append)
    assert lines == flat(tokens, ms(101))
    assert run.digest == run_models(tokens, until=0.101, in_process=True).digest


def test_a_run_that_fails_leaves_a_recording_of_all_events_before_the_error(tmp_path):
    """The divider fails at its third job, whether it shares its process with who sends it or not."""
    text = []
    for number, where in enumerate([{}, {"processes": 2}, {"in_process": True}]):
        path = tmp_path / f"{number}.mcap"
        with pytest.raises(
            ModelError, match=r"^workshop\.divider at \(2 s, 0\): external\(\) raised ZeroDivisionError"
        ):
            run_models("rings:failing", output=path, **where)
        text.append([(e.t_ns, e.source) for e in Recording(path).events() if e.t_ns < 2 * 10**9])
    assert text[0] == text[1] == text[2] == [(0, "frame"), (10**9, "frame")]


def test_a_thousand_models_placed_in_one_process_form_one_node():
    run = run_models("heavylift.nodes.zoo.token_ring:ring(1000, 1, 1000)", until=3.001e-6, in_process=True)
    assert (run.grants, run.sim_s) == (1, 3e-6)


def test_the_fastest_number_of_processes_for_a_model_is_reported():
    done = command("rings:tokens", "--until", "21 ms", "--processes", "auto", cwd=HERE)
    assert done.returncode == 0, done.stderr
    message = r"--processes auto: 1, for 1 process takes 0\.\d\d s for all of the run\n"
    assert re.fullmatch(message, done.stderr), done.stderr
    placed = command("rings:tokens", "--until", "21 ms", "--place", "s0,s1,s2=yard", cwd=HERE)
    assert placed.stdout.splitlines()[2] == done.stdout.splitlines()[2] != ""
