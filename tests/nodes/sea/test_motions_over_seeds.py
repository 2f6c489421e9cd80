"""Motions of a barge over seeds of an irregular sea, against spectral moments in the frequency domain."""

from __future__ import annotations

import numpy as np
import pytest
from heavylift.coordinator.record import play
from heavylift.nodes.scene import parse
from heavylift.nodes.scenes import vessels_folder
from heavylift.nodes.sea import Hydrodynamics, extreme, jonswap, read_hydrodynamics
from scipy.stats import rayleigh, t as student

SCENE = """\
heavylift: 1
name: sea
seed: %d
end: %g s
samples: 4 Hz
method: dopri5
waves: {seas: {wind: {Hs: 0.4 m, Tp: 9 s, components: 100}}, heading: 150 deg, ramp: 40 s}
vessels:
  barge:
    mass: 14432 t
    size: [110 m, 32 m, 8 m]
    draught: 4 m
    com: [0 m, 0 m, 2 m]
    inertia: [1.4e6 t m2, 15e6 t m2, 15e6 t m2]
    motion: forces
    floating: {hydrodynamics: barge-110, mooring: {surge: 400 kN/m, sway: 400 kN/m, yaw: 400 MN m/rad}}
actions: [{wait: 1 s}]
"""
G, MASS, C, HS, TP, HEADING = 9.80665, 14432e3, 2.0, 0.4, 9.0, np.radians(150.0)
SURE = 0.99  # of an interval about a mean over seeds, which are fixed
BIAS = 0.02  # of a moment: rates are differences of samples
GROUPS = 0.05  # by which peaks that come in groups are smaller at most than independent ones
BEGUN = 100.0  # [s] when the start has died away


def heave_and_pitch(of: Hydrodynamics, w: float) -> np.ndarray:
    """(2,) motion per wave amplitude by linear algebra."""
    M = np.diag([MASS] * 3 + [1.4e9, 15e9, 15e9])
    M[3, 3], M[4, 4] = M[3, 3] + MASS * C * C, M[4, 4] + MASS * C * C
    M[0, 4] = M[4, 0] = MASS * C
    M[1, 3] = M[3, 1] = -MASS * C
    K = np.diag([4e5, 4e5, of.density * G * of.waterplane, *(MASS * G * (z - C) for z in of.metacentres), 4e8])
    F, R = np.array(of.radiation.F), np.array(of.radiation.G)
    memory = R.T @ np.linalg.solve(1j * w * np.eye(len(F)) - F, R.astype(complex))
    impedance = -w * w * (M + np.array(of.added_mass)) + 1j * w * memory + K
    return np.linalg.solve(impedance, np.array(of.load(w, HEADING)))[[2, 4]]


def moments() -> np.ndarray:
    """(2, 2) moments m0 and m2 of heave [m2, m2/s2] and pitch [rad2, rad2/s2]."""
    path = vessels_folder() / "barge-110.json"
    of = read_hydrodynamics(path.read_bytes(), path.name)
    w = np.linspace(0.4, 4.0, 800) * 2.0 * np.pi / TP
    S = np.array([jonswap(x, HS, TP, 3.3) for x in w.tolist()])
    S *= HS * HS / 16.0 / np.trapezoid(S, w)
    square = np.abs([heave_and_pitch(of, x) for x in w.tolist()]).T ** 2
    return np.array([[np.trapezoid(w**n * S * x, w) for n in (0, 2)] for x in square])


def motion(seed: int, end: float) -> tuple[np.ndarray, np.ndarray]:
    """Times (n,) [s] and heave and pitch (2, n) of one seed."""
    run = play(parse(SCENE % (seed, end)).plan)
    pose = run.past.part(0, len(run.t)).poses["barge"]
    kept = run.t > BEGUN
    return run.t[kept], np.array([pose[kept, 2], 2.0 * pose[kept, 4]])


@pytest.mark.parametrize(("seeds", "end"), [(6, 300.0), pytest.param(30, 700.0, marks=pytest.mark.large)])
def test_statistics_of_motions_over_seeds_agree_with_the_frequency_domain(seeds: int, end: float) -> None:
    """Mean variances of motions and their rates lie within the confidence of as many seeds; the most probable maximum
    by Gumbel's distribution is that of Rayleigh's peaks."""
    found, largest = [], []
    for seed in range(1, seeds + 1):
        t, x = motion(seed, end)
        rate = np.gradient(x, t, axis=1)
        found.append([np.mean(x * x, axis=1), np.mean(rate * rate, axis=1)])
        largest.append(x[0].max())
    want, found = moments().T, np.array(found)
    half = student.ppf(0.5 + 0.5 * SURE, seeds - 1) * found.std(axis=0, ddof=1) / np.sqrt(seeds)
    assert (np.abs(found.mean(axis=0) - want) < half + BIAS * want).all()
    assert (half < want).all(), "the interval says something"
    m0, m2 = want[:, 0]
    peaks = (end - BEGUN) / (2.0 * np.pi * np.sqrt(m0 / m2))
    for part in (1.0 / np.e, 0.9) if seeds >= 30 else ():
        found, ideal = extreme(largest, part), rayleigh.ppf(part ** (1.0 / peaks), scale=np.sqrt(m0))
        assert (1.0 - GROUPS) * ideal - found.above < found.value < ideal + found.above
