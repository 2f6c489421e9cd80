"""Every method has the order of its theory, also across events and across the pieces of a speed profile."""

from dataclasses import replace
from typing import get_args

import numpy as np
import pytest
from heavylift.kernel.description import Body, Drive, Joint, MethodName, System
from small_scenes import SECOND, G, X, cube, hand_over, hung, started

EXACT = 1e-14  # tolerance of the solution that the steps are compared with
SOLVED = 1e-12  # tolerance to which implicit stages are iterated
CLOSE = 0.1  # of the observed order to that of the theory
# order; then spin of the wrist [rad/s] and steps [s] of the swing and of the ride, EA [N] and steps of the catch:
# such that the leading term of the error rules, well above round-off
STORIES = {
    "semi-implicit-euler": (1, (6.0, (4e-4, 2e-4)), (0.0, (4e-4, 2e-4)), (2e8, (8e-4, 4e-4))),
    "rk4": (4, (6.0, (5e-3, 2.5e-3)), (0.0, (0.01, 5e-3)), (2e8, (0.01, 0.005))),
    "dopri5": (5, (6.0, (5e-3, 2.5e-3)), (0.0, (0.01, 0.005)), (2e8, (0.02, 0.01))),
    "dop853": (8, (1.0, (0.04, 0.02)), (0.5, (0.08, 0.04)), (8e8, (0.08, 0.04))),
    "radau5": (5, (1.0, (0.01, 0.005)), (0.0, (0.04, 0.02)), (2e8, (0.04, 0.02))),
}


def end(scene, until, command=lambda s: None, **options):
    """Coordinates and velocities at `until`."""
    s = started(scene, **options)
    command(s)
    s.settle()
    hand_over(s, round(until * SECOND))
    return s.state[: s.program.nq + s.program.nv].copy()


def orders(scene, until, method, steps, command=lambda s: None):
    """Orders observed between one step and the next."""
    exact = end(scene, until, command, method="dop853", tolerance=EXACT)
    errors = [np.abs(end(scene, until, command, method=method, step=h, tolerance=SOLVED) - exact).max() for h in steps]
    return np.log2(np.array(errors[:-1]) / errors[1:])


def pendulum(spin=6.0, **drive):
    joints = (
        Joint("rail", "prismatic", "world", "trolley", axis=X),
        Joint("hinge", "revolute", "trolley", "bob", axis=(0.0, 1.0, 0.0), q0=(1.5,)),
        Joint("wrist", "revolute", "bob", "hand", (0.0, 0.0, -2.0), axis=(0.0, 1.0, 0.0), v0=(spin,)),
    )
    bodies = (
        Body("trolley", 3.0e3),
        Body("bob", 1.0e3, (0.0, 0.0, -1.0), cube(1.0e3)),
        Body("hand", 5.0e2, (0.0, 0.0, -1.0), cube(5.0e2)),
    )
    return System(bodies, joints, gravity=G, **drive)


def test_every_integration_method_has_a_convergence_test():
    assert set(STORIES) == set(get_args(MethodName))


@pytest.mark.parametrize("method", STORIES)
def test_integration_methods_have_their_order_for_a_double_pendulum_on_a_free_trolley(method):
    order, (spin, steps), _, _ = STORIES[method]
    found = orders(pendulum(spin), 1.6, method, steps)
    assert found == pytest.approx(order, abs=CLOSE)


@pytest.mark.parametrize("method", STORIES)
def test_integration_methods_have_their_order_for_a_pendulum_below_a_trolley_moved_by_a_profile(method):
    """Accelerations jump at 0, 0.56, 0.96 and 1.52 s; a step that ends there must not see the next piece."""

    def move(s):
        s.references.set_profile("drive", 0, 1.12, 2.0, 1.12 * 0.96)

    order, _, (spin, steps), _ = STORIES[method]
    scene = pendulum(spin, drives=(Drive("drive", "rail", "prescribed"),))
    found = orders(scene, 1.92, method, steps, move)
    assert found == pytest.approx(order, abs=CLOSE)


@pytest.mark.parametrize("method", STORIES)
def test_integration_methods_have_their_order_for_a_load_caught_by_its_rope(method):
    """The step before the catch is cut at the located event and the next one starts there."""
    order, _, _, (EA, steps) = STORIES[method]
    scene = replace(hung(59.9), ropes=(replace(hung(59.9).ropes[0], EA=EA),))
    found = orders(scene, 0.8, method, steps)
    assert found == pytest.approx(order, abs=CLOSE)


@pytest.mark.parametrize("method", ["rk4", "radau5"])
def test_integration_methods_have_their_order_for_a_load_thrown_up_and_caught_again(method):
    """A taut rope slackens: laws are smooth behind the event, so that the step that is cut there keeps its order."""
    order, _, _, (EA, steps) = STORIES[method]
    scene = replace(hung(59.9), ropes=(replace(hung(59.9).ropes[0], EA=4.0 * EA),))
    found = orders(scene, 1.6, method, [h / 2 for h in steps])
    assert found == pytest.approx(order, abs=CLOSE)


@pytest.mark.parametrize("tolerance", [1e-5, 1e-7, 1e-9])
@pytest.mark.parametrize("method", ["dopri5", "dop853", "radau5"])
def test_the_error_of_a_run_is_proportional_to_its_tolerance(method, tolerance):
    exact = end(pendulum(), 1.6, method="dop853", tolerance=EXACT)
    error = np.abs(end(pendulum(), 1.6, method=method, tolerance=tolerance) - exact).max()
    assert 1e-3 * tolerance < error < 100 * tolerance
