"""Tugger lines against SciPy and closed forms: a constant pull shifts and shortens a swing, its spread damps it."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from heavylift.kernel import KernelError
from heavylift.kernel.analysis import linear_model
from heavylift.kernel.description import Body, Joint, Point, System, TuggerLine, trapezoid
from msgspec import structs
from scipy.integrate import solve_ivp
from small_scenes import SECOND, column, hand_over, imbalance, started

G, MASS, LENGTH = 9.80665, 2e4, 12.0
TOLERANCE, BALANCE = 1e-10, 5e-7  # of a step, and of the energy that its steps turn over
PEER = 1e-6  # [rad] between two integrators at 1e-10
FAR = 1e5  # [m] a pull from there keeps its direction to 1e-4
SMALL = 2e-3  # [rad]: sin(x) = x to 1e-6
LINE = TuggerLine("tug", Point("world", (9.0, 0.0, -10.0)), Point("load", (0.3, 0.0, -LENGTH)), 2e4)


def pendulum(line: TuggerLine, angle: float = 0.0, speed: float = 0.0) -> System:
    """A point mass on a rigid arm that hangs from the origin and turns about -y, so that x grows with the angle."""
    hinge = Joint("hinge", "revolute", "world", "load", axis=(0.0, -1.0, 0.0), q0=(angle,), v0=(speed,))
    return System((Body("load", MASS, (0.0, 0.0, -LENGTH)),), (hinge,), forces=(line,), gravity=G)


def swing(line: TuggerLine, angle: float, speed: float, seconds: int) -> tuple[np.ndarray, np.ndarray]:
    s = started(pendulum(line, angle, speed), tolerance=TOLERANCE)
    hand_over(s, seconds * SECOND)
    s.settle()
    assert imbalance(s) < BALANCE
    t, q = column(s, "joint/position")
    return t, q[:, 0]


def by_scipy(
    line: TuggerLine, angle: float, speed: float, t: np.ndarray, tension: Callable[[float], float] | None = None
) -> np.ndarray:
    a, b = np.array(line.a.p)[[0, 2]], np.array(line.b.p)[[0, 2]]

    def motion(at_s: float, y: np.ndarray) -> list[float]:
        c, s = np.cos(y[0]), np.sin(y[0])
        at = np.array([c * b[0] - s * b[1], s * b[0] + c * b[1]])
        away, per = at - a, np.array([-at[1], at[0]])  # the second: velocity of the point by the angular velocity
        u = away / np.hypot(*away)
        x = u @ per * y[1] / line.speed
        T = (tension(at_s) if tension else line.tension) * (1.0 + line.spread * x / np.sqrt(1.0 + x * x))
        return [y[1], (-MASS * G * LENGTH * s - T * (u @ per)) / (MASS * LENGTH**2)]

    once, back = np.unique(t, return_inverse=True)  # an instant may have two samples
    span = (0.0, float(once[-1]))
    return np.asarray(solve_ivp(motion, span, [angle, speed], "DOP853", once, rtol=1e-11, atol=1e-12).y[0][back])


@pytest.mark.parametrize("seed", range(6))
def test_a_pendulum_on_a_randomly_placed_tugger_line_moves_as_scipy_integrates_it(seed: int) -> None:
    random = np.random.default_rng(seed)
    at = (random.uniform(8.0, 30.0), 0.0, random.uniform(-20.0, 2.0))
    pull, spread, speed = random.uniform(5e3, 6e4), random.uniform(0.0, 0.5), random.uniform(0.02, 0.5)
    line = structs.replace(LINE, a=Point("world", at), tension=pull, spread=spread, speed=speed)
    begin = random.uniform(-0.2, 0.2, 2).tolist()
    t, q = swing(line, *begin, 20)
    assert q == pytest.approx(by_scipy(line, *begin, t), abs=PEER)


def test_a_constant_horizontal_pull_shifts_a_pendulum_and_shortens_its_period() -> None:
    """tan(angle) = T / W; period 2 pi sqrt(L m / sqrt(W^2 + T^2))."""
    pull, weight = 5e4, MASS * G
    rest = np.arctan(pull / weight)
    line = structs.replace(LINE, a=Point("world", (FAR, 0.0, 0.0)), b=Point("load", (0.0, 0.0, -LENGTH)), tension=pull)
    t, q = swing(line, rest + SMALL, 0.0, 30)
    w = np.sqrt(np.hypot(weight, pull) / (LENGTH * MASS))
    assert q - rest == pytest.approx(SMALL * np.cos(w * t), abs=0.02 * SMALL)


def test_friction_of_a_tugger_line_takes_the_same_amplitude_from_each_swing() -> None:
    """Dry friction of s T takes 2 s T / k from each half swing, k = W / L (below: of angles, by its swing at rest)."""
    pull, spread, begin = 2e4, 0.1, 0.1
    weight = np.hypot(MASS * G, pull)
    line = structs.replace(
        LINE, a=Point("world", (FAR, 0.0, 0.0)), b=Point("load", (0.0, 0.0, -LENGTH)),
        tension=pull, spread=spread, speed=1e-3,
    )  # fmt: skip
    rest = np.arctan(pull / (MASS * G))
    _, q = swing(line, rest + begin, 0.0, 18)
    turns = np.flatnonzero(np.diff(np.sign(np.diff(q)))) + 1
    peaks = np.abs(q[turns] - rest)[:4]
    want = begin - 2.0 * spread * pull / weight * np.arange(1, 5)
    assert len(peaks) == 4
    assert peaks == pytest.approx(want, abs=0.01 * begin)


def test_a_released_tugger_line_exerts_no_force_and_its_energy_is_accounted_for() -> None:
    s = started(pendulum(structs.replace(LINE, spread=0.2)), tolerance=TOLERANCE)
    hand_over(s, 2 * SECOND)
    s.unhook("tug")
    s.settle()
    hand_over(s, 4 * SECOND)
    assert column(s, "reeving/tension")[1][-1].tolist() == [0.0]
    assert imbalance(s) < BALANCE


def test_a_run_ends_where_a_tugger_line_comes_to_the_end_of_its_stroke() -> None:
    s = started(pendulum(structs.replace(LINE, longest=10.0), speed=-0.5), tolerance=TOLERANCE)
    with pytest.raises(KernelError, match=r"tugger line 'tug' at \d\.\d+ s: it is 10 m long, .* within 0 m to 10 m"):
        hand_over(s, 4 * SECOND)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"spread": 1.0}, "spread is 1; it must be below 1"),
        ({"longest": 5.0}, "length is 8.9269 m at the start; it must be within 0 m to 5 m"),
        ({"shortest": 9.0}, "length is 8.9269 m at the start; it must be within 9 m and more"),
        ({"b": Point("world")}, "is on the body of a"),
    ],
)
def test_impossible_tugger_lines_are_refused(changes: dict[str, object], message: str) -> None:
    with pytest.raises(KernelError, match=message):
        started(pendulum(structs.replace(LINE, **changes)))


@pytest.mark.parametrize("seed", range(4))
def test_a_pendulum_on_a_line_whose_tension_is_ordered_moves_as_scipy_integrates_it(seed: int) -> None:
    """The tension goes to its new value at a rate, with ramps; the work that this brings in is accounted for."""
    draw = np.random.default_rng(seed)
    line = structs.replace(LINE, spread=float(draw.uniform(0.0, 0.8)), rate=2e4)
    rate, accel, change = float(draw.uniform(2e3, 2e4)), float(draw.uniform(1e4, 4e4)), float(draw.uniform(-1.8e4, 3e4))
    s = started(pendulum(line, 0.1), tolerance=TOLERANCE)
    hand_over(s, SECOND)
    s.set_profile("tug", SECOND, rate, accel, change)
    s.settle()
    hand_over(s, 8 * SECOND)
    s.settle()
    assert imbalance(s) < BALANCE
    move = trapezoid(change, float(np.copysign(rate, change)), accel, 0.0)
    t, q = column(s, "joint/position")
    want = by_scipy(line, 0.1, 0.0, t, lambda x: line.tension + move.displacement(max(0.0, x - 1.0)))
    assert np.abs(q[:, 0] - want).max() < PEER
    assert column(s, "reeving/tension")[1][-1, 0] == pytest.approx(line.tension + change, rel=line.spread + 1e-9)


def test_an_ordered_tension_is_an_input_of_the_linear_model_in_newtons() -> None:
    """A horizontal force F at the end of the arm turns a pendulum by F / (m g) at rest."""
    ends = {"a": Point("world", (FAR, 0.0, -LENGTH)), "b": Point("load", (0.0, 0.0, -LENGTH))}
    model = linear_model(
        started(pendulum(structs.replace(LINE, **ends, tension=1.0, rate=1.0))), ["tug"], ["joint/position/*"]
    )
    assert [(x.name, x.unit) for x in model.inputs] == [("tug", "N")]
    gain = model.D - model.C @ np.linalg.solve(model.A, model.B)
    assert gain[0, 0] == pytest.approx(1.0 / (MASS * G), rel=1e-3)
