"""`wind:` of a scene blows on the block, and on other bodies whose sides are given; gusts have their spectrum."""

import numpy as np
import pytest
from heavylift import simulate
from heavylift.kernel import SceneError
from heavylift.kernel.description import Wind
from heavylift.nodes.scene import load
from heavylift.nodes.scene.keys import turbulent
from scipy.signal import welch

ALONG = "wind={speed: 15 m/s, direction: [1, 0, 0]}"
FORCE = 0.5 * 1.225 * 1.2 * (16 * 8) * 15**2  # [N] on the side of the bundled lift's block
LEANS = 1e-3  # the block leans by 0.2 mrad as it parts, and shows of its face of 320 m2
SLOW = 1e-4  # the block moves at less than a thousandth of the wind's speed
HOUR, RUNS = 3600.0, 20
SCATTER = 0.1  # of a spectrum's mean over a band, of so many hours


def test_the_wind_force_on_a_block_depends_on_the_areas_of_its_sides() -> None:
    wind = load("lift", [ALONG]).plan.machines[-1].system.forces
    assert [(x.name, x.at.body) for x in wind] == [("wind.block", "block")]
    assert isinstance(wind[0], Wind)
    assert (wind[0].sides, wind[0].drag, wind[0].direction) == ((128.0, 160.0, 320.0), 1.2, (1.0, 0.0, 0.0))


def test_wind_along_the_rails_is_held_by_the_gantry_drive() -> None:
    """The sum of the horizontal forces on all that hangs from the crane is 0 wherever the lift comes to rest."""
    uses = load("lift", [ALONG]).uses
    held = next(u.value for u in uses if (u.limit.subject, u.limit.quantity) == ("crane", "side force"))
    assert held == pytest.approx(FORCE, rel=LEANS)


def test_the_wind_during_a_run_is_recorded_and_checked_against_its_limit() -> None:
    result = simulate(load("lift", [ALONG, "end=2 s"]))
    assert result["wind/force"]["wind.block"][0] == pytest.approx(FORCE, rel=SLOW)


def test_a_turbulent_wind_has_its_mean_standard_deviation_and_spectrum() -> None:
    """EN 1991-1-4, B.1; estimated by Welch's method from hours of twenty seeds."""
    mean, deviation, scale = 15.0, 2.25, 130.0
    power = np.zeros(513)
    for seed in range(RUNS):
        t, v = np.array(turbulent(mean, deviation / mean, scale, seed, HOUR)).T
        assert np.array_equal(t, np.arange(len(t)))
        n, found = welch(v - mean, 1.0, nperseg=1024, detrend=False)
        power += found / RUNS
    f = n[1:] * scale / mean
    expected = deviation**2 / n[1:] * 6.8 * f / (1.0 + 10.2 * f) ** (5.0 / 3.0)
    for band in (slice(4, 10), slice(10, 40), slice(40, 150), slice(150, 510)):
        assert np.mean(power[1:][band] / expected[band]) == pytest.approx(1.0, abs=SCATTER)


def test_the_seed_of_a_scene_determines_its_gusts() -> None:
    def history(seed: int) -> tuple[float, ...]:
        settings = [ALONG, "wind.turbulence=15 %", f"seed={seed}"]
        force = load("lift", settings).plan.machines[-1].system.forces[0]
        assert isinstance(force, Wind)
        return force.signal.values

    assert history(1) == history(1)
    assert history(1) != history(2)


@pytest.mark.parametrize(
    ("setting", "sentence"),
    [
        ("wind.on={boom: {sides: [1 m2, 2 m2, 3 m2]}}", "wind.on.boom: there is no body 'boom'"),
        ("wind.direction=[0, 0, 0]", "wind: the direction of the wind is a zero vector"),
        ("wind.turbulence=60 %", "wind.turbulence: 0.5 or less is needed here, not 60 %"),
        ("wind={speed: 9 m/s, direction: [1, 0, 0], gusts: [[0 s, 9 m/s]], turbulence: 0.1}", "either 'gusts' or"),
    ],
)
def test_an_invalid_wind_is_reported(setting: str, sentence: str) -> None:
    with pytest.raises(SceneError, match=sentence.replace("[", r"\[")):
        load("lift", [ALONG, setting])


def test_a_mechanism_named_wind_is_refused_if_the_scene_has_wind() -> None:
    with pytest.raises(SceneError, match=r"mechanism\.name: 'wind' is reserved for the wind"):
        load("gust", ["mechanism.name=wind", ALONG, "wind.on={load: {sides: [1 m2, 1 m2, 1 m2]}}"])


def test_a_scene_that_has_wind_but_no_block_must_name_the_bodies_in_the_wind() -> None:
    with pytest.raises(SceneError, match="wind: there is no block"):
        load("pendulum", [ALONG])
