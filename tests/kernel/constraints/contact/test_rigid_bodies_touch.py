"""Rigid contact against closed forms: sliding, tipping, rocking, bouncing, and three balls in a row."""

from math import acosh, atan, cos, sin, sqrt

import numpy as np
import pytest
from contact_scenes import (
    ball,
    bouncing,
    brick,
    leaning,
    on_slope,
    rocker,
    rocking,
    row_of_balls,
    sliding_acceleration,
    stacked,
    tumbling,
    way,
)  # fmt: skip
from heavylift.kernel.description import Ball, Body, Box, Contact, Joint, Plane, System
from small_scenes import SECOND, G, column, events, imbalance, started, times

FINE = {"tolerance": 1e-10}
BALANCE = 1e-6  # places are brought back to the surface at a touch, by what a nanosecond of motion is
NANOSECOND = 2e-9  # [s] event times are rounded up
MU = 0.4


@pytest.mark.parametrize("part", [0.5, 0.999])
def test_a_block_on_a_slope_sticks_below_the_friction_angle(part):
    angle = part * atan(MU)
    s = started(on_slope(angle, MU), **FINE)
    s.run(20 * SECOND)
    assert way(s.state, angle) == pytest.approx([0.0, 0.0, 0.5], abs=1e-12)
    assert column(s, "contact/force")[1][-1] == pytest.approx(10.0 * G * cos(angle), rel=1e-9)


@pytest.mark.parametrize("part", [1.001, 1.5])
def test_above_the_friction_angle_a_block_slides_down_with_acceleration_g_sin_minus_mu_g_cos(part):
    angle = part * atan(MU)
    s = started(on_slope(angle, MU), **FINE)
    s.run(2 * SECOND)
    s.interrupt(2 * SECOND)
    assert way(s.state, angle) == pytest.approx([0.5 * sliding_acceleration(angle, MU) * 4.0, 0.0, 0.5], abs=1e-9)
    assert imbalance(s) < BALANCE


def test_a_sliding_block_stops_after_the_distance_v_squared_over_two_a_and_stays_there():
    angle, v = 0.5 * atan(MU), 3.0
    a = -sliding_acceleration(angle, MU)
    s = started(on_slope(angle, MU, v), **FINE)
    s.run(5 * SECOND)
    assert events(s) == [("slope", "stick")]
    assert times(s, "slope", "stick") == pytest.approx([v / a], abs=NANOSECOND)
    assert way(s.state, angle)[0] == pytest.approx(v * v / (2 * a), abs=1e-8)
    assert imbalance(s) < BALANCE


def test_a_block_slides_uphill_stops_and_slides_back():
    angle, v = 1.4 * atan(MU), -3.0
    up, down = G * (sin(angle) + MU * cos(angle)), sliding_acceleration(angle, MU)
    s = started(on_slope(angle, MU, v), **FINE)
    s.run(2 * SECOND)
    s.interrupt(2 * SECOND)
    turn = -v / up
    assert way(s.state, angle)[0] == pytest.approx(-v * v / (2 * up) + 0.5 * down * (2.0 - turn) ** 2, abs=1e-7)


@pytest.mark.parametrize(("part", "tips"), [(0.98, False), (1.02, True)])
def test_a_block_on_a_slope_tips_where_the_slope_exceeds_b_over_h(part, tips):
    """It cannot slide (mu = 2), so it tips if tan(angle) > b / h."""
    b, h = 0.3, 0.5
    angle = atan(part * b / h)
    s = started(on_slope(angle, 2.0, size=(2 * b, 1.0, 2 * h)), **FINE)
    s.run(SECOND)
    assert (leaning(s.state) > angle + 1e-3) == tips
    if not tips:
        assert leaning(s.state) == pytest.approx(angle, abs=1e-9)


def test_a_rocking_block_has_the_period_and_energy_loss_of_housner():
    """First impact at arccosh(1 / (1 - theta/alpha)) / p for small angles; w' / w = 1 - 3/2 sin^2(alpha) at each."""
    b, h, part = 0.02, 0.4, 0.3
    alpha, p = rocking(b, h)
    s = started(rocker(b, h, part * alpha), **FINE, sample_ns=100_000)
    s.run(int(0.9 * SECOND))
    impacts = times(s, "ground", "impact")
    assert impacts[0] == pytest.approx(acosh(1.0 / (1.0 - part)) / p, rel=alpha * alpha)
    kinetic = dict(zip(*(x.tolist() for x in (column(s, "energy")[0], column(s, "energy")[1][:, 0])), strict=True))
    t = np.array(list(kinetic))
    ratio = 1.0 - 1.5 * sin(alpha) ** 2
    for hit in impacts[:2]:
        i = int(np.searchsorted(t, hit - 1e-12))
        before, after = (list(kinetic.values())[k] for k in (i - 1, i))
        assert after / before == pytest.approx(ratio**2, abs=2e-3), "samples lie up to 0.1 ms before the impact"
    assert imbalance(s) < BALANCE


def test_a_rocking_block_comes_to_rest():
    """Infinitely many impacts in finite time end in a capture, which the log says."""
    b, h = 0.1, 0.5
    alpha, _ = rocking(b, h)
    s = started(rocker(b, h, 0.2 * alpha), **FINE)
    s.run(20 * SECOND)
    assert events(s)[-1] == ("ground", "captured")
    assert s.state[2] == pytest.approx(h, abs=1e-9)
    assert np.abs(s.state[s.program.nq : s.program.nq + 6]).max() < 1e-9
    assert s.next_ns > 20 * SECOND


def test_only_the_last_of_three_balls_in_a_row_leaves_if_there_are_gaps_between_them():
    touching = started(row_of_balls(0.0, 1.0), **FINE)
    touching.run(2 * SECOND)
    nq = touching.program.nq
    assert touching.state[nq : nq + 18 : 6] == pytest.approx([-1 / 3, 2 / 3, 2 / 3], abs=1e-9)
    apart = started(row_of_balls(1e-3, 1.0), **FINE)
    apart.run(2 * SECOND)
    assert apart.state[nq : nq + 18 : 6] == pytest.approx([0.0, 0.0, 1.0], abs=1e-9)
    assert times(apart, "ab", "impact") == pytest.approx([1.0], abs=NANOSECOND)
    assert times(apart, "bc", "impact") == pytest.approx([1.001], abs=2 * NANOSECOND)
    soft = started(row_of_balls(0.0, 0.0), **FINE)
    soft.run(2 * SECOND)
    assert soft.state[nq : nq + 18 : 6] == pytest.approx([1 / 3] * 3, abs=1e-9), (
        "without restitution they run on as one"
    )


def test_a_bouncing_ball_comes_to_rest_after_infinitely_many_bounces():
    height, e = 1.0, 0.6
    first = sqrt(2.0 * height / G)
    s = started(bouncing(height, e), **FINE)
    s.run(4 * SECOND)
    hits = times(s, "floor", "impact")
    expected = [first * (1.0 + 2.0 * sum(e**k for k in range(1, n + 1))) for n in range(6)]
    assert hits[:6] == pytest.approx(expected, abs=20 * NANOSECOND)
    (end,) = times(s, "floor", "captured")
    left = 2 * 1e-4 / G / (1.0 - e)  # what bounces slower than 0.1 mm/s would still take
    assert end == pytest.approx(first * (1.0 + 2.0 * e / (1.0 - e)), abs=left)
    assert events(s)[-1] == ("floor", "closed")
    assert s.state[2] == pytest.approx(0.5, abs=1e-12)
    assert imbalance(s) < BALANCE


@pytest.mark.parametrize("restitution", [0.0, 0.6])
def test_contacts_do_not_penetrate_and_never_create_energy(restitution):
    """A brick is thrown onto the ground with spin and friction, and comes to rest on one of its faces."""
    s = started(thrown(restitution), **FINE, sample_ns=2_000_000)
    s.run(5 * SECOND)
    assert min(abs(s.state[2] - half) for half in (0.5, 0.3, 0.2)) < 1e-9
    _, e = column(s, "energy")
    mechanical = e[:, 0] + e[:, 1]
    assert np.diff(mechanical).max() < 1e-7 * mechanical[0]
    assert imbalance(s) < 10 * BALANCE
    poses = column(s, "pose/brick")[1]
    assert min(lowest(p) for p in poses) > -1e-8
    assert events(s)


def thrown(restitution):
    from scipy.spatial.transform import Rotation

    scene = on_slope(0.0, 0.3, size=(1.0, 0.6, 0.4))
    q = Rotation.from_euler("xyz", [0.4, 0.3, 0.2]).as_quat()
    (joint,) = scene.joints
    flying = type(joint)(joint.name, joint.kind, joint.parent, joint.child, q0=(0.0, 0.0, 1.0, *q),
                         v0=(2.0, 0.5, 0.0, 1.0, 2.0, 0.5))  # fmt: skip
    (floor,) = scene.contacts
    floor = Contact(floor.name, floor.a, floor.b, floor.mu, restitution)
    return System(scene.bodies, (flying,), contacts=(floor,), gravity=G)


def lowest(pose):
    from scipy.spatial.transform import Rotation

    corners = np.array([(x, y, z) for x in (-0.5, 0.5) for y in (-0.3, 0.3) for z in (-0.2, 0.2)])
    return (Rotation.from_quat(pose[3:]).apply(corners) + pose[:3])[:, 2].min()


@pytest.mark.parametrize(("offset", "falls"), [(0.95, False), (1.05, True)])
@pytest.mark.large
def test_a_box_tips_off_another_when_its_centre_passes_the_edge(offset, falls):
    s = started(stacked(offset), **FINE)
    s.run(SECOND)
    assert (s.state[2] < 1.4) == falls
    if not falls:
        assert s.state[2] == pytest.approx(1.5, abs=1e-9)


@pytest.mark.large
def test_a_beam_laid_across_another_beam_rests_on_four_edge_crossings():
    s = started(stacked(0.0, size=(4.0, 1.0, 1.0), yaw=0.0), **FINE)
    s.run(SECOND)
    assert s.state[:3] == pytest.approx([0.0, 0.0, 1.5], abs=1e-9)
    assert column(s, "contact/force")[1][-1] == pytest.approx(5.0 * G, rel=1e-8)


@pytest.mark.parametrize("seed", [0, 8])
@pytest.mark.large
def test_a_cube_tumbles_over_the_edge_of_another_cube(seed):
    """Vertices on faces and edges on edges, one after the other and together: the balance closes, nothing sinks in."""
    s = started(tumbling(seed), **FINE, sample_ns=5_000_000)
    s.run(2 * SECOND)
    _, e = column(s, "energy")
    assert np.diff(e[:, 0] + e[:, 1]).max() < 1e-8 * np.ptp(e[:, 0])
    assert imbalance(s) < BALANCE
    low, up = (column(s, f"pose/{name}")[1] for name in ("low", "up"))
    assert min(apart(a, b) for a, b in zip(up, low, strict=True)) > -1e-8
    assert ("pair", "impact") in events(s)


def test_a_ball_that_slides_over_the_edge_of_a_box_leaves_the_edge_at_the_angle_of_the_closed_form():
    """Without friction it turns about the edge until its weight no longer keeps it there: cos = 2/3 + v^2 / 3 g r."""
    v, r = 0.2, 0.5
    body, joint = ball("ball", r, 2.0, (0.9, 0.0, 1.0 + r), (v, 0.0, 0.0, 0.0, 0.0, 0.0))
    post = Joint("post", "fixed", "world", "low")
    pair = Contact("pair", Ball("ball", radius=r), Box("low", (2.0, 2.0, 2.0)), 0.0)
    scene = System((brick("low", (2.0, 2.0, 2.0), 10.0), body), (post, joint), contacts=(pair,), gravity=G)
    s = started(scene, **FINE, subscribed=frozenset(["pair"]))
    s.run(3 * SECOND)
    assert s.next_ns == pytest.approx(0.1 / v * SECOND, abs=50), "it comes to the edge"
    s.fire()
    s.settle()
    s.run(3 * SECOND)
    s.fire()
    assert events(s)[-1] == ("pair", "open")
    x, _, z = s.state[:3]
    assert np.hypot(x - 1.0, z - 1.0) == pytest.approx(r, abs=1e-8)
    assert (z - 1.0) / r == pytest.approx(2.0 / 3.0 + v * v / (3.0 * G * r), abs=1e-7)
    assert imbalance(s) < BALANCE


def test_a_ball_bounces_off_a_corner_along_the_line_of_centres():
    """Falling on a corner with e = 1 and no friction it is thrown along the line from the corner to its centre."""
    n = np.array([1.0, 2.0, 2.0]) / 3.0
    body, joint = ball("ball", 0.3, 2.0, np.ones(3) + 0.4 * n, (*-n, 0.0, 0.0, 0.0))
    post = Joint("post", "fixed", "world", "low")
    pair = Contact("pair", Ball("ball", radius=0.3), Box("low", (2.0, 2.0, 2.0)), 0.0, 1.0)
    scene = System((brick("low", (2.0, 2.0, 2.0), 10.0), body), (post, joint), contacts=(pair,), gravity=0.0)
    s = started(scene, **FINE)
    s.run(SECOND // 2)
    s.interrupt(SECOND // 2)
    assert events(s) == [("pair", "impact")]
    assert s.state[:3] == pytest.approx(np.ones(3) + 0.7 * n, abs=1e-8)


@pytest.mark.parametrize("seed", [9, 14, 30, 31])
@pytest.mark.large(beyond=1)
def test_the_iteration_of_contact_states_converges_when_a_cube_catches_on_an_edge(seed):
    """Contacts that begin to slide do so from rest, whatever round-off has left of another motion."""
    s = started(tumbling(seed))
    s.run(3 * SECOND)
    assert len(s.log) < 50
    assert imbalance(s) < 1e-5


def apart(up, low):
    """Largest separation of the two cubes over all fifteen directions."""
    from scipy.spatial.transform import Rotation

    A, B = (Rotation.from_quat(p[3:]).as_matrix().T for p in (up, low))
    d = up[:3] - low[:3]
    directions = [*A, *B, *(np.cross(a, b) for a in A for b in B)]
    lengths = [np.linalg.norm(n) for n in directions]
    units = [n / size for n, size in zip(directions, lengths, strict=True) if size > 1e-3]
    return max(abs(n @ d) - 0.5 * np.abs(A @ n).sum() - 1.0 * np.abs(B @ n).sum() for n in units)


@pytest.mark.parametrize("hinges", [1, 2])
def test_an_arm_on_one_or_two_coaxial_hinges_falls_until_its_tip_rests_on_the_floor(hinges):
    """The second hinge closes a loop that holds nothing new; nor can the tip move across."""
    arm = Body("arm", 2.0, (0.5, 0.0, 0.0), ((0.1, 0.0, 0.0), (0.0, 0.1, 0.0), (0.0, 0.0, 0.1)))
    place = {"axis": (0.0, 1.0, 0.0), "p_PJ": (0.0, 0.0, 0.2)}
    joints = [
        Joint(f"hinge{i}", "revolute", "world", "arm", q0=(-0.5,) if i == 0 else (), **place) for i in range(hinges)
    ]
    tip = Contact("tip", Ball("arm", (1.0, 0.0, 0.0)), Plane(), 0.3, 0.5)
    s = started(System((arm,), tuple(joints), contacts=(tip,), gravity=G), **FINE)
    s.run(3 * SECOND)
    assert s.state[0] == pytest.approx(np.arcsin(0.2), abs=1e-9)
    assert imbalance(s) < BALANCE
