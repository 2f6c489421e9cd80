"""`Result.at`: what the integrator has between its steps, against closed forms, samples and another period."""

from __future__ import annotations

import pickle
from pathlib import Path

import numpy as np
import pytest
from heavylift import Recording, run, simulate
from heavylift.kernel import KernelError
from heavylift.kernel.description import Body, Joint, JointSpring, Lock, System, UserLaw

G = 9.80665
CLOSE = 1e-6  # ten times the tolerance of the integrator
SLIDE = Joint("j", "prismatic", "world", "b", axis=(0, 0, 1))
BODY = Body("b", 2.0)
FALLING = System((BODY,), (SLIDE,), locks=(Lock("l", "j"),))
RANDOM = np.random.default_rng(7)


def test_dense_output_between_two_samples_of_a_free_fall_is_exact() -> None:
    result = simulate(FALLING, until=3.0, every=3.0)
    assert len(result.t) == 2
    t = RANDOM.uniform(0.0, 3.0, 40)
    found = result.at(t)
    assert found.t.tolist() == t.tolist()
    assert found["joint/position"]["j.travel"] == pytest.approx(-G / 2 * t**2, abs=CLOSE)
    assert found["joint/velocity"]["j.speed"] == pytest.approx(-G * t, abs=CLOSE)


@pytest.mark.parametrize("method", ["dopri5", "radau5"])
def test_dense_output_between_samples_of_an_oscillation_is_exact(method: str) -> None:
    w = 7.0
    spring = JointSpring("s", "j", k=2.0 * w * w)
    level = Joint("j", "prismatic", "world", "b", axis=(1, 0, 0), q0=(1.0,))
    result = simulate(System((BODY,), (level,), springs=(spring,)), until=5.0, every=2.5, method=method)
    t = np.linspace(0.0, 5.0, 101)
    assert result.at(t)["joint/position"]["j.travel"] == pytest.approx(np.cos(w * t), abs=1e-5)
    straight = np.interp(t, result.t, result["joint/position"]["j.travel"])
    assert abs(straight - np.cos(w * t)).max() > 1.0, "samples alone would do"


def test_dense_output_at_the_instant_of_an_event_has_values_before_and_after_it() -> None:
    result = simulate(FALLING, until=2.0, every=0.5, orders=[(1.0, lambda s: s.set_lock("l", True))])
    assert result.t.tolist().count(1.0) == 2
    for t, before, after in ((1.0, -G, 0.0), (0.75, -0.75 * G, -0.75 * G), (1.25, 0.0, 0.0)):
        assert result.at(t)["joint/velocity"]["j.speed"] == pytest.approx([after], abs=CLOSE)
        assert result.at(t, before=True)["joint/velocity"]["j.speed"] == pytest.approx([before], abs=CLOSE)
    times = [1.5, 0.5, 1.0, 0.5]  # in any order, more than once
    assert result.at(times)["joint/position"]["j.travel"] == pytest.approx([-G / 2, -G / 8, -G / 2, -G / 8], abs=CLOSE)


def test_dense_output_between_coarse_samples_agrees_with_a_run_that_has_denser_samples() -> None:
    coarse, dense = simulate("lift", until=60.0), simulate("lift", until=60.0, every=0.11)
    apart = np.flatnonzero(np.diff(dense.t) > 0)[1:]
    t = dense.t[apart]
    found = coarse.at(t)
    assert set(found.signals) == set(coarse.signals) - {"rope/peak", "rope/peak_time"}
    for name in ("rope/tension", "joint/position", "pose/block"):
        assert found[name].values == pytest.approx(dense[name].values[apart], rel=1e-6, abs=CLOSE)


def test_dense_output_at_the_requested_end_time_equals_the_last_sample() -> None:
    """Of a scene, too, of which nothing at that very instant happens any more."""
    for what, until in ((FALLING, 1.0), ("pendulum", 1.0), ("lift", 0.3)):
        result = simulate(what, until=until)
        found = result.at(np.linspace(0.0, until, 11))
        assert found.t[-1] == until
        for name, signal in found.signals.items():
            assert signal.values[-1] == pytest.approx(result[name].values[-1], rel=1e-6, abs=CLOSE)


def test_the_function_simulate_returns_the_events_of_the_recorded_run(tmp_path: Path) -> None:
    recording = Recording(run("lift", tmp_path / "lift.mcap", in_process=True).recording)
    assert simulate("lift").events == recording.events()
    assert [e.t for e in recording.events()] == [e.t_ns / 1e9 for e in recording.events()]


def test_reading_dense_output_at_a_time_outside_the_run_is_refused() -> None:
    result = simulate(FALLING, until=1.0)
    for times, message in ((1.5, "1.5 s is outside the run, which lasts from 0 to 1 s"), (-0.1, "-0.1 s is outside")):
        with pytest.raises(KernelError, match=message):
            result.at(times)
    for times in ([float("nan")], [[0.1]], "soon"):
        with pytest.raises(KernelError, match=r"at: .*give"):
            result.at(times)  # type: ignore[arg-type]
    with pytest.raises(KernelError, match="pickled"):
        pickle.loads(pickle.dumps(result)).at(0.5)


def test_editing_a_force_law_after_a_run_does_not_change_the_dense_output_of_the_run(own_modules: Path) -> None:
    (own_modules / "pull.py").write_text("def pull(x):\n    return 1.0\n")
    system = System((BODY,), (SLIDE,), forces=(UserLaw("l", "pull.py:pull", joint="j"),))
    result = simulate(system, until=1.0)
    result.at(0.3)
    (own_modules / "pull.py").write_text("def pull(x):\n    return 2.0\n")
    with pytest.raises(KernelError, match="code that it uses has been edited"):
        result.at(0.3)
