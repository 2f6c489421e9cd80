"""Statics, reactions and modes of mechanisms with loops: a platform on two or three parallel links."""

from math import pi, sqrt

import numpy as np
import pytest
from contact_scenes import on_slope
from heavylift.kernel.analysis import equilibrium, modes, momentum, reactions
from heavylift.kernel.description import WORLD, Body, Joint, Line, Point, RigidRope, System
from heavylift.kernel.equations import equations
from small_scenes import G, X, Y, Z, hung, started

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


def test_printed_equations_include_the_joint_that_closes_a_loop():
    text = equations(swing())
    assert "-  platform  low1   revolute  link1 (closes a loop)" in text
    assert '    m2 r2" = F2 + Fc2 + Fc(low1)\n' in text
    assert '    m3 r3" = F3 + Fc3 - Fc(low1)\n' in text
    assert '  H q" = tau - S^T f + G^T lambda' in text
    assert "lambda" not in equations(hung(60.0))


@pytest.mark.parametrize("links", [2, 3])
def test_a_platform_on_parallel_links_hangs_straight_and_has_one_mode(links):
    simulation = started(swing(links))
    found = equilibrium(simulation)
    assert found.q == pytest.approx(np.zeros(len(found.q)), abs=1e-8)
    result = modes(simulation)
    n = links * LINK
    want = sqrt((M + n / 2.0) * G / ((M + n / 3.0) * L))
    assert [2.0 * pi * m.frequency for m in result.oscillations] == pytest.approx([want], rel=CLOSE)
    assert result.free == 0
    assert result.oscillations[0].bodies[0][0] == "platform"


def test_each_link_of_a_hanging_platform_carries_half_the_platform_and_its_own_weight():
    simulation = started(swing())
    equilibrium(simulation)
    carried = reactions(simulation)
    assert list(carried)[-1] in ("low0", "low1")  # the one that closes the loop
    for n in (0, 1):
        assert carried[f"top{n}"].force == pytest.approx([0.0, 0.0, (LINK + M / 2.0) * G], abs=1e-3)
        low = carried[f"low{n}"].force[2]
        assert abs(low) == pytest.approx(M / 2.0 * G, rel=1e-6)
        assert carried[f"low{n}"].moment == pytest.approx([0.0, 0.0, 0.0], abs=1e-3)


def test_upper_joints_of_a_swinging_platform_carry_its_weight_and_inertia_force():
    simulation = started(swing(), native=False)
    carried = reactions(simulation)
    sum_of_tops = carried["top0"].force + carried["top1"].force
    h, dt = momentum(simulation).linear, 1e-5
    simulation.interrupt(int(dt * 1e9))
    rate = (momentum(simulation).linear - h) / dt
    weight = (M + 2.0 * LINK) * G
    assert sum_of_tops - rate == pytest.approx([0.0, 0.0, weight], abs=1e-4 * weight)


def test_a_load_on_a_rigid_rope_rests_below_its_end():
    """The rope pulls with the weight, and the load swings as a pendulum of its length."""
    rope = RigidRope("rope", (Line(Point(WORLD), Point("load")),), L)
    i = 1e-3 * M
    load = Body("load", M, (0.0, 0.0, 0.0), ((i, 0.0, 0.0), (0.0, i, 0.0), (0.0, 0.0, i)))
    slides = (
        Joint("along", "prismatic", WORLD, "carrier", axis=X, q0=(0.5,)),
        Joint("up", "prismatic", "carrier", "load", axis=Z, q0=(-sqrt(L * L - 0.25),)),
    )
    simulation = started(System((Body("carrier", 0.0), load), slides, rigid_ropes=(rope,), gravity=G))
    found = equilibrium(simulation)
    assert found.q == pytest.approx([0.0, -L], abs=1e-6)
    assert found.tensions["rope"] == pytest.approx(M * G, rel=1e-6)
    (mode,) = modes(simulation).oscillations
    assert 2.0 * pi * mode.frequency == pytest.approx(sqrt(G / L), rel=1e-6)


def test_a_load_on_a_slope_with_friction_stays_where_it_is():
    simulation = started(on_slope(0.1, 0.5))
    where = simulation.state[:3].copy()
    assert equilibrium(simulation).q[:3] == pytest.approx(where, abs=1e-9)
    assert "    F1 = m1 g + f(slope)\n" in equations(on_slope(0.1, 0.5))


def test_a_load_on_a_slack_rigid_rope_comes_to_rest_when_the_rope_is_taut():
    rope = RigidRope("rope", (Line(Point(WORLD), Point("load")),), L)
    guide = Joint("up", "prismatic", WORLD, "load", axis=Z, q0=(0.5 - L,))
    found = equilibrium(started(System((Body("load", M),), (guide,), rigid_ropes=(rope,), gravity=G)))
    assert found.q == pytest.approx([-L], abs=1e-9)
    assert found.tensions["rope"] == pytest.approx(M * G, rel=1e-9)
