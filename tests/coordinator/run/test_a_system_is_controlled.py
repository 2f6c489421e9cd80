"""`simulate(..., control=f, period=...)`: a controller in Python against the closed loop of the linear model."""

import control
import numpy as np
import pytest
from heavylift import linearise, simulate
from heavylift.kernel import HeavyliftError
from heavylift.kernel.description import Body, Characteristic, Drive, InputSignal, Joint, System
from scipy.linalg import solve_continuous_are

X, Y = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0)
BODIES = Body("cart", 3.0), Body("pole", 1.0, (0.0, 0.0, 1.0), ((0.3, 0.0, 0.0), (0.0, 0.3, 0.0), (0.0, 0.0, 0.3)))


def cart(tilt: float = 0.05, **parts) -> System:
    joints = (
        Joint("rail", "prismatic", "world", "cart", axis=X),
        Joint("pin", "revolute", "cart", "pole", axis=Y, q0=(tilt,)),
    )
    return System(BODIES, joints, **parts)


PUSH = Characteristic("push", "rail", "position", (-1.0, 1.0), (1.0, 1.0), InputSignal(0.0, driven=True))
NAMES = "joint/position/rail.travel", "joint/position/pin.angle", "joint/velocity/rail.speed", "joint/velocity/pin.rate"


def test_an_inverted_pendulum_is_stabilised_by_gains_from_its_linear_model():
    upright = linearise(cart(0.0, forces=(PUSH,)), ["push"], ["joint/position/*"], at=0.0)
    assert max(s.real for s in np.linalg.eigvals(upright.A)) > 1.0
    K = upright.B.T @ solve_continuous_are(upright.A, upright.B, np.eye(4), [[0.1]]) / 0.1
    start, period, until = 0.001, 0.01, 1.0

    def held(t, now):
        return {"push": -(K @ [now[name] for name in NAMES]).item()}

    found = simulate(cart(start, forces=(PUSH,)), until, control=held, period=period)
    sampled = control.c2d(control.ss(*upright), period)  # the force is held between two calls
    x = np.array([0.0, start, 0.0, 0.0])
    for _ in range(round(until / period)):
        x = sampled.A @ x - sampled.B @ (K @ x)
    assert found["joint/position"].values[-1] == pytest.approx(x[:2], abs=1e-6 * 5.0)
    falling = simulate(cart(start, forces=(PUSH,)), until)
    assert abs(falling["joint/position"]["pin.angle"][-1]) > 10.0 * abs(x[1])


@pytest.mark.parametrize("kind", ["prescribed", "speed"])
def test_a_drive_reaches_the_requested_speed_one_control_period_later(kind):
    system = cart(drives=(Drive("travel", "rail", kind, kv=1e6),))
    found = simulate(system, 1.0, every=0.1, control=lambda t, now: {"travel": 0.5 * t}, period=0.1)
    speed = found.at([0.5, 0.8])["joint/velocity"]["rail.speed"]
    assert speed == pytest.approx([0.2, 0.35], abs=1e-4)


def test_a_control_function_is_called_once_per_period_with_all_samples():
    calls = []

    def note(t, now):
        calls.append((t, now["joint/velocity/pin.rate"]))
        return {}

    result = simulate(cart(), 0.5, every=0.1, control=note, period=0.1)
    assert [t for t, _ in calls] == pytest.approx([0.0, 0.1, 0.2, 0.3, 0.4])
    assert calls[3][1] == pytest.approx(result.at(0.3)["joint/velocity"]["pin.rate"][0], rel=1e-9)


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        ({"control": lambda t, now: {}}, "give both, or neither"),
        ({"period": 0.1}, "give both, or neither"),
        ({"control": lambda t, now: 3.0, "period": 0.1}, "3.0 at 0 s; return a dict of values by name"),
        ({"control": lambda t, now: {"hoist": 1.0}, "period": 0.1}, "'hoist'"),
        ({"control": lambda t, now: {"push": float("nan")}, "period": 0.1}, "nan is not a valid value of a signal"),
        ({"control": lambda t, now: {}, "period": 0.0}, "period"),
    ],
)
def test_invalid_control_functions_are_reported_in_one_sentence(arguments, sentence):
    with pytest.raises(HeavyliftError) as error:
        simulate(cart(forces=(PUSH,)), 0.3, **arguments)
    assert sentence in str(error.value)
    assert "\n" not in str(error.value)
