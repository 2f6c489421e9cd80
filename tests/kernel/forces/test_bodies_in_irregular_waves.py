"""Irregular waves as cubic pieces, and radiation with memory, against sums, convolutions and SciPy."""

import numpy as np
import pytest
from heavylift.kernel import KernelError
from heavylift.kernel.description import (
    Body,
    Drive,
    InputSignal,
    Joint,
    JointSpring,
    Load,
    Point,
    Radiation,
    System,
    WaveSum,
)
from scipy.integrate import quad, simpson, solve_ivp
from scipy.linalg import expm
from small_scenes import SECOND, cube, hand_over, started

RAMP, PIECE = 10.0, 0.25
MASS, STIFFNESS = 2000.0, 1500.0


def sea(n: int = 60, seed: int = 1, piece: float = PIECE) -> WaveSum:
    """Harmonics between 0.3 and 2 rad/s with random amplitudes and phases."""
    random = np.random.default_rng(seed)
    w = np.sort(random.uniform(0.3, 2.0, n))
    a, b = random.normal(size=(2, n)) / np.sqrt(n)
    return WaveSum(tuple(w.tolist()), tuple(a.tolist()), tuple(b.tolist()), RAMP, piece)


def elevation(waves: WaveSum, t: float) -> float:
    """The sum of a sea, by its formula."""
    w, a, b = map(np.array, (waves.frequencies, waves.cosines, waves.sines))
    u = min(t / waves.ramp, 1.0)
    return float(u**3 * (10 - 15 * u + 6 * u * u) * (a @ np.cos(w * t) + b @ np.sin(w * t)))


def heaving(*forces, **fields) -> System:
    """A mass on a spring that heaves."""
    body = Body("hull", MASS, inertia=cube(MASS, 3.0))
    return System(
        (body,),
        (Joint("heave", "prismatic", "world", "hull", axis=(0.0, 0.0, 1.0), q0=fields.pop("q0", (0.0,))),),
        springs=(JointSpring("buoyancy", "heave", STIFFNESS),),
        forces=forces,
        gravity=0.0,
        **fields,
    )


def pushed(waves: WaveSum) -> Load:
    return Load("wave", Point("hull"), force=(0.0, 0.0, 1000.0), signal=InputSignal(0.0, waves=waves))


@pytest.mark.parametrize("method", ["dopri5", "radau5"])
def test_a_mass_in_irregular_waves_moves_as_scipy_integrates_it(method):
    """200 s of a load of 60 harmonics: SciPy on the exact sum agrees to the error of the cubic pieces."""
    waves = sea()
    s = started(heaving(pushed(waves)), tolerance=1e-9, method=method)
    hand_over(s, 200 * SECOND)
    found = solve_ivp(
        lambda t, y: [y[1], (1000.0 * elevation(waves, t) - STIFFNESS * y[0]) / MASS],
        (0.0, 200.0), [0.0, 0.0], rtol=1e-10, atol=1e-12, method="DOP853",
    )  # fmt: skip
    stated = (max(waves.frequencies) * PIECE) ** 4 / 384.0
    most = np.abs(found.y[0]).max()
    assert abs(float(s.row().q[0]) - found.y[0, -1]) < 10.0 * stated * most
    assert most > 1.0


@pytest.mark.parametrize("piece", [0.5, 0.25, 0.125])
def test_piecewise_cubics_of_irregular_waves_stay_within_their_stated_error(piece):
    """Between knots the cubic misses the sum by at most (w h)^4 / 384 of all amplitudes, and uses it up by half."""
    waves = sea(piece=piece)
    system = heaving(drives=(Drive("follow", "heave", "prescribed", waves=waves),))
    s = started(system, tolerance=1e-6)
    w, a, b = map(np.array, (waves.frequencies, waves.cosines, waves.sines))
    stated = float(np.hypot(a, b) @ (w * piece) ** 4 / 384.0)
    worst = 0.0
    for k in range(1, 120):
        hand_over(s, round((15.0 + (k + 0.5) * piece) * 1e9))
        worst = max(worst, abs(float(s.row().q[0]) - elevation(waves, 15.0 + (k + 0.5) * piece)))
    assert stated / 40.0 < worst < stated


F = np.array([[-0.6, 1.1, 0.2], [-0.9, -0.4, 0.3], [-0.3, -0.1, -1.2]])  # its symmetric part takes energy
G = np.zeros((3, 6))
G[:, 2] = 25.0, -4.0, 12.0


def water(**change) -> Radiation:
    return Radiation("water", Point("hull"), **{"F": _rows(F), "G": _rows(G), **change})


def _rows(A: np.ndarray) -> tuple:
    return tuple(map(tuple, A.tolist()))


def memory(t: float) -> float:
    """The memory K(t) in heave."""
    return float(G[:, 2] @ expm(F * t) @ G[:, 2])


@pytest.mark.parametrize("method", ["dopri5", "radau5"])
def test_free_decay_of_a_floating_body_with_radiation_memory_solves_its_integral_equation(method):
    """m x'' + k x + int K(t - s) x'(s) ds = 0 holds along the run, with the integral by quadrature; energy closes."""
    s = started(heaving(water(), q0=(1.0,)), tolerance=1e-10, method=method)
    start = s.row()
    step = 0.05
    speeds, places = [0.0], [1.0]
    for k in range(1, 401):
        hand_over(s, round(k * step * 1e9))
        row = s.row()
        speeds.append(float(row.v[0]))
        places.append(float(row.q[0]))
    history = np.array(speeds)
    for k in (100, 237, 400):
        K = np.array([memory(step * (k - i)) for i in range(k + 1)])
        felt = simpson(K * history[: k + 1], dx=step)
        acceleration = -(STIFFNESS * places[k] + felt) / MASS
        five = (
            (8 * (history[k + 1] - history[k - 1]) - (history[k + 2] - history[k - 2])) / (12 * step)
            if k < 400
            else None
        )
        if five is not None:
            assert five == pytest.approx(acceleration, abs=2e-6)
    assert abs(places[-1]) < 0.5
    row = s.row()
    gained = sum(
        (1.0 if what == "heat" else -1.0) * float(x)
        for (what, _), x in zip(s.program.accounts, row.accounts, strict=True)
    )
    energy = float(row.kinetic + sum(row.stored)) + gained
    assert energy == pytest.approx(float(start.kinetic + sum(start.stored)), rel=1e-8)


def test_the_damping_of_a_radiation_memory_function_is_its_fourier_transform():
    """In steady oscillation the force has B = Re K(iw) in phase with the speed (Ogilvie 1964)."""
    w = 0.9
    lapse = quad(lambda t: memory(t) * np.cos(w * t), 0.0, 60.0, limit=500)[0]
    transform = G[:, 2] @ np.linalg.solve(1j * w * np.eye(3) - F, G[:, 2])
    assert lapse == pytest.approx(transform.real, rel=1e-6)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"G": _rows(G[:2])}, "a row of G for each"),
        ({"F": _rows(-F)}, "makes energy from nothing"),
        ({"R": ((2.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))}, "not a rotation"),
    ],
)
def test_impossible_radiation_data_are_refused(change, words):
    with pytest.raises(KernelError, match=words):
        started(heaving(water(**change)))


@pytest.mark.parametrize(
    ("waves", "words"),
    [
        (WaveSum((1.0,), (1.0,), (), RAMP, PIECE), "one cosine and one sine"),
        (WaveSum((1.0,), (1.0,), (1.0,), 0.0, PIECE), "ramp"),
    ],
)
def test_impossible_wave_data_are_refused(waves, words):
    with pytest.raises(KernelError, match=words):
        started(heaving(pushed(waves)))
