"""Random lifts, by goliaths and by other cranes: what is answered to an accuracy is within it of the finest level."""

from __future__ import annotations

import sys
from collections.abc import Callable
from pathlib import Path

import msgspec
import numpy as np
import pytest

sys.path.insert(0, str(Path(__file__).parents[2] / "nodes/fidelity"))

from heavylift.coordinator.ladder import CLOSE, Ladder, Measuring, ModelLevel, at_level, choose, largest
from heavylift.coordinator.record import play
from heavylift.nodes.plan import MEANT, Answer, Fidelity, Question
from heavylift.nodes.scene import load, parse
from lifts_of_kinds import Drawn, lift_of_kinds
from lifts_of_the_world import lift_of_the_world
from scipy.special import ellipj, ellipk

Draw = Callable[[int], Drawn]
SMALL = 30_008  # by one hook
UNDAMPED = 10_018  # short moves by ropes and slings without damping
LEAD = 20_025  # by a crane most of whose rope does not hang
FORKS = 20_063  # slings go slack and taut again, which loose steps damp
DROPS = 9_120_039  # waves of slack ropes decide when a stage ends, which all levels damp in loose steps
LANDS = 94_000_192  # waves of slack ropes decide when the next stage begins
ALMOST = 9_120_168  # a swing is hardly large enough for its period to count, and at some levels too small
TRUE = 1e-7  # tolerance of the reference
LONGEST = 1e-7  # [rad] of hours of swings, by the longest steps of explicit methods, whatever the tolerance
SWING = """heavylift: 1
name: swing
samples: 2 Hz
end: END
mechanism:
  bodies: {load: {mass: 450 t, com: [0, 0, -60 m]}}
  joints: {pivot: {type: revolute, child: load, axis: [0, 1, 0], start: -60 deg}}
"""
FINER = {"ropes": ("rigid", "elastic", "massive"), "girder": ("rigid", "elastic"), "slings": ("rigid", "elastic")}


@pytest.mark.parametrize(
    ("draw", "seed", "accuracy"),
    [
        (lift_of_kinds, SMALL, 0.1),
        (lift_of_the_world, 30_002, 0.01),
        (lift_of_the_world, LEAD, 0.003),
        (lift_of_the_world, 30_002, 0.1),
        (lift_of_kinds, UNDAMPED, 0.03),
    ],
)
@pytest.mark.large(beyond=3)
def test_results_of_random_lifts_are_within_the_requested_accuracy_of_a_reference(
    draw: Draw, seed: int, accuracy: float
) -> None:
    answer, error = answered(draw, seed, accuracy)
    assert not answer.notes
    assert max(answer.errors.values()) <= accuracy
    assert error <= accuracy


@pytest.mark.large
@pytest.mark.parametrize("accuracy", [0.3, 0.1, 0.03])
@pytest.mark.parametrize(
    ("draw", "seed"), [(lift_of_the_world, FORKS), (lift_of_the_world, DROPS), (lift_of_kinds, LANDS)]
)
def test_results_that_agree_at_loose_tolerances_are_not_accepted_when_slings_go_slack(
    draw: Draw, seed: int, accuracy: float
) -> None:
    answer, error = answered(draw, seed, accuracy)
    assert error <= max(accuracy, *answer.errors.values())
    assert bool(answer.notes) == (max(answer.errors.values()) > accuracy)


@pytest.mark.large
@pytest.mark.parametrize(("draw", "seed"), [(lift_of_the_world, DROPS), (lift_of_kinds, LANDS)])
def test_levels_with_waves_in_ropes_are_run_with_close_tolerances_when_ropes_go_slack(draw: Draw, seed: int) -> None:
    plan = parse(draw(seed).text, passing=True, followed=False).plan
    ladder, measuring = Ladder(plan), Measuring(MEANT)
    answer = choose(ladder, Question(MEANT, 0.1), measuring)
    assert answer.tolerance <= CLOSE or not ladder.waves(answer.fidelity)
    loose = [level for level, _, tolerance, _ in measuring.spent if tolerance > CLOSE and ladder.waves(level)]
    assert len(loose) == len({*loose}), "one run of a level shows that ropes go slack"


def test_a_swing_with_an_amplitude_that_counts_at_some_levels_only_leaves_no_period_uncompared() -> None:
    answer, error = answered(lift_of_kinds, ALMOST, 0.01)
    assert not answer.notes
    assert error <= 0.01


def answered(draw: Draw, seed: int, accuracy: float) -> tuple[Answer, float]:
    """The answer to a lift, and what it is wrong by."""
    plan = parse(draw(seed).text, passing=True, followed=False).plan
    ladder, measuring = Ladder(plan), Measuring(MEANT)
    answer = choose(ladder, Question(MEANT, accuracy), measuring)
    own = msgspec.structs.replace(at_level(plan, answer.fidelity), method=answer.method, tolerance=answer.tolerance)
    finest = msgspec.structs.replace(ladder.candidates(ladder.full[-1])[0].plan, tolerance=TRUE)
    return answer, largest(measuring.apart(ModelLevel(own), ModelLevel(finest)))


@pytest.mark.parametrize("scene", ["lift", "tandem", "hall", "pendulum", "floating"])
@pytest.mark.parametrize(
    "named", [{}, {"girder": "rigid"}, {"ropes": "rigid", "slings": "rigid"}, {"rope_mass": "none"}]
)
def test_a_model_level_is_compared_with_levels_that_include_every_effect_it_omits(
    scene: str, named: dict[str, str]
) -> None:
    plan = load(scene).plan
    ladder = Ladder(at_level(plan, Fidelity(**named)), list(named))  # type: ignore[arg-type]
    for level in ladder.levels:
        witnesses = ladder.witnesses(level)
        assert witnesses or level == ladder.full[-1] or len(ladder.full) == 1
        assert level not in witnesses
        for witness in witnesses:
            for key, order in FINER.items():
                assert order.index(getattr(witness, key)) >= order.index(getattr(level, key))
                assert len(ladder.full) == 1 or getattr(witness, key) == order[-1], "nothing is left out by both"


def test_numerical_damping_of_a_stiff_method_is_not_mistaken_for_physical_damping() -> None:
    plan = parse(lift_of_kinds(UNDAMPED).text, passing=True, followed=False).plan
    assert Ladder(plan).method == "dop853"
    assert Ladder(load("lift").plan).method == "radau5"


@pytest.mark.parametrize(("method", "accuracy"), [("", 0.1), ("", 1e-5), ("radau5", 0.1), ("radau5", 0.01)])
def test_the_phase_error_of_a_swing_over_hours_is_within_the_reported_error(method: str, accuracy: float) -> None:
    """An undamped swing of 60 degrees, 700 times: its energy says nothing of how late it is."""
    text = SWING.replace("END", f"{(lasts := 12_345.0)!r} s")
    plan = parse(text, passing=True, followed=False).plan
    plan = msgspec.structs.replace(plan, method=method or plan.method)
    ladder = Ladder(plan, ["method"] if method else [])
    answer = choose(ladder, Question(("position",), accuracy), Measuring(("position",)))
    run = play(msgspec.structs.replace(plan, method=answer.method, tolerance=answer.tolerance))
    k = np.sin(np.radians(30.0))
    _, cn, dn, _ = ellipj(np.sqrt(plan.gravity / 60.0) * lasts % (4.0 * ellipk(k * k)), k * k)
    exact = -2.0 * np.arcsin(k * cn / dn)
    (error,) = answer.errors.values()
    column = run.layout.find("joint/position")
    assert column is not None
    ends = run.rows[[0, -1], column.start]
    assert abs(ends[1] - exact) <= error * abs(ends[1] - ends[0]) + LONGEST
    assert bool(answer.notes) == (error > accuracy)


def test_a_choice_of_model_level_that_does_not_converge_reports_the_remaining_difference() -> None:
    plan = load("lift", ["end=40 s"]).plan
    answer = choose(Ladder(plan, ["ropes", "girder"]), Question(MEANT, 1e-3), Measuring(MEANT))
    assert answer.notes[0].startswith("not converged: asked to 0.1 %, what was run differs by ")
    assert max(answer.errors.values()) > 1e-3
    assert answer.fidelity.ropes == "elastic"
