"""Boxes of equal width whose borders coincide touch like other boxes and slide past each other."""

from math import sqrt

import pytest
from contact_scenes import STILL, brick, floating
from heavylift.kernel.description import Box, Contact, Joint, System
from scipy.spatial.transform import Rotation
from small_scenes import SECOND, G, events, started, times

CUBE = (1.0, 1.0, 1.0)
NANOMETRE = 1e-9  # [m] what a nanosecond of motion may leave
NANOSECOND = 2e-9  # [s] event times are rounded up


def over_a_cube(p, size=CUBE, v=STILL, gravity=G, yaw=0.0):
    """A box that starts at p above or beside a fixed cube at the origin, both turned by yaw."""
    R = Rotation.from_euler("z", yaw)
    post = Joint("post", "fixed", "world", "w", R_PJ=tuple(map(tuple, R.as_matrix().tolist())))
    a = floating("a", p, tuple(map(float, R.as_quat())), v)
    pair = Contact("pair", Box("a", size), Box("w", CUBE), 0.5)
    return System((brick("w", CUBE, 1.0), brick("a", size, 1.0)), (post, a), contacts=(pair,), gravity=gravity)


@pytest.mark.parametrize(("x", "yaw"), [(0.0, 0.0), (0.0, 0.4), (1e-9, 0.4), (0.4, 0.0)])
@pytest.mark.parametrize("size", [CUBE, (0.5, 1.0, 1.0), (1.0, 2.0, 1.0)])
@pytest.mark.large(beyond=1)
def test_a_box_falls_on_a_cube_of_equal_width_and_rests(size, x, yaw):
    place = tuple(Rotation.from_euler("z", yaw).apply([x, 0.0, 1.5]))
    s = started(over_a_cube(place, size, yaw=yaw))
    s.run(SECOND)
    assert times(s, "pair", "impact") == pytest.approx([sqrt(2 * 0.5 / G)], abs=NANOSECOND)
    assert s.state[:3] == pytest.approx([*place[:2], 1.0], abs=NANOMETRE)


def test_a_cube_on_a_rail_collides_with_an_equal_cube():
    s = started(over_a_cube((-2.0, 0.0, 0.0), v=(1.0, *STILL[1:]), gravity=0.0))
    s.run(3 * SECOND)
    assert times(s, "pair", "impact") == pytest.approx([1.0], abs=NANOSECOND)
    assert s.state[:3] == pytest.approx([-1.0, 0.0, 0.0], abs=NANOMETRE)


@pytest.mark.large
def test_a_cube_rests_on_an_equal_cube():
    first = over_a_cube((0.0, 0.0, 1.0))
    pair = Contact("upper", Box("b", CUBE), Box("a", CUBE), 0.5)
    bodies, joints = (*first.bodies, brick("b", CUBE, 1.0)), (*first.joints, floating("b", (0.0, 0.0, 2.0)))
    s = started(System(bodies, joints, contacts=(*first.contacts, pair), gravity=G))
    s.run(2 * SECOND)
    assert s.state[[2, 9]] == pytest.approx([1.0, 2.0], abs=NANOMETRE)


def test_a_cube_sliding_down_flush_with_another_does_not_catch_on_its_edge():
    s = started(over_a_cube((1.0, 0.0, 1.5)))
    s.interrupt(SECOND)
    assert s.state[2] == pytest.approx(1.5 - 0.5 * G, rel=1e-9)
    assert not events(s)
