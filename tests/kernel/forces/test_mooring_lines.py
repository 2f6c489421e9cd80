"""Mooring lines against MoorPy, the differential equation of a cable, and closed forms; they lift off and part."""

from __future__ import annotations

import numpy as np
import pytest
from heavylift.kernel import KernelError
from heavylift.kernel.compiler import Function, Library, derivatives, module
from heavylift.kernel.description import Body, Drive, Joint, MooringLine, Point, System
from heavylift.kernel.forces import hanging, line_shape, lying
from msgspec import structs
from scipy.integrate import solve_bvp
from scipy.optimize import brentq
from small_scenes import SECOND, Z, column, cube, events, hand_over, imbalance, started, times

G = 9.80665
CLOSE = 1e-9  # of the length: what rounding leaves of the ends that a line misses
PEER = 1e-6  # relative: MoorPy stops its iteration there
SLOPE = 1e-5  # relative, of derivatives against differences
TOLERANCE, BALANCE = 1e-9, 5e-7  # of a step, and of the energy that its steps turn over
LINE = MooringLine("line", Point("world", (420.0, 30.0, -100.0)), Point("hull", (5.0, 0.0, 0.0)), 450.0, 6e8, 140.0)


def random_lines(n: int, seed: int, lifted: bool) -> np.ndarray:
    """(n, 3) distances x and z and softness k of lines that hang from both ends, or of which a part lies."""
    random = np.random.default_rng(seed)
    k = 0.5 * 10.0 ** random.uniform(-6.0, -1.5, n)
    if lifted:
        z = random.uniform(-0.95, 0.95, n)
        chord = np.where(random.random(n) < 0.5, random.uniform(0.1, 1.1, n), 1.0 + random.normal(0.0, 1e-3, n))
        return np.array([np.sqrt(np.maximum(chord**2 - z**2, 1e-4)), z, k]).T
    H, V = 10.0 ** random.uniform(-4.0, 1.0, n), random.uniform(0.05, 0.95, n)
    z = np.sqrt(H * H + V * V) - H + k * V * V
    return np.array([1.0 - V + H * np.arcsinh(V / H) + 2.0 * k * H, z, k]).T


@pytest.mark.parametrize("lifted", [True, False])
def test_end_forces_of_random_mooring_lines_satisfy_the_catenary_equations(lifted: bool) -> None:
    for x, z, k in random_lines(2000, 1, lifted):
        f = (hanging if lifted else lying)(x, z, k)
        H, V, low = f.H, f.V, f.V - 1.0 if lifted else 0.0
        part = V - low
        away = 1.0 - part + H * (np.arcsinh(V / H) - np.arcsinh(low / H)) + 2.0 * k * H
        high = np.hypot(H, V) - np.hypot(H, low) + k * (V * V - low * low)
        assert (away, high) == pytest.approx((x, z), abs=CLOSE)


@pytest.mark.parametrize("lifted", [True, False])
def test_catenary_equations_agree_in_machine_code_and_interpreted_python_and_have_exact_derivatives(
    lifted: bool,
) -> None:
    law = hanging if lifted else lying
    code = Function("solved", lambda p: {"y": [*law(*p)[:2]]}, {"p": 3})
    native = Library(f"catenary {lifted}", lambda: module(code), cache=False)
    for p in np.ascontiguousarray(random_lines(20, 2, lifted)):
        y = np.zeros(2)
        native.call("solved", p, y)
        assert y.tolist() == [*law(*p.tolist())[:2]]
        slopes = derivatives(code, {"p": p}, {"p": np.eye(3)})["y"][1]
        for i, size in enumerate((1e-5, 1e-5, 1e-4 * p[2])):
            ends = [np.array(law(*(p + side * size * np.eye(3)[i]))[:2]) for side in (1.0, -1.0)]
            difference = (ends[0] - ends[1]) / (2.0 * size)
            assert slopes[:, i] == pytest.approx(difference, rel=1e-2, abs=SLOPE * np.abs(slopes).max())


def test_end_forces_of_mooring_lines_agree_with_moorpy() -> None:
    catenary = pytest.importorskip("moorpy.Catenary").catenary
    for lifted in (True, False):
        for x, z, k in random_lines(60, 3, lifted):
            if z < 0.0 or k < 1e-5:  # MoorPy's iteration does not end for some of these
                continue
            L, w = 500.0, 1200.0
            EA = 0.5 * w * L / k
            one = catenary(x * L, z * L, L, EA, w, CB=-10.0 * L if lifted else 0.0, Tol=1e-9, MaxIter=500)
            found = (hanging if lifted else lying)(x, z, k)
            ours = found.H * w * L, found.V * w * L
            assert ours == pytest.approx((-one[2], -one[3]), rel=PEER * 100, abs=PEER * w * L)


def test_published_example_lines_of_moorpy_are_reproduced() -> None:
    """Its own tests: the line that lies in part, also with friction of the seabed, and the one that hangs freely."""
    L, w, EA = 500.0, 800.0, 7.51e12
    f = lying(400.0 / L, 200.0 / L, 0.5 * w * L / EA)
    assert (f.H * w * L, f.V * w * L) == pytest.approx((96643.428, 237751.755), rel=PEER)
    on_seabed = L * (1.0 - f.V)
    assert on_seabed == pytest.approx(202.8103, rel=1e-5)
    L, w, EA = 130.0, 881.05, 7.51e8
    f = hanging(89.9 / L, 59.2 / L, 0.5 * w * L / EA)
    assert (f.H * w * L, (1.0 - f.V) * w * L, f.V * w * L) == pytest.approx((31373.229, 26650.341, 87886.159), rel=PEER)


def test_a_suspended_mooring_line_solves_the_boundary_value_problem_of_an_elastic_cable() -> None:
    """x' = (1 + T / EA) H / T and z' = (1 + T / EA) V / T with V' = w, by collocation."""
    L, w, EA, x, z = 200.0, 900.0, 4e7, 195.0, 40.0

    def slope(s: np.ndarray, y: np.ndarray) -> np.ndarray:
        T = np.hypot(y[2], y[3])
        return np.array([(1.0 / T + 1.0 / EA) * y[2], (1.0 / T + 1.0 / EA) * y[3], 0.0 * s, w + 0.0 * s])

    def ends(a: np.ndarray, b: np.ndarray) -> np.ndarray:
        return np.array([a[0], a[1], b[0] - x, b[1] - z])

    s = np.linspace(0.0, L, 60)
    guess = np.array([x * s / L, z * s / L, 1e6 + 0.0 * s, w * (s - 0.4 * L)])
    cable = solve_bvp(slope, ends, s, guess, tol=1e-9, max_nodes=20000)
    assert cable.success
    f, points = line_shape(x / L, z / L, 0.5 * w * L / EA, False, 8)
    assert (f.H * w * L, f.V * w * L) == pytest.approx((cable.y[2, -1], cable.y[3, -1]), rel=PEER)
    assert L * np.array(points) == pytest.approx(cable.sol(np.linspace(0.0, L, 9))[:2].T, abs=1e-4)


def hull(line: MooringLine, speed: float = 0.0) -> System:
    """A body that moves in the plane of the water, away from its anchor."""
    joint = Joint("float", "planar", "world", "hull", axis=Z, v0=(-speed, 0.1 * speed, 0.0))
    return System((Body("hull", 1e6, inertia=cube(1e6, 40.0)),), (joint,), forces=(line,), gravity=G)


def towed(line: MooringLine) -> System:
    """A body that is moved along x."""
    joint = Joint("way", "prismatic", "world", "hull", axis=(1.0, 0.0, 0.0))
    tow = Drive("tow", "way", "prescribed")
    return System((Body("hull", 1e6),), (joint,), drives=(tow,), forces=(line,), gravity=G)


def tension(line: MooringLine, moved: float) -> float:
    """[N] at the fairlead of the towed body."""
    x, y, z = np.array(line.b.p) + np.array([moved, 0.0, 0.0]) - np.array(line.a.p)
    w = line.mass * G * line.length
    f = line_shape(np.hypot(x, y) / line.length, z / line.length, 0.5 * w / line.EA, line.seabed, 1)[0]
    return w * float(np.hypot(f.H, f.V))


def test_energy_is_conserved_while_a_mooring_line_lifts_off_the_seabed_and_returns() -> None:
    s = started(hull(LINE, 8.0), tolerance=TOLERANCE)
    hand_over(s, 40 * SECOND)
    assert {what for _, what in events(s)} == {"uplift", "grounded"}
    assert imbalance(s) < BALANCE


def test_a_slack_mooring_line_pulls_with_the_weight_of_its_suspended_part() -> None:
    """100 m above the seabed, however far behind the anchor it lies, to what it stretches."""
    for x in (0.0, 0.3, 0.7, 0.777):
        f = lying(x, 100.0 / 450.0, 1e-5)
        assert (f.V, f.H, f.missed) == pytest.approx((100.0 / 450.0, 0.0, 0.0), abs=1e-5)


def test_a_mooring_line_that_starts_above_its_breaking_load_is_refused() -> None:
    with pytest.raises(KernelError, match=r"breaking is 300 kN, and the line begins with 359.25 kN"):
        started(towed(structs.replace(LINE, breaking=3e5)))


def test_a_mooring_line_that_is_cast_off_has_no_tension_and_its_strain_energy_becomes_heat() -> None:
    s = started(hull(LINE, 1.0), tolerance=TOLERANCE)
    hand_over(s, 2 * SECOND)
    s.unhook("line")
    s.settle()
    hand_over(s, 4 * SECOND)
    assert column(s, "reeving/tension")[1][-1].tolist() == [0.0, 0.0]
    assert imbalance(s) < BALANCE


def test_a_mooring_line_parts_at_its_breaking_load_and_reports_the_time() -> None:
    """At 1 m/s, half a second late, the towed end is where the closed form has the breaking load."""
    line = structs.replace(LINE, breaking=5e5)
    s = started(towed(line), tolerance=TOLERANCE)
    s.set_profile("tow", 0, -1.0, 1.0, None)
    s.settle()
    hand_over(s, 10 * SECOND)
    (when,) = times(s, "line", "parted")
    assert when - 0.5 == pytest.approx(brentq(lambda d: tension(line, -d) - 5e5, 0.1, 30.0), abs=1e-6)
    assert column(s, "reeving/tension")[1][-1, 0] == 0.0
