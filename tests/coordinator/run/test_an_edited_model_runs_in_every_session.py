"""Whatever a run names by file is read when it runs: in this process, in processes, and into a recording."""

from __future__ import annotations

from math import cos
from pathlib import Path

import pytest
from heavylift import run, run_models, simulate
from heavylift.kernel.description import Body, Joint, System, UserLaw

MODEL = """
from heavylift.nodes.devs import Atomic, Coupled, Message, Out, ms
{helper}
class EditedBeat(Message):
    number: int
class Clock(Atomic):
    beat = Out(EditedBeat)
    def start(self): self.n = 0; self.hold_in(ms(WAIT))
    def output(self): self.beat.send(EditedBeat(self.n))
    def internal(self): self.n += 1; self.hold_in(ms(WAIT))
    def result(self): return EditedBeat(self.n)
def build():
    yard = Coupled("yard"); yard.add(Clock("clock")); return yard
"""
LAW = "def law(x):\n    return -{} * x.q\n"
SPRING = """heavylift: 1
name: spring
end: 1 s
mechanism:
  bodies: {b: {mass: 1 kg}}
  joints: {j: {type: prismatic, child: b, axis: [1, 0, 0], start: 1 m}}
  forces: {l: {type: law, function: "spring_law.py:law", joint: j}}
"""
CART = """heavylift: 1
name: cart
end: 2 s
mechanism:
  bodies: {cart: {mass: 1 t}}
  joints: {rail: {type: prismatic, child: cart, axis: [1, 0, 0]}}
  drives: {drive: {joint: rail, type: prescribed, ramp: 10 m/s2, range: [-50 m, 50 m]}}
models:
  driver:
    {model: "driver.py:Driver", period: 100 ms, delay: 20 ms, signals: {at: position of rail}, orders: {speed: drive}}
"""
DRIVER = """
from heavylift.nodes.devs import Atomic, In, Out
from heavylift.nodes.models import Sample, SetPoint
class Driver(Atomic):
    at, speed = In(Sample), Out(SetPoint)
    def start(self): self.passivate()
    def external(self, e, x): self.hold_in(0)
    def output(self): self.speed.send(SetPoint({}))
    def internal(self): self.passivate()
"""


@pytest.fixture
def here(own_modules: Path, code_allowed: None) -> Path:
    return own_modules


@pytest.mark.parametrize("helper", [False, True], ids=["model", "helper"])
@pytest.mark.parametrize("reference", ["beat.py:build", "beat:build"])
def test_an_edited_model_is_loaded_anew_for_each_run(reference: str, helper: bool, here: Path) -> None:
    message: list[tuple[object, ...]] = []
    for wait, beats in ((1000, 3), (100, 35)):
        imports = "from beat_wait import WAIT" if helper else f"WAIT = {wait}"
        (here / "beat_wait.py").write_text(f"WAIT = {wait}\n")
        (here / "beat.py").write_text(MODEL.format(helper=imports))
        inside = run_models(reference, 3.55, "beat.mcap", in_process=True, force=True)
        outside = run_models(reference, 3.55)
        assert inside.results["yard.clock"].number == beats  # type: ignore[attr-defined]
        assert inside.digest == outside.digest
        message.append((inside.digest, inside.results))
    assert message[0] != message[1]


def test_a_function_passed_as_a_python_object_is_loaded_again_from_its_edited_file(here: Path) -> None:
    (here / "beat_given.py").write_text(MODEL.format(helper="WAIT = 1000"))
    from beat_given import build  # type: ignore[import-not-found]

    (here / "beat_given.py").write_text(MODEL.format(helper="WAIT = 100"))
    runs = [run_models(build, 3.55, in_process=where) for where in (True, False)]
    assert [r.results["yard.clock"].number for r in runs] == [35, 35]  # type: ignore[attr-defined]


def test_an_edited_force_law_is_loaded_anew_for_each_run(here: Path) -> None:
    system = System(
        (Body("b", 1.0),),
        (Joint("j", "prismatic", "world", "b", axis=(1, 0, 0), q0=(1.0,)),),
        forces=(UserLaw("l", "spring_law.py:law", joint="j"),),
    )
    (here / "spring.yaml").write_text(SPRING)
    for k in (1.0, 4.0):
        (here / "spring_law.py").write_text(LAW.format(k))
        for model in (system, "spring.yaml"):
            at_end = simulate(model, until=1.0)["joint/position"].values[-1, 0]  # type: ignore[call-overload]
            assert at_end == pytest.approx(cos(k**0.5), abs=1e-5)


def test_edited_model_code_of_a_scene_is_loaded_again_for_each_run(here: Path) -> None:
    (here / "cart.yaml").write_text(CART)
    (here / "upon.yaml").write_text("extends: cart.yaml\nname: upon\n")
    ends = []
    for speed in ("1.0", "3.0"):
        (here / "driver.py").write_text(DRIVER.format(speed))
        result = simulate("upon.yaml")
        ends.append(result["joint/position"].values[-1, 0])
        for in_process in (True, False):
            assert run("upon.yaml", "upon.mcap", in_process=in_process, force=True).digest == result.digest
    assert ends[1] == pytest.approx(3.0 * ends[0], rel=0.1)
    (here / "cart.yaml").write_text(CART.replace("end: 2 s", "end: 1 s"))
    assert simulate("upon.yaml").t[-1] == pytest.approx(1.0)
