"""`--vary` and `--sample`: paths as errors print them, ranges in steps, alternatives, draws of uncertain inputs."""

from __future__ import annotations

import numpy as np
import pytest
from heavylift.coordinator.sweeps.sweeping import planned
from heavylift.kernel import SceneError
from heavylift.nodes.scene import load

UNCERTAIN = ["block.mass=300 t +- 6 %", "rig.loaders.loader-1.sling=9.9..10.1 m"]


@pytest.fixture(scope="module")
def lift():
    return load("lift")


@pytest.fixture(scope="module")
def unsure():
    return load("lift", UNCERTAIN)


def settings(scene, *vary: str) -> list[tuple[str, ...]]:
    return [variant.settings for variant in planned(scene, vary).variants]


def test_a_varied_range_of_decimal_numbers_contains_exactly_the_stated_values(lift) -> None:
    assert settings(lift, "block.mass=0..0.3 t by 0.1 t") == [
        ("block.mass=0 t",),
        ("block.mass=0.1 t",),
        ("block.mass=0.2 t",),
        ("block.mass=0.3 t",),
    ]
    assert settings(lift, "block.mass=200 t..260 t by 25") == [
        ("block.mass=200 t",),
        ("block.mass=225 t",),
        ("block.mass=250 t",),
    ]


def test_several_varied_ranges_give_all_combinations_of_their_values(lift) -> None:
    found = planned(
        lift, ["block.mass={200 t, 300 t}", "stage up/all hooks={hoist 1 m/min by 1 m, hoist 3 m/min by 1 m}"]
    )
    assert [variant.values for variant in found.variants] == [(200.0, 0.0), (200.0, 1.0), (300.0, 0.0), (300.0, 1.0)]
    assert found.variants[1].settings == ("block.mass=200 t", "stage up/all hooks=hoist 3 m/min by 1 m")
    assert [axis.label for axis in found.axes] == ["block.mass [t]", "stage up/all hooks"]


def test_a_list_of_positions_gives_one_variant_for_each_position(lift) -> None:
    assert settings(lift, "block.at={[40 m, 75 m, 6 m], [41 m, 75 m, 6 m]}") == [
        ("block.at=[40 m, 75 m, 6 m]",),
        ("block.at=[41 m, 75 m, 6 m]",),
    ]


def test_a_study_can_vary_a_coordinate_that_the_scene_does_not_state(lift) -> None:
    (first, second), *_ = settings(lift, "block.com.x={0.1 m, 0.2 m}")
    assert load("lift", [first, second]).scene.block.com == (0.1, 0.0, 0.0)


@pytest.mark.parametrize(
    ("setting", "speed", "by"),
    [
        ("actions[2].all hooks=hoist 1 m/min by 2 m", 1, 2),
        ("stage up/all hooks=hoist 1 m/min by 2 m", 1, 2),
        ("stage up/all hooks/by=2.5 m", 3, 2.5),
        ("actions[2].all hooks.hoist=2 m/min", 2, 1),
    ],
)
def test_a_study_can_vary_actions_and_their_parameters_by_path(setting: str, speed: float, by: float) -> None:
    order = load("lift", [setting]).plan.actions[2].orders[0]
    assert (order.speed, order.by) == (pytest.approx(speed / 60.0), -by)


@pytest.mark.parametrize("path", ["block.at[0]", "block.at.x"])
def test_a_study_can_vary_one_number_of_a_list(path: str) -> None:
    assert load("lift", [f"{path}=40.5 m"]).scene.block.at == (40.5, 75.0, 6.0)


@pytest.mark.parametrize(
    ("vary", "told"),
    [
        ("block.mass", "write PATH=VALUES"),
        ("block.mass=400..200 t by 25 t", "the range is empty"),
        ("block.mass=200..400 t by 0 t", "the range is empty"),
        ("block.mass=200..400 t by 25 kg", "use a single unit, t or kg"),
        ("block.mass=200..400 t", "give the step size"),
        ("block.mass={}", "the braces are empty"),
        ("block.mas={1 t, 2 t}", "unknown key 'mas'"),
        ("actions[9].all hooks={hoist 1 m/min by 1 m}", "the scene has no place"),
        ("stage upp/all hooks/by=1..2 m by 1 m", "there is no stage 'upp'"),
        ("rig.loaders.loader-9.sling=9..10 m by 1 m", "loader-9"),
        ("block.mass={heavy, light}", "block.mass"),
        ("block.mass=1..2 t by 0.0000001 t", "at most 1000000"),
    ],
)
def test_inputs_that_cannot_be_varied_are_reported_in_one_sentence(lift, vary: str, told: str) -> None:
    with pytest.raises(SceneError) as found:
        planned(lift, [vary])
    assert told in str(found.value)


def test_a_study_without_varied_inputs_is_refused(lift) -> None:
    with pytest.raises(SceneError, match="nothing is varied"):
        planned(lift)
    with pytest.raises(SceneError, match="states no uncertain input"):
        planned(lift, sample=10)
    with pytest.raises(SceneError, match="varied twice"):
        planned(lift, ["block.at[0]={1 m, 2 m}", "block.at.x={3 m, 4 m}"])


def test_uncertain_inputs_are_sampled_from_their_stated_distribution(unsure) -> None:
    found = planned(unsure, sample=1000, design="lhs", seed=7)
    mass, sling = np.array([variant.values for variant in found.variants]).T
    assert (mass.mean(), mass.std()) == (pytest.approx(300.0, rel=1e-3), pytest.approx(9.0, rel=0.02))
    assert (sling.min(), sling.max()) == (pytest.approx(9.9, abs=3e-4), pytest.approx(10.1, abs=3e-4))
    again = planned(unsure, sample=1000, design="lhs", seed=7)
    assert again.variants == found.variants
    assert planned(unsure, sample=1000, design="lhs", seed=8).variants != found.variants


def test_a_sobol_design_has_at_most_the_requested_number_of_runs(unsure) -> None:
    found = planned(unsure, ["stage up/all hooks/hoist=1..3 m/min"], sample=100)
    assert len(found.axes) == 3
    assert len(found.variants) == 16 * 5
    with pytest.raises(SceneError, match="needs at least 5 runs"):
        planned(unsure, ["stage up/all hooks/hoist=1..3 m/min"], sample=4)
