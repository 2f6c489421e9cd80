"""`heavylift.simulate`: a scene or a system as named arrays, in seconds; the run is that of `heavylift run`."""

from __future__ import annotations

import pickle
from concurrent.futures import ThreadPoolExecutor
from math import cos, pi, sqrt
from pathlib import Path

import numpy as np
import pytest
from heavylift.coordinator.run import run
from heavylift.coordinator.run.simulate import simulate
from heavylift.kernel import HeavyliftError
from heavylift.kernel.description import Body, Joint, System
from heavylift.nodes.scene import load

STICK = System(
    bodies=(Body("bob", 2.0, (0.0, 0.0, -1.0)),),
    joints=(Joint("pin", "revolute", "world", "bob", axis=(0.0, 1.0, 0.0), q0=(0.01,)),),
)


@pytest.fixture(scope="module")
def lift():
    return simulate("lift")


def test_the_function_simulate_reproduces_the_closed_form_of_a_pendulum() -> None:
    period = 2.0 * pi / sqrt(STICK.gravity)
    swung = simulate(STICK, until=2.0 * period, every=0.01)
    assert swung.t[-1] == pytest.approx(2.0 * period, abs=1e-9)
    assert (np.diff(swung.t) > 0.0).all()
    expected = [0.01 * cos(sqrt(STICK.gravity) * t) for t in swung.t]
    assert swung["joint/position"]["pin.angle"] == pytest.approx(expected, abs=1e-6)


def test_simulate_gives_the_same_results_as_a_recorded_run(lift, tmp_path: Path) -> None:
    recorded = run("lift", tmp_path / "lift.mcap", in_process=True)
    assert lift.digest == recorded.digest
    assert lift.verdict == recorded.verdict
    assert lift.peaks == recorded.peaks
    assert not lift.unfinished


def test_recorded_quantities_have_names_and_units(lift) -> None:
    tension = lift["rope/tension"]
    assert (tension.unit, tension["crane.H1"].shape) == ("N", lift.t.shape)
    assert [s.name for s in lift.stages] == ["take up slack", "lift off", "up", "sideways", "swing"]
    assert all(a.end == b.start for a, b in zip(lift.stages, lift.stages[1:], strict=False))
    assert lift.events[-1].t <= lift.stages[-1].end
    frame = lift.to_pandas()
    assert frame.index.name == "time [s]"
    assert frame["rope/tension/crane.H1 [N]"].max() <= lift.peaks["crane.H1"].tension


def test_the_function_simulate_returns_only_the_quantities_named_in_its_argument_keep(lift) -> None:
    few = simulate("lift", keep=["rope/tension"])
    assert list(few.signals) == ["rope/tension"]
    assert len(pickle.dumps(few)) < len(pickle.dumps(lift)) / 3
    assert pickle.loads(pickle.dumps(few)).digest == lift.digest


def test_a_run_of_10_ms_has_101_samples_by_default() -> None:
    assert len(simulate(STICK, 0.01).t) == 101  # one each 0.1 ms


def test_simulations_that_run_concurrently_in_threads_do_not_interfere(lift) -> None:
    scenes = [load("lift", [f"block.mass={mass} t"]) for mass in (250, 300, 350)]
    with ThreadPoolExecutor(3) as pool:
        found = list(pool.map(simulate, scenes))
    assert found[1].digest == lift.digest  # its own mass
    assert [x.digest for x in found] == [simulate(scene).digest for scene in scenes]


def test_operator_commands_passed_to_a_run_from_python_have_times_in_seconds() -> None:
    text = simulate("lift", until=60.0, orders=[(58.0, "crane H1: hoist 0.3 m/min by 0.01 m")])
    assert [(e.t, e.value["text"]) for e in text.events if e.source == "operator"] == [
        (58.0, "crane H1: hoist 0.3 m/min by 0.01 m")
    ]


def test_a_control_function_that_orders_nothing_does_not_change_the_motion() -> None:
    quiet = simulate(STICK, 1.0, every=0.1, orders=[(0.5, lambda s: None)])
    assert quiet["joint/position"]["pin.angle"][-1] == pytest.approx(
        simulate(STICK, 1.0)["joint/position"]["pin.angle"][-1]
    )


@pytest.mark.parametrize(
    ("asked", "told"),
    [
        (lambda: simulate(STICK), "a system has no end of its own"),
        (lambda: simulate(STICK, float("nan")), "until: nan s is out of range: choose 0.001 ms to 100 days"),
        (lambda: simulate(STICK, 1e30), "until: 1e+30 s is out of range"),
        (lambda: simulate("lift", "5 s"), "until: '5 s' is not a number; give a number of seconds"),
        (lambda: simulate(STICK, True), "until: True is not a number"),
        (lambda: simulate("lift", every=0.0), "every: 0.0 s is out of range: choose 0.1 ms to 1000 s"),
        (lambda: simulate("lift", every="x"), "every: 'x' is not a number"),
        (lambda: simulate("lift", orders="stop"), "orders='stop': give a list of pairs (seconds, an operator's words)"),
        (lambda: simulate("lift", orders=[(1.0,)]), "orders: (1.0,) is not a pair (seconds, an operator's words)"),
        (lambda: simulate("lift", orders=[(1.0, 7)]), "orders: (1.0, 7) is not a pair"),
        (lambda: simulate("lift", orders=[("a", "stop")]), "orders: 'a' is not a number"),
        (lambda: simulate(STICK, 1.0, orders=[(0.5, "stop")]), "is not a pair (seconds, a function of the simulation)"),
        (lambda: simulate(STICK, 1.0, orders=[(-0.5, print)]), "orders: -0.5 s is outside the possible times of a run"),
        (lambda: simulate("lift", keep=[3]), "keep=[3]: give names of signals"),
        (lambda: simulate(7), "7 is not a scene"),
        (lambda: simulate("lift", orders=[(90.0, "crane H1: hoist 1 m/min by 1 m")]), "the run ends at 77.32"),
        (lambda: simulate("lift", orders=[(3.0, "crane H1: hoist 1 m/min by 1 m")]), "while its hoist"),
        (lambda: simulate("lift", keep=["rope/tensoin"]), "did you mean rope/tension?"),
        (lambda: simulate("lift", method="radau5"), "these options are for systems"),
        (lambda: simulate("nowhere"), "there is no scene 'nowhere'"),
    ],
)
def test_invalid_arguments_of_simulate_are_reported_in_one_sentence(asked, told: str) -> None:
    with pytest.raises(HeavyliftError) as found:
        asked()
    assert told in str(found.value)
