"""Wave spectra and their components against closed forms and statistics."""

import numpy as np
import pytest
from heavylift.nodes.scene.keys import Sea
from heavylift.nodes.sea import HIGHEST, LOWEST, components, jonswap, pierson_moskowitz, torsethaugen
from pydantic import ValidationError
from scipy.integrate import quad

HS, TP = 2.5, 9.0
PEAK = 2.0 * np.pi / TP
AGAIN = 0.5  # of the autocorrelation: what some sixty waves in the peak may have in common by chance


def test_the_pierson_moskowitz_spectrum_has_the_energy_and_mean_period_of_the_standard():
    """m0 = Hs^2 / 16; Tz = 0.7104 Tp and T1 = 0.7718 Tp (DNV-RP-C205, 3.5.4.5)."""
    m0, m1, m2 = (quad(lambda w, n=n: w**n * pierson_moskowitz(w, HS, TP), 0.05, 60.0, limit=500)[0] for n in range(3))
    assert m0 == pytest.approx(HS * HS / 16.0, rel=1e-6)
    assert 2 * np.pi * np.sqrt(m0 / m2) == pytest.approx(0.7104 * TP, rel=2e-3)
    assert 2 * np.pi * m0 / m1 == pytest.approx(0.7718 * TP, rel=2e-3)


@pytest.mark.parametrize("gamma", [1.0, 2.0, 3.3, 5.0])
def test_the_jonswap_spectrum_agrees_with_the_formula_of_dnv_rp_c205(gamma):
    """The factor 1 - 0.287 ln gamma of DNV-RP-C205, 3.5.5.2 is the one that gives the energy, to 1.5 %."""
    m0 = quad(lambda w: jonswap(w, HS, TP, gamma), 0.05, 60.0, limit=800, points=[PEAK])[0]
    assert HS * HS / 16.0 / m0 == pytest.approx(1.0 - 0.287 * np.log(gamma), rel=1.5e-2)
    assert jonswap(PEAK, HS, TP, gamma) == pytest.approx(gamma * pierson_moskowitz(PEAK, HS, TP))


@pytest.mark.parametrize("spreading", [0.0, 2.0, 10.0])
@pytest.mark.parametrize("seed", range(5))
def test_wave_components_have_the_moments_of_their_spectrum(seed, spreading):
    """Their energy is that of Hs exactly, their mean frequency that of the spectrum to what 300 random ones allow."""
    ends = LOWEST * PEAK, HIGHEST * PEAK
    found = components(lambda w: jonswap(w, HS, TP, 3.3), HS, ends, 300, 0.7, spreading, f"{seed} sea")
    energy = [0.5 * x.amplitude**2 for x in found]
    assert sum(energy) == pytest.approx(HS * HS / 16.0, rel=1e-12)
    m0, m1 = (quad(lambda w, n=n: w**n * jonswap(w, HS, TP, 3.3), *ends, limit=800, points=[PEAK])[0] for n in (0, 1))
    mean = sum(e * x.frequency for e, x in zip(energy, found, strict=True)) / sum(energy)
    assert mean == pytest.approx(m1 / m0, rel=0.02)
    assert [x.frequency for x in found] == sorted({x.frequency for x in found}), "no two are alike"
    away = np.array([x.direction - 0.7 for x in found])
    if spreading:  # E cos(theta) of cos^2s(theta / 2) is s / (s + 1)
        assert np.cos(away).mean() == pytest.approx(spreading / (spreading + 1.0), abs=0.12)
    else:
        assert not away.any()


def test_the_seed_of_a_scene_determines_the_realisation_of_its_sea():
    def sea(seed):
        return components(lambda w: pierson_moskowitz(w, HS, TP), HS, (0.4, 1.5), 50, 0.0, 4.0, seed)

    assert sea("1 wind") == sea("1 wind")
    assert sea("1 wind") != sea("2 wind")
    assert sea("1 wind") != sea("1 swell")


@pytest.mark.parametrize("seed", ["1", "2", "3"])
def test_a_sea_of_random_frequencies_does_not_repeat_itself_within_three_hours(seed: str):
    """Its autocorrelation over lags after a minute; with frequencies in equal steps it is 1 again after one period."""
    ends = LOWEST * PEAK, HIGHEST * PEAK
    sea = components(lambda w: jonswap(w, HS, TP, 3.3), HS, ends, 200, 0.0, 0.0, seed)
    w, power = np.array([x.frequency for x in sea]), np.array([x.amplitude**2 for x in sea])
    lags = np.arange(60.0, 3.0 * 3600.0, 0.5)

    def alike(w: np.ndarray) -> float:
        return float(max((np.cos(np.outer(part, w)) @ power).max() for part in np.array_split(lags, 20)) / power.sum())

    step = 2.0 * np.pi / 700.0  # [rad/s]
    assert alike(np.round(w / step) * step) == pytest.approx(1.0)
    assert alike(w) < AGAIN


@pytest.mark.parametrize(("Hs", "Tp"), [(2.0, 6.0), (4.0, 8.0), (2.0, 14.0), (4.0, 18.0)])
def test_the_torsethaugen_spectrum_has_the_energy_of_its_two_peaks(Hs, Tp):
    """Below 6.6 Hs^(1/3) the wind sea has the period Tp; each peak has its energy, and its maximum at its period."""
    peaks = torsethaugen(Hs, Tp)
    assert (peaks[0].Tp, peaks[0].Tp < peaks[1].Tp) == (Tp, Tp <= 6.6 * Hs ** (1 / 3))
    for x in peaks:
        w = (np.linspace(1.0, 12.0, 2000) / x.Tp).tolist()
        assert w[np.argmax([x.density(y) for y in w])] == pytest.approx(2 * np.pi / x.Tp, rel=0.01)
    sea = Sea.model_validate({"Hs": f"{Hs} m", "Tp": f"{Tp} s", "spectrum": "torsethaugen"}).harmonics(0.0, "1")
    energy = [sum(0.5 * x.amplitude**2 for x in part) for part in (sea[:100], sea[100:])]
    assert energy == pytest.approx([x.Hs**2 / 16 for x in peaks])
    assert sum(energy) == pytest.approx(Hs * Hs / 16)


def test_a_fully_developed_sea_has_one_spectral_peak():
    """At the period of a fully developed sea, no energy is left for the second peak."""
    first, second = torsethaugen(3.0, 6.6 * 3.0 ** (1 / 3))
    assert (first.Hs, second.Hs) == (pytest.approx(3.0), pytest.approx(0.0, abs=1e-6))


def test_a_tabulated_spectrum_gives_components_with_its_height_and_mean_frequency():
    sea = Sea.model_validate({"Hs": "2 m", "table": [["0.06 Hz", 0], ["0.1 Hz", 8], ["0.14 Hz", 3], ["0.2 Hz", 0]]})
    found = sea.harmonics(0.0, "1")
    energy = np.array([0.5 * x.amplitude**2 for x in found])
    assert energy.sum() == pytest.approx(0.25)
    f, S = np.array([0.06, 0.1, 0.14, 0.2]), np.array([0.0, 8.0, 3.0, 0.0])
    fine = np.linspace(0.06, 0.2, 5001)
    mean = np.trapezoid(fine * np.interp(fine, f, S), fine) / np.trapezoid(np.interp(fine, f, S), fine)
    assert np.dot(energy, [x.frequency for x in found]) / energy.sum() / (2 * np.pi) == pytest.approx(mean, rel=0.01)


ONE, ZERO, FALLING = [["0.1 Hz", 1]], [["0.1 Hz", 0], ["0.2 Hz", 0]], [["0.2 Hz", 1], ["0.1 Hz", 1]]


@pytest.mark.parametrize(
    "keys", [{}, {"Tp": "8 s", "table": FALLING[::-1]}, {"table": ONE}, {"table": FALLING}, {"table": ZERO}]
)
def test_a_sea_with_no_spectrum_or_two_spectra_is_refused(keys):
    with pytest.raises(ValidationError):
        Sea.model_validate({"Hs": "2 m"} | keys)
