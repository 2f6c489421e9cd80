"""What atomics tell in the end is read back from wherever they ran, as it was meant, and stands in the recording."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
from heavylift import run_models
from heavylift.coordinator.protocol import RunEnd
from heavylift.coordinator.run import RunBranch
from heavylift.kernel import ModelError, RecordingError
from heavylift.nodes.devs import Atomic, Coupled, Message, Model, Out, Simulator, seconds
from heavylift.nodes.zoo import Counted, workshop
from heavylift.recordings import Recording

HERE = {"in_process": True}
ENDS = {"no end": {}, "a bound": {"until": 5.0}, "a port": {"stop": "processor.done"}}


class Till(Message):
    seconds: float
    names: tuple[str, ...] = ("a", "b")


class Clock(Atomic):
    """Ends a silent run."""

    def start(self) -> None:
        self.hold_in(seconds(7))

    def internal(self) -> None:
        self.passivate()

    def result(self) -> Till:
        return Till(self.now.t / 1e9)


def work() -> Coupled:
    model = workshop(seconds(1), seconds(2.5), seconds(10))
    model.add(Coupled("room")).add(Clock("clock"))
    return model


def silent() -> Coupled:
    model = Coupled("silent")
    model.add(Clock("clock"))
    model.add(Clock("late")).start = lambda: model.children["late"].hold_in(seconds(9))  # type: ignore[attr-defined]
    return model


def flat(model: Model, until: int = 2**63 - 1, end: int = 0) -> dict[str, Message]:
    simulator = Simulator(model)
    simulator.start()
    simulator.run(until)
    return simulator.results(end)


TRUTH = {
    "no end": (RunEnd.QUIET, 11, 4, 11.5),
    "a bound": (RunEnd.BOUND, 5, 1, 5.0),
    "a port": (RunEnd.FINISHED, 3, 1, 2.500000001),
}


@pytest.mark.large(beyond=4)
@pytest.mark.parametrize("where", [HERE, {}, {"places": ["frame,processor=yard"]}], ids=["here", "apart", "placed"])
@pytest.mark.parametrize("end", ENDS)
def test_the_results_of_a_model_do_not_depend_on_the_process_in_which_it_runs(
    end: str, where: dict[str, Any], tmp_path: Path
) -> None:
    outcome, arrivals, solutions, seconds = TRUTH[end]
    run = run_models(work, output=tmp_path / "run.mcap", **ENDS[end], **where)
    assert run.outcome is outcome
    assert run.results == {
        "workshop.frame.transducer": Counted(arrivals, solutions),
        "workshop.room.clock": Till(seconds),
    }
    recorded = Recording(tmp_path / "run.mcap").results()
    assert recorded["workshop.room.clock"] == {"type": "Till", "value": {"seconds": seconds, "names": ["a", "b"]}}
    assert recorded["workshop.frame.transducer"]["value"] == {"arrivals": arrivals, "solutions": solutions}


def test_a_flat_simulator_returns_the_results_of_its_models_and_can_continue() -> None:
    assert flat(work()) == run_models(work, **HERE).results
    assert flat(work(), seconds(5), seconds(5)) == run_models(work, until=5.0, **HERE).results
    simulator = Simulator(work())
    simulator.start()
    simulator.run(seconds(5))
    assert simulator.results(seconds(5)) == simulator.results(seconds(5))
    simulator.run()
    assert simulator.results() == flat(work())


def spoiled(result: Any) -> Coupled:
    class Spoiled(Clock):
        out = Out(Till)

    Spoiled.result = result  # type: ignore[method-assign]
    model = Coupled("yard")
    model.add(Spoiled("one"))
    return model


@pytest.mark.parametrize(
    ("result", "sentence"),
    [
        (lambda m: 3.5, "result() returned float 3.5; it must return a Message or None"),
        (lambda m: 1 / 0, "result() raised ZeroDivisionError: division by zero"),
        (lambda m: m.hold_in(5), "result() must not change the model: do that in a transition"),
        (lambda m: m.parent.remove("one"), "result() must not change the model: do that in a transition"),
        (lambda m: m.out.send(Till(1.0)), "port out was used outside output(); only output() may send"),
        (
            lambda m: Till("x"),
            "its result: message Till, field seconds: the str 'x' does not arrive unchanged as float",
        ),
    ],
)
def test_an_invalid_result_of_a_model_is_reported_with_model_path_and_time(result: Any, sentence: str) -> None:
    with pytest.raises(ModelError) as message:
        flat(spoiled(result))
    assert str(message.value).startswith(f"yard.one at (7 s, 0): {sentence}")


def test_an_invalid_name_of_the_port_that_ends_a_run_is_refused() -> None:
    for stop in ("processor.into", "frame.transducer.stop", "done"):
        with pytest.raises(ModelError, match=rf"^--stop {stop}: no child of workshop has this out port; "):
            run_models(work, stop=stop, **HERE)


def test_a_python_script_can_define_messages_and_run_its_model(tmp_path: Path) -> None:
    script = tmp_path / "study.py"
    script.write_text(
        "from heavylift import run_models\n"
        "from heavylift.nodes.devs import Atomic, Coupled, Message\n"
        "class Answer(Message):\n    value: int\n"
        "class Wise(Atomic):\n    def result(self):\n        return Answer(42)\n"
        "def build():\n    model = Coupled('top')\n    model.add(Wise('one'))\n    return model\n"
        "if __name__ == '__main__':\n    print(run_models(build, until=1e-7).results)\n"
    )
    done = subprocess.run([sys.executable, script], capture_output=True, text=True, timeout=60)
    assert done.stdout == "{'top.one': Answer(value=42)}\n"


def test_a_recording_of_devs_models_cannot_be_branched(tmp_path: Path) -> None:
    reference = "heavylift.nodes.zoo.multi_server_queue:mmc(c=2, seed=3)"
    run_models(reference, until=5.0, output=tmp_path / "queue.mcap", in_process=True)
    with pytest.raises(RecordingError) as error:
        RunBranch.of(tmp_path / "queue.mcap", "2 s", ["c=3"])
    assert str(error.value).endswith("holds a DEVS model and no scene; `heavylift resume` repeats its run")
