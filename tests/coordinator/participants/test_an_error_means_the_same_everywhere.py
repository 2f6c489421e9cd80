"""What a model's function raises is one sentence with path, time, file and line, whoever runs the model."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest
from heavylift import Recording, run_models
from heavylift.coordinator.participants import built
from heavylift.coordinator.replay import recorded_models
from heavylift.kernel import ModelError
from heavylift.nodes.devs import Simulator
from heavylift.recordings.read import info

MODEL = """
from heavylift.nodes.devs import Atomic, Coupled, In, Message, Out, seconds
class SaidByBroken(Message):
    n: int = 0
class Rude(Exception):
    def __str__(self): raise RuntimeError("no text")
    __repr__ = __str__
class Own(BaseException): pass
class Broken(Atomic):
    into, out = In(SaidByBroken), Out(SaidByBroken)
    def __init__(self, name, what): super().__init__(name); self.what = what
    def start(self): self.hold_in(seconds(1))
    def output(self):
        if self.what == "none": self.out.send(None)
    def internal(self):
        what, f = self.what, lambda: f()
        if what == "value": raise ValueError("two\\nlines")
        if what == "terminal": raise ValueError("\\x1b[2J\\x07 gone")
        if what == "half": raise ValueError("half \\ud800")
        if what == "rude": raise Rude
        if what == "huge": raise ValueError("x" * 3_000_000)
        if what == "memory": raise MemoryError
        if what == "much": bytearray(1 << 60)
        if what == "exit": raise SystemExit(3)
        if what == "generator": raise GeneratorExit
        if what == "own": raise Own("ended")
        if what == "group": raise ExceptionGroup("several", [ValueError(), Rude()])
        if what == "deep": f()
        self.passivate()
class Ear(Atomic):
    into = In(SaidByBroken)
    def external(self, e, x): pass
def build(what):
    yard = Coupled("yard"); a, b = yard.add(Broken("a", what)), yard.add(Ear("b")); yard.connect(a.out, b.into)
    return yard
def nested(levels):
    yard = below = Coupled("yard")
    yard.add(Ear("ear"))
    for _ in range(levels): below = below.add(Coupled("c"))
    below.add(Broken("a", "value"))
    return yard
"""
CASES = {
    "value": "internal() raised ValueError: two lines",
    "terminal": "internal() raised ValueError: \\x1b[2J\\x07 gone",
    "half": "internal() raised ValueError: half \\ud800",
    "rude": "internal() raised Rude: its text cannot be had",
    "huge": f"internal() raised ValueError: {'x' * 500} ... (3000000 characters)",
    "memory": "internal() raised MemoryError",
    "much": "internal() raised MemoryError",
    "exit": "internal() raised SystemExit: 3",
    "generator": "internal() raised GeneratorExit",
    "own": "internal() raised Own: ended",
    "group": "internal() raised ExceptionGroup: several (2 sub-exceptions)",
    "deep": "internal() raised RecursionError: maximum recursion depth exceeded",
    "none": "port out carries SaidByBroken, not NoneType: None",
}


def line(what: str) -> str:
    found = (
        MODEL.partition(f'"{what}":')[0].count("\n") + 1
        if what != "deep"
        else MODEL[: MODEL.index("f()")].count("\n") + 1
    )
    return "" if what == "none" else f" (broken.py:{found})"


def flat(reference: str) -> None:
    simulator = Simulator(built(reference))
    simulator.start()
    simulator.run()


def sentence(run: Callable[[], object]) -> tuple[str, BaseException | None]:
    with pytest.raises(ModelError) as caught:
        run()
    return str(caught.value), caught.value.__cause__


@pytest.fixture
def written(own_modules: Path) -> Path:
    (own_modules / "broken.py").write_text(MODEL)
    return own_modules


@pytest.mark.parametrize("what", CASES)
def test_an_error_has_the_same_text_in_the_flat_simulator_in_distributed_runs_and_in_the_recording(
    what: str, written: Path, code_allowed: None
) -> None:
    reference, message = f"broken.py:build('{what}')", f"yard.a at (1 s, 0): {CASES[what]}{line(what)}"
    assert sentence(lambda: run_models(reference, output="broken.mcap"))[0] == message
    for run in (lambda: flat(reference), lambda: run_models(reference, in_process=True)):
        text, cause = sentence(run)
        assert text == message
        assert isinstance(cause, ModelError) if what == "none" else type(cause).__name__ in message
    recording = Recording("broken.mcap")
    assert f"failed: {message}" in info("broken.mcap")
    node = recorded_models(recording).make("a", lambda data: None)
    node.start()
    assert sentence(lambda: (node.outputs(), node.advance(node.next_time)))[0] == message


@pytest.mark.parametrize("levels", [500, 2000])
def test_devs_models_may_be_nested_deeply(levels: int, written: Path) -> None:
    reference = f"broken.py:nested({levels})"
    message = f"yard{'.c' * levels}.a at (1 s, 0): {CASES['value']}{line('value')}"
    for run in (lambda: flat(reference), lambda: run_models(reference, in_process=True), lambda: run_models(reference)):
        assert sentence(run)[0] == message


def test_errors_in_a_function_that_builds_a_model_are_reported(written: Path) -> None:
    (written / "broken.py").write_text(f"{MODEL}\ndef never():\n    raise ValueError('never')\n1 / 0\n")
    with pytest.raises(
        ModelError, match=r"broken.py cannot be imported: ZeroDivisionError: division by zero \(broken.py:"
    ):
        built("broken.py:never")
    (written / "broken.py").write_text(f"{MODEL}\ndef never():\n    raise ValueError('never')\n")
    with pytest.raises(ModelError, match=r"never\(\) raised ValueError: never \(broken.py:\d+\)$"):
        built("broken.py:never")
