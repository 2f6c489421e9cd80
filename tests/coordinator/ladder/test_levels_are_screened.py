"""Levels whose swings a linear model sees wrong are not run; what it sees is what runs of both levels show."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest

sys.path.insert(0, str(Path(__file__).parents[2] / "nodes/fidelity"))

from heavylift.coordinator.ladder import Ladder, LedPendulum, Measuring, Ramp, choose, plausible, swing_error
from heavylift.nodes.plan import MEANT, Question
from heavylift.nodes.scene import load, parse
from lifts_of_kinds import lift_of_kinds
from scipy.integrate import solve_ivp

SWUNG = [88_012, 88_018, 99_012, 99_014]  # lifts by goliaths that swing since their trolleys have moved
NEAR = 2.0  # times the measured error, the predicted one may be: both loads and slings are one pendulum there


@pytest.mark.parametrize("seed", range(5))
def test_the_swing_estimate_follows_a_pendulum_whose_pivot_accelerates_at_random(seed: int) -> None:
    draw = np.random.default_rng(seed)
    w, times = draw.uniform(0.2, 2.0), np.sort(draw.uniform(0.0, 30.0, 6)).tolist()
    ramps = [Ramp(a, b, draw.normal()) for a, b in zip(times[::2], times[1::2], strict=True)]

    def slope(t: float, x: np.ndarray) -> list[float]:
        return [x[1], -w * w * x[0] - sum(r.acceleration for r in ramps if r.start <= t < r.end)]

    exact = solve_ivp(slope, (0.0, 40.0), [0.3, -0.2], rtol=1e-9, atol=1e-9, max_step=0.05).y[:, -1]
    middle = LedPendulum(0.3, -0.2, w).led(ramps, w, 0.0, times[2] + 0.1)
    swing = middle.led(ramps, w, times[2] + 0.1, 40.0)
    assert np.allclose([swing.y, swing.v], exact, atol=1e-3)


@pytest.mark.parametrize("seed", SWUNG)
def test_the_estimated_swing_error_of_massless_ropes_agrees_with_the_difference_of_two_runs(seed: int) -> None:
    plan = parse(lift_of_kinds(seed).text, passing=True, followed=False).plan
    ladder, measuring = Ladder(plan), Measuring(("swing", "position"))
    coarse, fine = (ladder.candidates(level)[2] for level in (ladder.plausible[0], ladder.full[-2]))
    measured = max(measuring.apart(coarse, fine).values())
    assert measured / NEAR < swing_error(plan) < NEAR * measured


def test_model_levels_whose_estimated_swing_error_is_too_large_are_not_simulated() -> None:
    plan = load("lift").plan
    ladder, text = Ladder(plan), list[str]()
    assert choose(ladder, Question(MEANT, 0.01), Measuring(MEANT, say=text.append)).fidelity.lumps == 2
    assert all("lumps" in x for x in text)
    assert plausible(ladder.plausible, plan, Question(MEANT, 0.05)) == ladder.plausible
    assert plausible(ladder.plausible, plan, Question(("rope tension",), 1e-6)) == ladder.plausible
    coarse = Ladder(plan, ["ropes"])
    assert plausible(coarse.plausible, plan, Question(MEANT, 1e-6)) == coarse.plausible, "there are no others"


@pytest.mark.parametrize("scene", ["pendulum", "floating", "hall", "spreader", "single-turn"])
def test_scenes_without_moving_heavy_ropes_have_no_estimated_swing_error(scene: str) -> None:
    assert swing_error(load(scene).plan) == 0.0
