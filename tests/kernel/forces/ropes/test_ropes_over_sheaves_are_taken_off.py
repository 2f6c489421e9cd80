"""A rope over sheaves is unhooked, breaks, and is hooked again: neighbouring ropes take over its load."""

from dataclasses import replace
from math import hypot, sqrt

import numpy as np
import pytest
from heavylift.kernel import KernelError
from heavylift.kernel.analysis import equilibrium
from heavylift.kernel.description import Body, Drive, InputSignal, Joint, Line, Point, Reeving, Rope, Sheave, System
from small_scenes import SECOND, G, Y, Z, column, cube, events, hand_over, imbalance, started

MASS, EA, R = 1000.0, 2e6, 0.2
FINE = {"tolerance": 1e-10, "sample_ns": SECOND // 50}
CLOSES = 1e-8  # of the energy turned over


def pair(damping: float, friction: float = 0.0) -> System:
    """A beam at rest under an equalised pair of legs 2 m to either side, over a sheave, and two plain ropes."""
    legs = [Point("beam", (x, 0.0, 0.0)) for x in (-2.0, 2.0)]
    rope = Reeving("pair", legs[0], (Sheave(Point("world"), Y, R, friction),), legs[1], EA, InputSignal(20.93), damping)
    lines = [Line(Point("world", (x, 0.0, 0.0)), Point("beam", (x, 0.0, 0.0))) for x in (-3.0, 3.0)]
    spares = tuple(Rope(name, (line,), EA, 10.0, damping) for name, line in zip("ab", lines, strict=True))
    float_ = Joint("free", "free", "world", "beam", q0=(0.0, 0.0, -10.01, 0.0, 0.0, 0.0, 1.0))
    scene = System((Body("beam", MASS, inertia=cube(MASS, 3.0)),), (float_,), ropes=spares, forces=(rope,), gravity=G)
    rest = equilibrium(started(scene)).q
    return replace(scene, joints=(replace(float_, q0=tuple(map(float, rest))),))


def test_the_load_of_a_broken_rope_pair_goes_to_the_neighbouring_ropes():
    """Before, all three share by their stiffness; after the ringing the two that are left carry the weight."""
    s = started(pair(3e4), **FINE)
    before = s.row()
    assert before.shown[0] == pytest.approx(before.shown[1], rel=1e-12)
    drop = -float(before.q[2])
    leg = sqrt(hypot(2.0, drop) ** 2 - R * R)  # tangents, and the sine of their slope
    slope = (drop * leg + 2.0 * R) / hypot(2.0, drop) ** 2
    assert sum(before.tension) + 2.0 * slope * before.shown[0] == pytest.approx(MASS * G, rel=1e-9)
    s.unhook("pair")
    s.settle()
    assert list(s.row().shown[:2]) == [0.0, 0.0]
    hand_over(s, 20 * SECOND)
    s.settle()
    assert s.row().tension == pytest.approx(np.full(2, MASS * G / 2), rel=1e-4)
    assert ("pair", "taut") not in events(s)[1:]
    assert imbalance(s) < CLOSES


def test_after_an_undamped_break_the_tension_of_the_other_rope_overshoots_by_the_full_lost_tension():
    """A step on an undamped spring: T = T_end + (T_end - T_before)."""
    s = started(pair(0.0), **FINE)
    before = float(s.row().tension[0])
    s.unhook("pair")
    s.settle()
    hand_over(s, SECOND)
    s.settle()
    assert column(s, "rope/peak")[1].max() == pytest.approx(MASS * G - before, rel=1e-6)
    assert imbalance(s) < CLOSES


def led(friction: float = 0.1, L0: float = 9.0):
    """A rope over a sheave, its end on a slide that a drive moves along z; at first it is not hooked."""
    lift = Joint("lift", "prismatic", "world", "end", (-3.0, 0.0, 0.0), axis=Z, q0=(0.5,))
    over = Sheave(Point("world"), Y, R, friction)
    rope = Reeving("r", Point("end"), (over,), Point("world", (3.0, 0.0, -2.0)), EA, InputSignal(L0), hooked=False)
    drive = Drive("z", "lift", "prescribed")
    return started(System((Body("end", 10.0),), (lift,), forces=(rope,), drives=(drive,), gravity=G), **FINE)


def move(s, way: float, seconds: int) -> None:
    s.set_profile("z", s.native.epoch, 1.0, 1e4, way)
    s.settle()
    hand_over(s, s.native.epoch + seconds * SECOND)


def test_a_rope_hooked_again_takes_the_path_between_its_new_ends():
    """Off, its end goes up past the sheave; hooked there it is straight; drawn down it finds the sheave and slides."""
    s = led()
    move(s, 4.0, 5)
    assert s.log == [], "nothing happens to a rope that is off"
    s.hook("r")
    s.settle()
    move(s, -9.5, 10)
    s.settle()
    assert events(s) == [("r", "found"), ("r", "taut"), ("r", "slip")]
    never = led()
    never.hook("r")
    never.settle()
    move(never, 4.0, 5)
    move(never, -9.5, 10)
    never.settle()
    (T, length), (T0, length0) = (x.row().shown[:4].reshape(2, 2) for x in (s, never))
    assert length.sum() == pytest.approx(length0.sum(), rel=1e-12), "as if it had been on all the time"
    assert T[0] / T[1] == pytest.approx(T0[0] / T0[1], rel=1e-9)
    assert pytest.approx(T0, rel=2e-3) == T, "but for where its arc is divided"
    s.unhook("r")
    assert s.row().shown[:2] == pytest.approx([0.0, 0.0])


def test_a_rope_over_sheaves_can_be_hooked_only_if_it_is_long_enough():
    s = led(L0=6.0)
    with pytest.raises(KernelError, match=r"^rope 'r' at 0\.000 s: it is 7\d\d mm too short to be hooked there"):
        s.hook("r")
    s.hook("r", b=(2.0, 0.0, -1.0))
    s.settle()
    with pytest.raises(KernelError, match=r"it is already hooked; unhook it first"):
        s.hook("r")
    s.unhook("r")
    with pytest.raises(KernelError, match=r"the length of a rope over sheaves cannot be changed"):
        s.hook("r", L0=9.0)
