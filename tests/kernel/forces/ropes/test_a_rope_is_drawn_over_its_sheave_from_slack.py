"""A slack rope with friction tightens while it runs over its sheave: it slips at once, with few events."""

from __future__ import annotations

from math import exp, pi

import pytest
from heavylift.kernel.description import WORLD, Body, InputSignal, Joint, Point, Reeving, Sheave, System
from heavylift.kernel.simulation import Simulation
from small_scenes import SECOND, G, Y, Z, column, hand_over, imbalance, started

DRUM, DOWN = 0.5, 10.0
FEW = 20  # events of one start: taut, slip, and what the stretch of the rope swings
BALANCE = 1e-6  # of the energy turned over, at the default tolerance
CAPSTAN = 1e-4  # of the ratio of strains, on which friction acts; the lengths have rounding


def atwood(a: float, b: float, mu: float, speed: float, slack: float = 0.0) -> Simulation:
    """Two masses on a rope over a fixed drum; a goes up with a speed that the rope shares."""
    joints = tuple(
        Joint(name, "prismatic", WORLD, name, (side * DRUM, 0.0, 0.0), axis=Z, q0=(-DOWN,), v0=(-side * speed,))
        for name, side in (("a", -1.0), ("b", 1.0))
    )
    length = 2.0 * DOWN + pi * DRUM + slack
    sheave = Sheave(Point(WORLD), Y, DRUM, mu)
    rope = Reeving("rope", Point("a"), (sheave,), Point("b"), 2e6, InputSignal(length), 5e3)
    scene = System((Body("a", a), Body("b", b)), joints, forces=(rope,), gravity=G)
    return started(scene, method="radau5", sample_ns=SECOND // 100)


@pytest.mark.parametrize("speed", [3.0, -3.0, 0.3])
@pytest.mark.parametrize(("a", "b"), [(10.0, 12.0), (10.0, 10.0), (1.0, 30.0)])
@pytest.mark.parametrize("mu", [0.05, 0.2])
@pytest.mark.parametrize("slack", [0.0, 1e-3])
def test_a_slack_rope_slips_over_its_sheave_from_the_moment_it_becomes_taut(
    a: float, b: float, mu: float, speed: float, slack: float
) -> None:
    """Above, a rope that runs with friction: the tensions are in the ratio e^(mu pi) (Euler's capstan)."""
    s = atwood(a, b, mu, speed, slack)
    hand_over(s, SECOND // 5)
    s.settle()
    assert len(s.log) <= FEW
    assert s.notes == []
    long, unstretched = (column(s, f"reeving/{what}")[1][-1] for what in ("length", "unstretched"))
    strain = long / unstretched - 1.0
    goes = s.state[3] - s.state[2]
    if abs(goes) > 0.1:
        assert max(strain[1] / strain[0], strain[0] / strain[1]) == pytest.approx(exp(mu * pi), rel=CAPSTAN)
        assert (strain[1] > strain[0]) == (goes < 0.0), "the side that the rope runs to pulls harder"
    assert imbalance(s) < BALANCE
