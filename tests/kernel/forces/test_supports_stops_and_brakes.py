"""Supports, end stops and brakes against closed forms: load shares, bounces, sticking and slipping."""

from dataclasses import replace
from math import atan2, ceil, cos, hypot, log2, pi, radians, sin, sqrt

import numpy as np
import pytest
from heavylift.kernel.description import Body, Brake, Joint, JointSpring, Line, Point, Rope, Stop, Support, System
from heavylift.kernel.forces import SupportAt, SupportLaw
from small_scenes import SECOND, G, X, cube, events, hand_over, imbalance, slider, started, times

FINE = {"tolerance": 1e-11, "h_max": 0.01}


def block_on_pads(mass, com, feet, z, mu=0.0, v0=(0.0,) * 6):
    """A floating block whose underside is its frame's plane z = 0, at height z above pads of 5 mm settlement."""
    k = mass * G / len(feet) / 5e-3
    d = 2 * 0.3 * sqrt(k * mass / len(feet))
    pads = tuple(Support(f"pad{i}", Point("block", (x, y, 0.0)), 0.0, k, d, mu, k, d) for i, (x, y) in enumerate(feet))
    return System(
        (Body("block", mass, com, cube(mass, 10.0)),),
        (Joint("float", "free", "world", "block", q0=(0.0, 0.0, z, 0.0, 0.0, 0.0, 1.0), v0=v0),),
        supports=pads,
        gravity=G,
    )


def test_three_pads_share_a_block_by_the_position_of_its_centre_of_mass():
    """Barycentric shares of C08a: area opposite each foot over the whole."""
    feet = ((-10.0, -8.0), (-10.0, 8.0), (11.0, 0.0))
    mass = 5883990.0 / G
    s = started(block_on_pads(mass, (1.5, 0.6, 5.0), feet, 0.0), **FINE)
    s.run(60 * SECOND)
    shares = (0.1886904761904762, 0.2636904761904762, 0.5476190476190477)
    N = s.row().normal
    # the block leans by the different settlements, which moves its centre of mass 5 m above the pads by millimetres
    assert pytest.approx(shares, abs=2e-3) == N / 5883990.0
    assert N.sum() == pytest.approx(5883990.0, rel=1e-7)
    flat = started(block_on_pads(mass, (1.5, 0.6, 0.0), feet, 0.0), **FINE)
    flat.run(120 * SECOND)
    assert flat.row().normal / 5883990.0 == pytest.approx(shares, rel=1e-5)


def test_a_block_settles_by_five_millimetres_on_its_supports():
    feet = ((-4.0, -4.0), (-4.0, 4.0), (4.0, -4.0), (4.0, 4.0))
    s = started(block_on_pads(9.0e5, (0.0, 0.0, 5.0), feet, 0.02), **FINE)
    s.run(60 * SECOND)
    assert s.state[2] == pytest.approx(-5e-3, rel=1e-6)
    touched = [times(s, f"pad{i}", "closed")[0] for i in range(4)]
    assert touched == pytest.approx([sqrt(2 * 0.02 / G)] * 4, abs=2e-9), "free fall over 20 mm, rounded up to ns"
    assert all(sum(r) == pytest.approx(9.0e5 * G, rel=1e-6) for r in [s.row().normal])


def test_a_sliding_block_stops_after_the_distance_v_squared_over_two_mu_g():
    feet = ((-4.0, -4.0), (-4.0, 4.0), (4.0, -4.0), (4.0, 4.0))
    mu, v = 0.2, hypot(1.2, 0.5)
    scene = block_on_pads(1.0e5, (0.0, 0.0, 0.0), feet, -5e-3, mu, (1.2, 0.5, 0.0, 0.0, 0.0, 0.0))
    s = started(scene, **FINE)
    s.run(10 * SECOND)
    distance = hypot(s.state[0], s.state[1])
    k = 1.0e5 * G / 5e-3
    springs = mu * G * 1.0e5 / k  # the springs of the pads give way before they slip
    assert distance == pytest.approx(v * v / (2 * mu * G), abs=2 * springs)
    assert s.state[1] / s.state[0] == pytest.approx(0.5 / 1.2, rel=1e-6), "friction opposes the motion"
    assert {e for e in events(s)} == {(f"pad{i}", what) for i in range(4) for what in ("slip", "stick")}


@pytest.mark.parametrize(("pull", "slips"), [(0.9, False), (1.1, True)])
def test_a_block_pulled_sideways_sticks_below_the_friction_limit_and_slips_above_it(pull, slips):
    """Pads are level, so a tow rope takes the part of the slope; its sudden pull makes the block slip first."""
    mass, mu = 1.0e5, 0.2
    feet = ((-4.0, -4.0), (-4.0, 4.0), (4.0, -4.0), (4.0, 4.0))
    scene = block_on_pads(mass, (0.0, 0.0, 0.0), feet, -5e-3, mu)
    length, EA, force = 1000.0, 1.0e7, pull * mu * mass * G  # long and soft: the tension stays
    rope = Rope("tow", (Line(Point("block"), Point("world", (length, 0.0, -5e-3))),), EA, length / (1 + force / EA))
    s = started(replace(scene, ropes=(rope,)), **FINE)
    s.run(3 * SECOND)
    if slips:
        assert s.state[0] == pytest.approx((pull - 1.0) * mu * G * 3.0**2 / 2, rel=0.1)
    else:
        assert 0.0 < s.state[0] < 3e-3, "no creep: the springs go on with the force at which the slip ended"
        assert s.state[s.program.nq] == pytest.approx(0.0, abs=1e-6)


def test_a_block_lifted_while_it_leans_on_its_pads_separates_without_chatter():
    """The limit of friction falls with the load until it is below what the springs hold, again and again."""
    mass, mu = 1.0e5, 0.2
    feet = ((-4.0, -4.0), (-4.0, 4.0), (4.0, -4.0), (4.0, 4.0))
    scene = block_on_pads(mass, (0.0, 0.0, 0.0), feet, -5e-3, mu)
    length, EA, force = 1000.0, 1.0e7, 0.3 * mu * mass * G
    tow = Rope("tow", (Line(Point("block"), Point("world", (length, 0.0, -5e-3))),), EA, length / (1 + force / EA))
    hoist = Rope("hoist", (Line(Point("world", (0.0, 0.0, 30.0)), Point("block")),), 1.0e8, 30.0, 1e5, winch=True)
    s = started(replace(scene, ropes=(tow, hoist)), **FINE)
    hand_over(s, 5 * SECOND)
    s.references.set_profile("hoist", 5 * SECOND, 0.1, 0.1, -1.0)
    s.settle()
    s.run(12 * SECOND)
    slips = [e for e in events(s) if e[1] == "slip"]
    assert ("pad0", "open") in events(s)
    assert 4 <= len(slips) < 200
    assert imbalance(s) < 1e-8


def test_a_door_bounces_between_stop_and_closer_with_the_period_of_two_half_swings():
    """Half a swing in the spring alone, half a swing in spring and stop: pi/w1 + pi/w2; without damping, for ever."""
    inertia, k, k_stop = 2.0e4, 8.0e4, 1.5e6
    scene = System(
        (Body("door", 0.0, inertia=((inertia, 0.0, 0.0), (0.0, inertia, 0.0), (0.0, 0.0, inertia))),),
        (Joint("hinge", "revolute", "world", "door", axis=X, v0=(-0.2,)),),
        springs=(JointSpring("closer", "hinge", k),),
        stops=(Stop("stop", "hinge", -5.0, 0.0, k_stop, 0.0),),
        gravity=G,
    )
    s = started(scene, **FINE)
    s.run(40 * SECOND)
    closed, opened = times(s, "stop", "closed"), times(s, "stop", "open")
    free, pressed = pi / sqrt(k / inertia), pi / sqrt((k + k_stop) / inertia)
    assert closed[0] == pytest.approx(free, abs=1e-8)
    for n, (a, b) in enumerate(zip(closed[:5], opened[:5], strict=True)):
        assert a == pytest.approx(free + n * (free + pressed), abs=1e-7)
        assert b - a == pytest.approx(pressed, abs=1e-7)


def test_an_end_stop_separates_without_pulling():
    """With damping its force vanishes while the joint is still beyond the limit."""
    scene = replace(slider(axis=X, mass=1.0e4, v0=1.0), stops=(Stop("buffer", "load-guide", -1.0, 0.5, 4.0e5, 4.0e4),))
    s = started(scene, **FINE)
    s.run(2 * SECOND)
    (_, closed), (t_open, opened) = s.log[:2]
    assert (closed.what, closed.value, opened.what) == ("closed", 0.5, "open")
    w, zeta = sqrt(4.0e5 / 1.0e4), 4.0e4 / (2 * sqrt(4.0e5 * 1.0e4))
    damped = w * sqrt(1 - zeta**2)
    # k x + d x' = 0 for x = exp(-zeta w t) sin(wd t): contact time of a damped bounce
    contact = (pi - _lead(zeta)) / damped
    assert t_open * 1e-9 - 0.5 == pytest.approx(contact, abs=1e-8)
    assert -1.0 < s.state[1] < 0.0


def _lead(zeta):
    """Phase by which the force leads the deflection: tan = 2 zeta sqrt(1 - zeta^2) / (1 - 2 zeta^2)."""
    return atan2(2 * zeta * sqrt(1 - zeta**2), 1 - 2 * zeta**2)


def test_a_brake_stops_a_trolley_within_the_distance_v_squared_over_two_a():
    mass, v, force = 3.0e5, 0.5, 3.0e4
    brake = Brake("brake", "load-guide", force, 1.0e9, 1.0e6)
    s = started(replace(slider(axis=X, mass=mass, v0=v), brakes=(brake,)), **FINE)
    hand_over(s, 2 * SECOND)
    s.set_brake("brake", True)
    s.settle()
    s.run(20 * SECOND)
    a = force / mass
    assert events(s) == [("brake", "slip"), ("brake", "stick")]
    assert s.state[0] == pytest.approx(1.0 + v * v / (2 * a), abs=2 * force / 1.0e9)
    assert times(s, "brake", "stick")[0] == pytest.approx(2.0 + v / a, abs=1e-3)


@pytest.mark.parametrize("load", [0.9, 1.1])
def test_a_brake_holds_a_light_load_and_slips_under_a_heavy_one(load):
    mass = 1.0e3
    brake = Brake("brake", "load-guide", mass * G / load, 1.0e7, 1.0e5, True)
    s = started(replace(slider(mass=mass, q0=-mass * G / 1.0e7), brakes=(brake,)), **FINE)
    s.P[s.program.parameters.at["brake", "brake"]][5] = 0.0  # closed when the spring was not yet deflected
    s.settle()
    s.run(4 * SECOND)
    if load < 1.0:
        assert events(s) == []
        assert s.state[0] == pytest.approx(-mass * G / 1.0e7, rel=1e-6)
    else:
        assert events(s) == [("brake", "slip")]
        a = G * (1.0 - 1.0 / load)
        assert s.state[1] == pytest.approx(-a * s.now, rel=1e-3)  # the last step ends behind 4 s


def test_a_brake_on_an_inclined_guide_acts_as_coulomb_friction():
    """Coulomb friction as a brake of moment mu m g cos: slides with g (sin - mu cos)."""
    angle, mu, mass = radians(20.0), 0.2, 1.0e3
    brake = Brake("friction", "load-guide", mu * mass * G * cos(angle), 1.0e8, 1.0e6, True)
    s = started(replace(slider(mass=mass, axis=(cos(angle), 0.0, -sin(angle))), brakes=(brake,)), **FINE)
    s.interrupt(3 * SECOND)
    a = G * (sin(angle) - mu * cos(angle))
    assert events(s) == [("friction", "slip")]
    assert s.state[1] == pytest.approx(a * 3.0, abs=0.01)  # the spring gives way first


def test_a_pad_whose_contact_opens_does_not_report_slip_at_the_same_instant():
    """Friction and normal force vanish together, so that both guards can fall within one nanosecond."""
    s = started(block_on_pads(1e4, (0.0, 0.0, 0.0), ((0.0, 0.0),), -5e-3, mu=0.2), **FINE)
    both = [i for i, guard in enumerate(s.program.guards) if guard in (("support", "pad0"), ("rub", "pad0"))]
    assert len(both) == 2
    s.events.fallen, s.events.t_ns = both, 0
    assert [(e.name, e.what) for e in s.preview()] == [("pad0", "open")]
    s.events.fallen = both[1:]
    assert [(e.name, e.what) for e in s.preview()] == [("pad0", "slip")]


@pytest.mark.parametrize("late", [0.0, 1e-9, 1e-6, 4e-6, 1e-3])
@pytest.mark.parametrize("angle", [0.0, 0.7, 2.0, 4.5])
def test_a_pad_found_sticking_late_keeps_the_direction_of_its_friction_force(late: float, angle: float) -> None:
    """Steps may find it when the pad goes back already: the force goes on from that of the slip, and does not jump to
    the other side, where the limit would be passed at once."""
    mu, normal, k, d, along = 0.4, 1e5, 1e8, 1e6, np.array([cos(angle), sin(angle)])
    p = np.array([0.0, 0.0, 0.0, 0.0, k, d, mu, k, d, 1.0, 0.0, 0.0, 0.0, *along])
    pad = Support("pad", Point("block"), 0.0, k, d, mu, k, d)
    assert SupportLaw().switch(pad, p, "rub", np.array([normal, 0.0, 0.0, *(-late * along)]))[0] == "stick"
    held = -k * p[SupportAt.ANCHOR] - d * late * along
    assert held == pytest.approx(mu * normal * along, rel=1e-6, abs=1e-3)


@pytest.mark.parametrize("deflection", [5e-3, 3e-5, 4e-8])
@pytest.mark.parametrize("angle", [0.0, 0.7, 2.0, 4.5])
def test_a_pad_unloaded_by_a_relaxing_spring_slips_only_a_few_times(deflection: float, angle: float) -> None:
    """By halves, as the limit falls below what it holds, and wholly from a micrometre on: else without end."""
    mu, k, d, along = 0.4, 1e8, 1e6, np.array([cos(angle), sin(angle)])
    pad, velocity, times = Support("pad", Point("block"), 0.0, k, d, mu, k, d), -1e-9 * along, 0
    p = np.array([0.0, 0.0, 0.0, 0.0, k, d, mu, k, d, 1.0, 1.0, *(-deflection * along), 0.0, 0.0])
    while (held := hypot(*(d * velocity - k * p[SupportAt.ANCHOR]))) > 1e-3:
        assert SupportLaw().switch(pad, p, "rub", np.array([held / mu, 0.0, 0.0, *velocity]))[0] == "slip"
        assert p[SupportAt.STICK] == 1.0
        times += 1
    assert times == max(0, ceil(log2(deflection / 1e-6))) + 1


@pytest.mark.parametrize("angle", [0.0, 0.7, 2.0, 4.5])
@pytest.mark.parametrize("beside", [1e-9, 1e-8, 3e-8])
def test_a_creeping_pad_that_is_unloaded_does_not_alternate_between_slip_and_stick(beside: float, angle: float) -> None:
    """Its spring is turned, not stretched: that the limit is passed is the limit's doing, which falls."""
    mu, k, d, normal = 0.4, 4e7, 5e5, 645.0
    along, across = np.array([cos(angle), sin(angle)]), np.array([-sin(angle), cos(angle)])
    pad, velocity = Support("pad", Point("block"), 0.0, k, d, mu, k, d), 1e-10 * along + beside * across
    p = np.array([0.0, 0.0, 0.0, 0.0, k, d, mu, k, d, 1.0, 1.0, *(-mu * normal / k * along), 0.0, 0.0])
    assert SupportLaw().switch(pad, p, "rub", np.array([normal, 0.0, 0.0, *velocity]))[0] == "slip"
    assert p[SupportAt.STICK] == 1.0
    assert hypot(*(d * velocity - k * p[SupportAt.ANCHOR])) < 0.6 * mu * normal


@pytest.mark.parametrize("angle", [0.0, 0.6, 1.5, 3.0])
def test_a_block_that_slides_off_the_end_of_a_pad_falls_freely_and_keeps_its_energy_balance(angle: float) -> None:
    """Friction slows it to sqrt(v^2 - 2 mu g s) at the edge, a way s off; the energy of the spring becomes heat."""
    mu, v, size, along = 0.3, 4.0, (3.0, 2.0), (cos(angle), sin(angle))
    scene = block_on_pads(1e4, (0.0, 0.0, 0.0), ((0.0, 0.0),), -5e-3, mu, (v * along[0], v * along[1], *[0.0] * 4))
    s = started(replace(scene, supports=tuple(replace(pad, size=size) for pad in scene.supports)), **FINE)
    hand_over(s, SECOND)
    way = min(half / max(abs(x), 1e-12) for half, x in zip((1.5, 1.0), along, strict=True))
    speed = sqrt(v * v - 2.0 * mu * G * way)
    leaves = (v - speed) / (mu * G)
    (left,) = times(s, "pad0", "open")
    assert left == pytest.approx(leaves, abs=1e-6)
    assert s.state[:2] == pytest.approx([(way + speed * (1.0 - leaves)) * x for x in along], abs=1e-5)
    assert s.state[2] == pytest.approx(-5e-3 - 0.5 * G * (1.0 - leaves) ** 2, abs=1e-6)
    assert imbalance(s) < 1e-9
