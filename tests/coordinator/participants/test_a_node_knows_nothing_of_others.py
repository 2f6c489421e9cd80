"""What a flat model may do and a node cannot do alike is refused by name; what is fixed may be read anywhere."""

import os
import re
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from heavylift import run_models
from heavylift.coordinator.participants import building
from heavylift.kernel import ModelError
from heavylift.nodes.devs import Simulator, Transition

HERE = Path(__file__).parent
TICKS = """
from heavylift.nodes.devs import Atomic, Coupled, Message, seconds
class Ticked(Message):
    n: int
class Ticks(Atomic):
    def start(self): self.n = 0; self.hold_in(0)
    def internal(self):
        self.n += 1
        self.hold_in(seconds(1)) if self.n < 5 else self.passivate()
    def result(self): return Ticked(self.n)
def build():
    yard = Coupled("y"); yard.add(Ticks("t")); return yard
"""
BEYOND = str(HERE / "beyond.py")
CURE = (
    "in a run each child of yard is a separate node; send messages, or put models that need each other into one Coupled"
)


def flat(reference: str, until: int = 100, **settings: Any) -> str:
    """All transitions of one simulator, or the sentence that it ends with."""
    lines: list[Transition] = []
    simulator = Simulator(building.built(f"{BEYOND}:{reference}"), lines.append, **settings)
    simulator.start()
    try:
        simulator.run(until)
    except ModelError as error:
        return str(error)
    return repr(lines)


def run(reference: str, until: int = 100, **settings: Any) -> str:
    """The same of nodes."""
    lines: list[Transition] = []
    try:
        run_models(f"{BEYOND}:{reference}", until=until / 1e9, log=lines.append, **settings)
    except ModelError as error:
        return str(error)
    return repr(lines)


STRUCTURE = {
    "add": "yard.add",
    "remove": "yard.remove",
    "connect": "yard.connect",
    "disconnect": "yard.disconnect",
    "more_in": "yard.add_in",
    "more_out": "yard.add_out",
}
OUT_OF_REACH = {
    **STRUCTURE,
    "children": "yard.children",
    "sibling": "yard.other.act",
    "tell_sibling": "yard.other.text",
    "blackboard": "yard.crew",
    "board": "yard.board",
}


@pytest.mark.parametrize("act", OUT_OF_REACH)
def test_code_of_a_model_cannot_reach_the_siblings_or_parents_of_the_model(
    act: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    message = f"yard.ticker at (0.00000003 s, 0): {OUT_OF_REACH[act]} cannot be accessed: {CURE}"
    if act in STRUCTURE:
        assert flat(f"yard('{act}')") == message
        monkeypatch.setattr("heavylift.nodes.devs.Coupled._reachable", lambda root, name: None)
    assert flat(f"yard('{act}')").count("Transition") > 20
    assert run(f"yard('{act}')", in_process=True) == message
    if act in ("remove", "sibling"):
        assert run(f"yard('{act}')") == message, "in processes, too"
    monkeypatch.setattr("heavylift.coordinator.participants.isolation._seclude", lambda root, own: None)
    assert run(f"yard('{act}')", in_process=True).count("Transition") > 20, "without the rule nobody says a word"


SHARED = {"log": "beyond.LOG", "tally": "beyond.count", "classwide": "beyond.Ticker.total"}


@pytest.mark.parametrize("act", SHARED)
def test_global_variables_that_change_during_a_run_are_reported_with_the_models_that_use_them(
    act: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    message = (
        f"yard.other, yard.ticker use the global variable {SHARED[act]}, which has changed, although each process has "
    )
    assert run(f"yard('{act}')", in_process=True).startswith(message)
    if act == "log":
        assert run(f"yard('{act}')").startswith(message), "in processes, too"
    monkeypatch.setattr("heavylift.coordinator.participants.isolation.Commons.unchanged", lambda commons, now: None)
    assert run(f"yard('{act}')", in_process=True).count("Transition") > 20


def test_a_global_variable_that_holds_a_model_is_reported_before_the_run() -> None:
    assert run("yard('registered')", in_process=True) == (
        "yard.other, yard.ticker may use the global variable beyond.FRIENDS, which refers to a model of this process "
        "while the other models run elsewhere; communicate by messages instead"
    )


@pytest.mark.parametrize("where", [{"in_process": True}, {"processes": 2}], ids=["one process", "two"])
def test_models_in_different_processes_may_read_constants_of_the_same_module(where: dict[str, Any]) -> None:
    assert run("yard('look')", **where) == flat("yard('look')")
    assert "ticker of yard yard 3 [1, 2, 3]" in flat("yard('look')")


@pytest.mark.filterwarnings("ignore:.*may iterate over a set")
@pytest.mark.parametrize(("what", "builds"), [("data", 1), ("settings", 3), ("words", 3), ("frozen", 3), ("fixed", 1)])
def test_two_models_of_one_parent_share_no_objects_whether_in_one_process_or_in_several(
    what: str, builds: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    made = list[str]()
    with_children = building.with_children
    monkeypatch.setattr(building, "with_children", lambda *x: (made.append(x[0]), with_children(*x))[1])
    together = run(f"crowd('{what}')", 40, in_process=True)
    assert len(made) == builds, "plain data are copied, for the rest the model is built again"
    assert together == run(f"crowd('{what}')", 40, processes=4)
    assert together.count("[1, 1, 2] True True") == 6, "three said it, and one has heard it"
    assert flat(f"crowd('{what}')", 40).count("[1, 1, 2] True True") == 2, "flat they are one"


WHERE = {
    "attribute": "yard.other.weight",
    "deep": "yard.other.plan",
    "generator": "yard.other.random",
    "clock": "yard.other.born",
    "numpy": "yard.other.random",
    "port": "its ports|the structure of yard.other",
    "inner": "the structure of yard.inner",
}


@pytest.mark.parametrize("what", WHERE)
def test_a_build_function_that_gives_different_models_in_two_processes_is_refused_before_the_run(
    what: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    text = run(f"random_build('{what}')", in_process=True)
    assert any(
        f"random_build('{what}'): {message} differs between the process of node" in text
        for message in WHERE[what].split("|")
    )
    monkeypatch.setattr("heavylift.coordinator.run.models.declarations", lambda root, nodes: [b"" for _ in nodes])
    monkeypatch.setattr("heavylift.coordinator.participants.building.declarations", lambda root, nodes: iter([b""]))
    assert run(f"random_build('{what}')", in_process=True).count("Transition") > 20


def test_a_build_function_that_omits_a_child_on_its_second_call_is_reported() -> None:
    message = (
        r"^[^ ]*: yard has no child ear\d+ here, it has ear, other, spare, ticker, ear\d+; let the function build the "
    )
    assert re.match(message, run("random_build('couplings')", in_process=True))


def test_a_build_function_that_returns_the_same_model_object_on_its_second_call_is_refused() -> None:
    message = "same() returned the model of an earlier call; it must create a new one each time"
    assert run("same()", in_process=True).endswith(message)


def digest(seed: str, *where: str) -> str:
    """Of the command under a seed of hashes."""
    done = subprocess.run(
        [Path(sys.executable).parent / "heavylift", "devs", f"{BEYOND}:words", "--until", "0.0001 ms", *where],
        env={**os.environ, "PYTHONHASHSEED": seed},
        capture_output=True,
        text=True,
        timeout=60,
        check=True,
    )
    return done.stdout.split()[-1]


def test_a_run_in_any_number_of_processes_iterates_over_sets_in_the_same_order() -> None:
    here = {run_models(f"{BEYOND}:words", until=1e-7, processes=n).digest for n in (1, 2)}
    assert here == {digest("7", "--in-process")}, "processes of a script and the command's own"


def test_models_that_run_with_a_hash_seed_other_than_the_fixed_one_are_reported(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr("heavylift.coordinator.run.models.fixed", lambda: False)
    with pytest.warns(UserWarning, match=r"^yard.other: may iterate over a set, whose order another process"):
        run("words()", in_process=True)


@pytest.mark.parametrize("where", [{"in_process": True}, {"processes": 2}], ids=["one process", "two"])
def test_a_long_chain_of_models_with_zero_delay_runs_if_the_microstep_limit_allows_it(where: dict[str, Any]) -> None:
    text = run("chain(60)", microsteps=40, **where)
    assert "zero-time loop between nodes, 40 microsteps" in text, text
    assert text.endswith("or allow more microsteps (a scene's key microsteps, heavylift devs --microsteps)")
    assert run("chain(60)", microsteps=80, **where) == flat("chain(60)", microsteps=80)
    assert flat("chain(10_005)", microsteps=10_100).count("Transition") == 20_010


@pytest.mark.parametrize("limit", [0, -5, 1.5, True, 2**40])
def test_an_invalid_limit_for_the_number_of_microsteps_is_refused(limit: Any) -> None:
    assert run("chain(3)", microsteps=limit) == (
        f"microsteps={limit!r}: the limit of microsteps at one time must be an int from 1 to 2**31 - 1"
    )


@pytest.mark.parametrize(
    ("until", "told"),
    [
        (-1, "until=-1: a run ends at 0 s or later; give a number of seconds"),
        (float("nan"), "until=nan: a run ends at 0 s or later; give a number of seconds"),
        ("1 s", "until: '1 s' is not a number; give a number of seconds"),
        (True, "until: True is not a number; give a number of seconds"),
        (
            10_000_000_000,
            "until=10000000000 looks like nanoseconds and would be 115741 days: `until` is in seconds; write 10.0 for "
            "so many nanoseconds, 10000000000.0 for so many seconds",
        ),
    ],
)
def test_the_function_run_models_refuses_an_until_time_that_is_not_a_number(until: Any, told: str) -> None:
    with pytest.raises(ModelError) as caught:
        run_models(f"{BEYOND}:chain(3)", until=until, in_process=True)
    assert str(caught.value) == told


@pytest.mark.parametrize(("until", "ticks"), [(0, 0), (2, 2), (2.5, 3), (np.int64(2), 2), (1e300, 5), (None, 5)])
def test_the_function_run_models_takes_its_until_time_in_seconds(until: Any, ticks: int, own_modules: Path) -> None:
    (own_modules / "ticks.py").write_text(TICKS)
    assert run_models("ticks.py:build", until=until, in_process=True).results["y.t"].n == ticks  # type: ignore[attr-defined]


@pytest.mark.parametrize("more", [{"processes": 2}, {"places": ["a=b"]}, {"remote": ["a"]}, {"external": ["a"]}])
def test_options_for_one_process_and_options_for_several_processes_exclude_each_other(more: dict[str, Any]) -> None:
    assert run("chain(3)", in_process=True, **more).startswith("in_process: all models run in this process; leave out")
