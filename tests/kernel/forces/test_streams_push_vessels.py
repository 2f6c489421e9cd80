"""Wind and current by coefficients against closed forms; products of two wave sums against their double sum."""

from __future__ import annotations

import numpy as np
import pytest
from heavylift.kernel import KernelError
from heavylift.kernel.analysis import equilibrium
from heavylift.kernel.description import Body, Drive, InputSignal, Joint, JointSpring, Point, Stream, System, WaveSum
from scipy.optimize import brentq
from small_scenes import SECOND, X, column, cube, hand_over, imbalance, started

MASS, AREA, LENGTH, RHO, SPEED = 5.0e5, 440.0, 110.0, 1025.0, 1.5
TABLE = ((0.3, 0.0, 0.0), (0.25, 0.5, 0.05), (0.02, 0.9, 0.01), (-0.2, 0.55, -0.06), (-0.35, 0.0, 0.0))
PRESSURE = 0.5 * RHO * AREA * SPEED**2
ROUNDING, CLOSES = 1e-12, 1e-10


def current(to: float, table: tuple = TABLE, speed: float = SPEED, **change) -> Stream:
    """A current that flows in the direction `to` [rad]."""
    direction = (float(np.cos(to)), float(np.sin(to)), 0.0)
    given = {"area": AREA, "length": LENGTH, "direction": direction, "density": RHO, "coefficients": table}
    return Stream("current", signal=InputSignal(speed), **{"at": Point("hull"), **given, **change})


def free(*forces, bow: float = 0.0) -> System:
    """A hull on a free joint, its bow turned about z."""
    q0 = (0.0,) * 5 + (float(np.sin(0.5 * bow)), float(np.cos(0.5 * bow)))
    body = Body("hull", MASS, inertia=cube(MASS, 30.0))
    return System((body,), (Joint("free", "free", "world", "hull", q0=q0),), forces=forces, gravity=0.0)


def felt(to: float, bow: float = 0.0, table: tuple = TABLE) -> np.ndarray:
    """Force along and across the hull, and yaw moment, relative to pressure times area and length."""
    _, found = column(started(free(current(to, table), bow=bow)), "stream/force")
    return found[0] / (PRESSURE * np.array([1.0, 1.0, LENGTH]))


@pytest.mark.parametrize("side", [1, -1])
@pytest.mark.parametrize("bow", [0.0, 0.7])
def test_current_loads_follow_the_coefficients_of_their_direction_and_are_mirrored_for_the_other_side(
    side: int, bow: float
) -> None:
    for row, angle in zip(TABLE, np.linspace(0.0, np.pi, len(TABLE)), strict=True):
        want = np.array(row) * (1.0, side, side)
        assert felt(bow + side * angle, bow, TABLE) == pytest.approx(want, abs=1e-9)


def test_coefficients_of_current_forces_are_interpolated_trigonometrically_between_tabulated_directions() -> None:
    """Of a table made of three harmonics each direction has the exact value."""

    def exact(b: float) -> tuple[float, float, float]:
        x = 0.1 - 0.4 * np.cos(b) + 0.2 * np.cos(3 * b)
        return float(x), float(0.9 * np.sin(b) - 0.1 * np.sin(3 * b)), float(0.07 * np.sin(2 * b))

    table = tuple(exact(b) for b in np.linspace(0.0, np.pi, 13))
    for b in np.random.default_rng(3).uniform(-np.pi, np.pi, 8):
        assert felt(float(b), 0.4, table) == pytest.approx(exact(float(b) - 0.4), abs=1e-12)


def test_a_hull_drifting_with_a_current_gains_speed_as_the_closed_form_says() -> None:
    """m v' = k (U - v)^2: v = U - U / (1 + k U t / m); energy closes with the work of the current."""
    system = free(current(0.0))
    s = started(system, tolerance=1e-10, sample_ns=SECOND)
    s.run(60 * SECOND)
    t, v = column(s, "joint/velocity")
    k = 0.5 * RHO * AREA * 0.3
    want = SPEED - SPEED / (1.0 + k * SPEED * t / MASS)
    assert np.abs(v - want[:, None]).min(axis=1) == pytest.approx(0.0, abs=1e-8)
    assert want[-1] > 0.8 * SPEED
    assert imbalance(s) < CLOSES


def test_a_moored_hull_rests_where_its_spring_balances_the_drag() -> None:
    """k x = 1/2 rho A C U^2."""
    joint = Joint("surge", "prismatic", "world", "hull", axis=X, q0=(0.0,))
    mooring = JointSpring("mooring", "surge", 4.0e5)
    s = started(System((Body("hull", MASS),), (joint,), springs=(mooring,), forces=(current(0.0),), gravity=0.0))
    found = equilibrium(s)
    assert float(found.q[0]) == pytest.approx(0.3 * PRESSURE / 4.0e5, rel=1e-9)


@pytest.mark.parametrize("height", [8.0, -3.0])
def test_a_beam_stream_heels_a_hull_by_its_force_times_the_height_of_its_centre_of_pressure(height: float) -> None:
    """k phi = -h F cos^2 phi: the part of the stream across the heeled hull counts."""
    force, k = 0.9 * PRESSURE, 40.0 * abs(height) * PRESSURE
    joint = Joint("roll", "revolute", "world", "hull", axis=X, q0=(0.0,))
    stream = current(0.5 * np.pi, at=Point("hull", (0.0, 0.0, height)))
    spring = JointSpring("righting", "roll", k)
    s = started(System((Body("hull", MASS, inertia=cube(MASS, 30.0)),), (joint,), springs=(spring,), forces=(stream,),
                       gravity=0.0))  # fmt: skip
    want = brentq(lambda phi: k * phi + height * force * np.cos(phi) ** 2, -0.5, 0.5, xtol=1e-14)
    assert float(equilibrium(s).q[0]) == pytest.approx(want, rel=1e-9)
    assert abs(want) > 0.01


BAD = {
    "must be a unit vector": {"direction": (1.0, 1.0, 0.0)},
    "are those of less than two directions": {"table": ((0.0, 0.0, 0.0),)},
    "must be zero at 0 and at 180 degrees": {"table": ((0.3, 0.1, 0.0), (0.3, 0.0, 0.0))},
    "density is -1": {"density": -1.0},
}


@pytest.mark.parametrize("sentence", BAD)
def test_impossible_wind_and_current_data_are_refused_in_one_sentence(sentence: str) -> None:
    with pytest.raises(KernelError, match=sentence):
        started(free(current(0.0, **BAD[sentence])))


def test_the_slowly_varying_product_of_two_wave_sums_contains_only_difference_frequencies() -> None:
    """Newman's form: r^2 sum_i sum_j a_i b_j cos((w_i - w_j) t + p_i - q_j)."""
    random, n, ramp, piece = np.random.default_rng(5), 12, 5.0, 0.2
    w = np.sort(random.uniform(0.4, 1.6, n))
    A, B = (random.normal(size=n) * np.exp(1j * random.uniform(0.0, 6.0, n)) for _ in range(2))
    parts = [(tuple(x.real.tolist()), tuple((-x.imag).tolist())) for x in (A, B)]
    waves = WaveSum(tuple(w.tolist()), *parts[0], ramp, piece, parts[1])
    joint = Joint("heave", "prismatic", "world", "hull", axis=X, q0=(0.0,))
    drive = Drive("follow", "heave", "prescribed", waves=waves)
    s = started(System((Body("hull", MASS),), (joint,), drives=(drive,), gravity=0.0), tolerance=1e-6)
    size = float(np.abs(A).sum() * np.abs(B).sum())
    for t in (1.3, 3.7, 9.1, 40.3, 77.7):
        hand_over(s, round(t * 1e9))
        u = min(t / ramp, 1.0)
        r = u**3 * (10 - 15 * u + 6 * u * u)
        phases = np.exp(1j * np.subtract.outer(w, w) * t)
        want = r * r * float((np.outer(A, B.conj()) * phases).real.sum())
        assert float(s.row().q[0]) == pytest.approx(want, abs=(1.6 * piece) ** 4 / 384.0 * size)
