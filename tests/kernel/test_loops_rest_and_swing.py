"""Statics, reactions and modes of mechanisms with loops: a platform on two parallel links, and a redundant one."""

from math import pi, sqrt

import numpy as np
import pytest
from heavylift.kernel.analysis import equilibrium, modes, momentum, reactions
from heavylift.kernel.describe import WORLD, Body, Joint, System
from small_scenes import G, Y, started

LINK, M, L, SPAN = 30.0, 500.0, 4.0, 6.0  # [kg, kg, m, m]
CLOSE = 1e-7
START = 0.4  # [rad] from the vertical


def swing(links: int = 2) -> System:
    """A platform that hangs from equal parallel links of length L; from the third link on the rows are redundant."""
    i = LINK * L * L / 12.0
    rod = ((i, 0.0, 0.0), (0.0, i, 0.0), (0.0, 0.0, 0.0))
    at = [SPAN * n / (links - 1) for n in range(links)]
    bodies = [Body(f"link{n}", LINK, (0.0, 0.0, -L / 2.0), rod) for n in range(links)]
    bodies.append(Body("platform", M, (SPAN / 2.0, 0.0, 0.0), ((1e3, 0.0, 0.0), (0.0, 1e3, 0.0), (0.0, 0.0, 1e3))))
    low = (0.0, 0.0, -L)
    joints = [
        Joint(f"top{n}", "revolute", WORLD, f"link{n}", (x, 0.0, 0.0), axis=Y, q0=(START,)) for n, x in enumerate(at)
    ]
    joints.append(Joint("low0", "revolute", "link0", "platform", low, axis=Y, q0=(-START,)))
    joints += [
        Joint(f"low{n}", "revolute", f"link{n}", "platform", low, axis=Y, p_CJ=(at[n], 0.0, 0.0))
        for n in range(1, links)
    ]
    return System(tuple(bodies), tuple(joints), gravity=G)


@pytest.mark.parametrize("links", [2, 3])
def test_a_parallel_swing_has_one_mode_and_hangs_straight(links):
    simulation = started(swing(links))
    found = equilibrium(simulation)
    assert found.q == pytest.approx(np.zeros(len(found.q)), abs=1e-8)
    result = modes(simulation)
    n = links * LINK
    want = sqrt((M + n / 2.0) * G / ((M + n / 3.0) * L))
    assert [2.0 * pi * m.frequency for m in result.oscillations] == pytest.approx([want], rel=CLOSE)
    assert result.free == 0
    assert result.oscillations[0].bodies[0][0] == "platform"


def test_both_links_carry_half_of_the_platform_and_each_itself():
    simulation = started(swing())
    equilibrium(simulation)
    carried = reactions(simulation)
    assert list(carried)[-1] in ("low0", "low1")  # the one that closes the loop
    for n in (0, 1):
        assert carried[f"top{n}"].force == pytest.approx([0.0, 0.0, (LINK + M / 2.0) * G], abs=1e-3)
        low = carried[f"low{n}"].force[2]
        assert abs(low) == pytest.approx(M / 2.0 * G, rel=1e-6)
        assert carried[f"low{n}"].moment == pytest.approx([0.0, 0.0, 0.0], abs=1e-3)


def test_in_motion_the_tops_carry_weight_and_inertia():
    simulation = started(swing(), native=False)
    carried = reactions(simulation)
    sum_of_tops = carried["top0"].force + carried["top1"].force
    h, dt = momentum(simulation).linear, 1e-5
    simulation.interrupt(int(dt * 1e9))
    rate = (momentum(simulation).linear - h) / dt
    weight = (M + 2.0 * LINK) * G
    assert sum_of_tops - rate == pytest.approx([0.0, 0.0, weight], abs=1e-4 * weight)
