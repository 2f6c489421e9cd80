"""Misleading cases of heavy lifts, each against a closed form or independent equations."""

from dataclasses import replace
from math import cos, pi, radians, sin, sqrt

import numpy as np
import pytest
from heavylift.kernel.description import Body, Joint, Line, Point, Rope, Support, System
from independent import planar
from small_scenes import EA, LENGTH, MASS, SECOND, G, column, cube, hand_over, hung, started, times

FINE = {"tolerance": 1e-10, "sample_ns": SECOND // 20}
UPRIGHT = (0.0, 0.0, 0.0, 1.0)
LINEAR = 1e-3  # what small angles and quasi-static winches leave out


def block(mass, ropes, p=(0.0, 0.0, 0.0), q=UPRIGHT, inertia=None, v=(0.0,) * 6, **more) -> System:
    float_ = Joint("float", "free", "world", "block", q0=(*p, *q), v0=v)
    return System((Body("block", mass, inertia=inertia or cube(mass)),), (float_,), ropes=ropes, gravity=G, **more)


def sling(name, a, b, EA_, L0, c=0.0, **more) -> Rope:
    return Rope(name, (Line(Point("world", a), Point("block", b)),), EA_, L0, c, **more)


def test_a_block_snaps_through_past_90_degrees_with_its_centre_over_the_rope_line():
    """A block hangs on edge from two lugs below its centre of mass; one rope is let go and it turns over."""
    m, L, c = 2e4, 12.0, 2e4
    lugs, anchors = ((-2.0, -0.4), (2.0, -0.4)), ((-2.0, L - 0.4), (2.0, L - 0.4))
    ropes = tuple(
        sling(f"rope{n}", (a[0], 0.0, a[1]), (b[0], 0.0, b[1]), 2e7, L, c)
        for n, (a, b) in enumerate(zip(anchors, lugs, strict=True))
    )
    down = -0.5 * m * G / 2e7 * L
    s = started(block(m, ropes, (0.0, 0.0, down)), **FINE)
    hand_over(s, SECOND // 10)
    s.unhook("rope1")
    s.settle()
    y = s.state
    begin = [y[0], y[2], 2.0 * np.arctan2(y[4], y[6]), y[7], y[9], y[11]]
    hand_over(s, SECOND * 31 // 10)
    left = [(*anchors[0], *lugs[0], 2e7, L, c)]
    want = planar(m, cube(m)[1][1], left, begin, 3.0, 1e-11)
    R = s.row().poses.reshape(-1, 12)[0, 3:].reshape(3, 3)
    tilt = np.arctan2(R[0, 2], R[0, 0])
    tilts = [2.0 * np.arctan2(q[4], q[6]) for q in column(s, "joint/position")[1]]
    assert max(np.abs(tilts)) > radians(90.0), "it passes 90 degrees"
    assert (tilt - want[2] + pi) % (2.0 * pi) - pi == pytest.approx(0.0, abs=1e-4)
    assert s.state[[0, 2]] == pytest.approx(want[:2], abs=1e-4)


def test_a_symmetric_scene_stays_symmetric_bit_for_bit():
    """A block falls into four slings: all become taut in one nanosecond, and nothing turns it, not by one bit."""
    corners = [(x, y) for x in (-3.0, 3.0) for y in (-2.0, 2.0)]
    ropes = tuple(
        sling(f"s{n}", (2.0 * x, 2.0 * y, 20.0), (x, y, 1.0), 1e8, 19.5, 1e5) for n, (x, y) in enumerate(corners)
    )
    s = started(block(1e5, ropes), **FINE)
    hand_over(s, 2 * SECOND)
    taut = [t for t, e in s.log if e.what == "taut"]
    assert len(taut) >= 4
    assert len(set(taut[:4])) == 1, "one nanosecond"
    T = column(s, "rope/tension")[1]
    assert T.max() > 0.0
    assert all(row.tobytes() == np.full(4, row[0]).tobytes() for row in T)
    y = s.state
    assert [float(x) for x in y[[0, 1, 3, 4, 5, 7, 8, 10, 11, 12]]] == [0.0] * 10


def test_statically_indeterminate_pads_open_where_statics_predicts():
    """A stiff block on four springy pads, lifted off its centre: two pads open, at one instant, at F = W/(1 + a/s)."""
    W, half, lateral, k, v = MASS * G, 5.0, 1.0, 5e8, 2e-2
    pads = tuple(
        Support(f"pad{n}", Point("block", (x, y, 0.0)), 0.0, k, 0.5 * sqrt(k * MASS))
        for n, (x, y) in enumerate([(x, y) for x in (-half, half) for y in (-2.0, 2.0)])
    )
    rope = sling("rope", (lateral, 0.0, 50.0), (lateral, 0.0, 0.0), EA, 50.0 + W / 4.0 / k, winch=True)
    i = cube(MASS, 8.0)
    s = started(block(MASS, (rope,), (0.0, 0.0, -W / 4.0 / k), inertia=i, supports=pads), **FINE)
    s.references.set_profile("rope", 0, -v, 1e-2, None)
    s.settle()
    hand_over(s, 8 * SECOND)
    opened = {n: times(s, f"pad{n}", "open") for n in range(4)}
    assert opened[2][0] == opened[3][0], "the two nearer ones together"
    t, T = column(s, "rope/tension")
    load = float(np.interp(opened[2][0], t, T[:, 0]))
    assert load == pytest.approx(W / (1.0 + lateral / half), rel=5e-3)
    assert not opened[0], "the others still carry"


def test_friction_holds_an_off_lead_of_half_a_degree_until_the_pad_is_nearly_unloaded():
    """T sin a = mu (W - T cos a): the load slips at T = mu W / (sin a + mu cos a), 93.2 % of its weight."""
    a, mu, k = radians(0.5), 0.12, 2e9
    W, h = MASS * G, 60.0
    pad = Support("pad", Point("block"), 0.0, k, 0.5 * sqrt(k * MASS), mu, 2e9, 1e7)
    rope = sling("rope", (h * np.tan(a), 0.0, h), (0.0, 0.0, 0.0), EA, h / cos(a) + 1e-3, winch=True)
    s = started(block(MASS, (rope,), (0.0, 0.0, -W / k), inertia=cube(MASS, 10.0), supports=(pad,)), **FINE)
    s.references.set_profile("rope", 0, -5e-3, 1e-2, None)
    s.settle()
    hand_over(s, 35 * SECOND)
    slip = times(s, "pad", "slip")[0]
    t, T = column(s, "rope/tension")
    assert float(np.interp(slip, t, T[:, 0])) == pytest.approx(mu * W / (sin(a) + mu * cos(a)), rel=5e-3)


def test_an_unloaded_lifting_beam_on_two_falls_yaws_with_its_closed_form_period():
    """Two parallel falls b apart and L long turn a loader back with T b^2/4L: the slow mode that cranes know."""
    m, b, L, i = 12e3, 1.2, 40.0, 9e3
    ropes = tuple(sling(f"fall{n}", (x, 0.0, L), (x, 0.0, 0.0), 1e9, L) for n, x in enumerate((-b / 2, b / 2)))
    yaw = 1e-3
    q = (0.0, 0.0, sin(yaw / 2), cos(yaw / 2))
    inertia = ((i, 0.0, 0.0), (0.0, i, 0.0), (0.0, 0.0, i))
    rise = 0.5 * (b * yaw / 2) ** 2 / L
    s = started(block(m, ropes, (0.0, 0.0, -m * G / 2e9 * L + rise), q, inertia), **FINE, method="dop853")
    quarter = 0.5 * pi * sqrt(i / (m * G * b * b / (4.0 * L)))
    hand_over(s, round(quarter * SECOND))
    assert 2.0 * float(s.state[5]) == pytest.approx(0.0, abs=LINEAR * yaw)
    hand_over(s, round(2.0 * quarter * SECOND))
    assert 2.0 * float(s.state[5]) == pytest.approx(-yaw, rel=LINEAR)


@pytest.mark.parametrize("method", ["dopri5", "dop853", "radau5"])
def test_a_tension_spike_of_20_ms_between_two_samples_is_found_as_peak_tension(method):
    """A light body touches its rope's end for half a period, half a second away from the samples."""
    m, spike, h = 100.0, 0.02, 0.2
    w = pi / spike
    scene = hung(LENGTH - h)
    scene = replace(
        scene, bodies=(replace(scene.bodies[0], mass=m),), ropes=(replace(scene.ropes[0], EA=m * w * w * LENGTH),)
    )
    s = started(scene, tolerance=1e-10, sample_ns=SECOND // 2, method=method)
    hand_over(s, SECOND // 2)
    caught, slack = times(s, "rope", "taut")[0], times(s, "rope", "slack")[0]
    assert slack - caught == pytest.approx(spike, rel=0.1)
    tensions, peaks = column(s, "rope/tension")[1], column(s, "rope/peak")[1]
    want = m * G + sqrt((m * G) ** 2 + 2.0 * m * w * w * m * G * h)
    assert tensions.max() < 1e-6 * want, "no sample has seen it"
    assert peaks.max() == pytest.approx(want, rel=1e-4)


def test_a_sling_breaks_at_its_full_load():
    """480 t on seven slings, one breaks: the others share anew as a stiff plate on springs says, after the bounce."""
    m, L, EA_, broken = 4.8e5, 20.0, 6e8, 2
    at = [(-9.0, -4.0), (-9.0, 4.0), (-3.0, -4.0), (-3.0, 4.0), (3.0, -4.0), (3.0, 4.0), (9.0, 0.0)]
    k = EA_ / L

    def shares(places):
        A = np.array([(1.0, x, y) for x, y in places])
        return A @ np.linalg.solve(A.T @ A, [m * G, 0.0, 0.0])

    inertia = ((m * 30.0, 0.0, 0.0), (0.0, m * 60.0, 0.0), (0.0, 0.0, m * 80.0))
    ropes = tuple(sling(f"s{n}", (x, y, L), (x, y, 0.0), EA_, L, 0.15 * sqrt(k * m)) for n, (x, y) in enumerate(at))
    mean = m * G / 7.0 / k
    s = started(block(m, ropes, (0.0, 0.0, -mean), inertia=inertia), **FINE)
    hand_over(s, 20 * SECOND)
    assert np.array(s.row().tension) == pytest.approx(shares(at), rel=LINEAR)
    s.unhook(f"s{broken}")
    s.settle()
    hand_over(s, 60 * SECOND)
    rest = [p for n, p in enumerate(at) if n != broken]
    T = np.array(s.row().tension)
    assert T[broken] == 0.0
    assert np.delete(T, broken) == pytest.approx(shares(rest), rel=5e-3)
    assert T.sum() == pytest.approx(m * G, rel=5e-3)
    peaks = column(s, "rope/peak")[1].max(axis=0)
    assert peaks.max() > 1.1 * T.max(), "and the bounce was more than the rest"


@pytest.mark.parametrize("aside", [0.0, 1e-3, -1e-3])
@pytest.mark.parametrize("method", ["dopri5", "dop853", "radau5"])
def test_a_sling_carries_nothing_if_the_centre_of_mass_lies_right_below_the_lug_of_the_other_sling(method, aside):
    """Right under a lug, and a millimetre to either side: the second sling carries W a/b, nothing, or hangs slack.

    It is longer by what the first one stretches, so that the block hangs level.
    """
    b, L, EA_ = 6.0, 10.0, 2e8
    W, k = MASS * G, EA_ / L
    share = aside / b
    ropes = tuple(
        sling(name, (x, 0.0, L), (x, 0.0, 0.0), EA_, length, 0.2 * sqrt(k * MASS))
        for name, x, length in (("over", 0.0, L), ("far", b, L + W / k))
    )
    body = Body("block", MASS, (aside, 0.0, -2.0), cube(MASS, 6.0))
    float_ = Joint("float", "free", "world", "block", q0=(0.0, 0.0, -W / k, *UPRIGHT))
    s = started(System((body,), (float_,), ropes=ropes, gravity=G), tolerance=1e-9, method=method)
    hand_over(s, 60 * SECOND)
    T = np.array(s.row().tension)
    assert T.sum() == pytest.approx(W, rel=LINEAR)
    assert T[1] == pytest.approx(max(0.0, share * W), abs=5e-5 * W)
    assert not s.notes
    assert len(s.log) < 200
