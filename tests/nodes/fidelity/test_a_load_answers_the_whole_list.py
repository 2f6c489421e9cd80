"""The answer of a pendulum to an action list is that of its equation, and moves in time with it add up."""

from math import pi
from types import SimpleNamespace

import numpy as np
import pytest
from heavylift.nodes.fidelity import Knot, Swings, answer, moved, nodding
from scipy.integrate import solve_ivp

W = 0.5


def shaken(knots, damping, times):
    """The same by SciPy, from knot to knot."""
    x, v, a, now, out, far = 0.0, 0.0, 0.0, 0.0, [], 0.0

    def moves(_, y):
        return [y[1], -2 * damping * W * y[1] - W * W * y[0] - a]

    for t, knot in sorted([(k.t, k) for k in knots] + [(t, Knot(t)) for t in times], key=lambda x: x[0]):
        if t > now:
            run = solve_ivp(moves, (now, t), [x, v], rtol=1e-10, atol=1e-12, dense_output=True)
            x, v = run.y[:, -1]
            far = max(far, np.abs(run.sol(np.linspace(now, t, 400))[0]).max())
        now, a, x = t, a + knot.accel, x - knot.jump
        if t in times:
            out.append(x)
    return far, out


@pytest.mark.parametrize("damping", [0.0, 0.05])
def test_it_is_that_of_the_equation(damping):
    knots = [*moved(1.0, 2.0, 3.0, 4.0), *moved(14.0, -1.0, 2.0, 0.0), Knot(20.0, jump=0.1)]
    times = (5.0, 13.0, 25.0, 60.0)
    found = answer(sorted(knots), W, damping, times)
    far, places = shaken(knots, damping, times)
    assert found.at == pytest.approx(places, abs=1e-8)
    assert (1.0 - 1e-4) * far <= found.largest <= (1.1 if damping else 1.0 + 1e-4) * far


def test_moves_in_time_with_the_swing_add_up_and_so_does_what_a_wrong_frequency_makes_of_them():
    way, half = 0.5, pi / W
    knots = [k for i in range(12) for k in moved(i * half, way if i % 2 == 0 else -way, 1.0, 0.0)]
    once = answer(knots[:4], W).largest
    assert answer(knots, W).largest == pytest.approx(12 * once, rel=0.01)
    begins = tuple(i * half for i in range(13))
    many, single = (Swings(((), tuple(k)), (W, W), begins) for k in (knots, knots[:4]))
    assert many.envelope > 3.0 * single.envelope
    assert many.away > 5.0 * single.away


def test_what_swings_faster_than_the_load_goes_with_its_moves_and_not_with_its_jumps():
    knots, jump = (*moved(1.0, 0.1, 0.3, 0.1),), Knot(9.0, jump=0.2)
    found = Swings((knots, (jump,)), (W, W), (0.0, 20.0))
    assert found.shaken((10 * W, 10 * W)) >= answer(knots, 10 * W).largest > 0.01
    assert Swings(((), (jump,)), (W, W), (0.0, 20.0)).shaken((10 * W, 10 * W)) == 0.0
    assert (found.jumps, Swings((knots, ()), (W, W), (0.0, 20.0)).jumps) == (0.2, 0.0)


def test_a_block_nods_below_its_hook_as_two_points_of_a_double_pendulum_do():
    g, hook, block, rope, slings = 9.81, 45.0, 26.5, 77.0, 18.6
    h = SimpleNamespace(load=hook + block, share=block, length=rope, reach=rope + slings)
    k = block * g / slings
    squares, ways = np.linalg.eig(
        np.array([[((hook + block) * g / rope + k) / hook, -k / hook], [-k / block, k / block]])
    )
    fast = int(squares.argmax())
    shares = [np.linalg.solve(ways / ways[1], [x, 1.0])[fast] for x in (1.0, 0.0)]
    assert nodding(h, g) == pytest.approx((squares[fast] ** 0.5, *np.abs(shares)))


def test_a_load_that_stands_forgets():
    knots = [*moved(0.0, 1.0, 2.0, 1.0), Knot(6.0, stands=True)]
    assert answer(knots, W, times=(5.9, 10.0)).sizes[1] == 0.0
