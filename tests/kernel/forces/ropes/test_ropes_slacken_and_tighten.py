"""State events of a rope: taut when it becomes straight, slack when its tension is gone, hooked only if long enough."""

from dataclasses import replace
from math import atan2, pi, sqrt

import pytest
from heavylift.kernel import KernelError
from heavylift.kernel.description import Point, Stop, Threshold
from small_scenes import EA, LENGTH, MASS, SECOND, G, events, hand_over, hung, started, times

FINE = {"tolerance": 1e-11, "h_max": 0.01}
EPS = MASS * G / EA


def test_a_falling_load_is_caught_when_its_rope_is_straight():
    s = started(hung(59.0), **FINE)
    s.run(SECOND)
    (t_ns, e), *_ = s.log
    fall = sqrt(2 * 1.0 / G)
    assert (e.name, e.what) == ("rope", "taut")
    assert 0 <= t_ns - fall * 1e9 < 1.01, "the next nanosecond after the rope is straight"
    assert e.value == pytest.approx(0.0, abs=1e-8)


def test_without_damping_a_bouncing_load_slackens_its_rope_where_it_was_caught():
    """C11: slack lasts 2 sqrt(v^2 - g d)/g; here the catch speed is also the speed of release."""
    s = started(hung(59.0), **FINE)
    s.run(5 * SECOND)
    v = sqrt(2 * G * 1.0)
    w = sqrt(EA / LENGTH / MASS)
    slack, taut = times(s, "rope", "slack"), times(s, "rope", "taut")
    assert taut[1] - slack[0] == pytest.approx(2 * v / G, abs=1e-8)
    caught = (2 * pi - 2 * atan2(v * w, G)) / w  # harmonic about the static stretch, from e = 0 back to e = 0
    assert slack[0] - taut[0] == pytest.approx(caught, abs=1e-7)


def test_with_damping_a_rope_goes_slack_while_it_is_still_stretched():
    """The tension EA strain + c e' is gone before the elongation is; at that nanosecond it is below zero, just."""
    c = 2.0e6
    s = started(hung(59.0, damping=c), **FINE)
    s.run(2 * SECOND)
    t_ns, e = next((t, e) for t, e in s.log if e.what == "slack")
    assert e.value > 1e-3, "elongation [m]"
    row = next(r for t, r in s.rows if t == t_ns)
    speed = row[s.method.row_layout.at["v"]][0]  # upwards
    trial = EA * e.value / LENGTH - c * speed
    assert -1.0 < trial <= 0.0  # [N]: a nanosecond at some 1e8 N/s
    assert min(r[s.method.row_layout.at["tension"]][0] for _, r in s.rows) == 0.0


def test_lift_off_at_constant_drum_speed_follows_the_closed_form():
    """C07a with the winch law: a load on the ground (a stop) leaves it at t = L eps / ((1 + eps) v)."""
    v, k = 0.05, 1.0e15
    ground = Stop("ground", "load-guide", -60.0 + MASS * G / k, 100.0, k, 0.6 * sqrt(k * MASS))
    weight = Threshold("weight", "tension", ropes=("rope",))
    scene = replace(hung(60.0, winch=True), stops=(ground,), thresholds=(weight,))
    s = started(scene, tolerance=1e-10)
    s.references.set_profile("rope", 0, -v, 1e6, None)
    s.switches.watch("weight", MASS * G, True)
    s.settle()
    s.run(4 * SECOND)
    want = LENGTH * EPS / ((1 + EPS) * v)
    assert times(s, "weight", "reached") == [pytest.approx(want, abs=1e-6)]
    assert times(s, "ground", "open")[0] == pytest.approx(want, abs=1e-5)  # its damper lets go a moment before


def test_a_sling_can_be_hooked_only_if_it_is_long_enough():
    s = started(hung(60.25, hooked=False), **FINE)
    before = s.P.copy()
    with pytest.raises(KernelError) as e:
        s.hook("rope")
    assert str(e.value) == "rope 'rope' at 0.000 s: it is 250 mm too short to be hooked there; bring the hook closer"
    with pytest.raises(KernelError, match="750 mm too short"):
        s.hook("rope", a=(0.0, 0.0, 0.5))
    with pytest.raises(KernelError, match=r"rope 'rope' at 0\.000 s: length -1 m; it must be positive"):
        s.hook("rope", L0=-1.0)
    with pytest.raises(KernelError, match="length nan m"):
        s.hook("rope", L0=float("nan"))
    assert s.P.tobytes() == before.tobytes(), "a refused hooking changes nothing"
    s.hook("rope", L0=60.25 + 1e-9)
    s.settle()
    s.run(SECOND)
    assert events(s)[:1] == [("rope", "taut")]
    s.interrupt(SECOND)
    with pytest.raises(KernelError, match=r"rope 'rope' at 1\.000 s: it is already hooked; unhook it first"):
        s.hook("rope")


def test_a_sling_hooked_at_another_point_becomes_taut_there():
    scene = hung(60.0, hooked=False)
    rope = scene.ropes[0]
    line = replace(rope.lines[0], a=Point("world", (0.0, 0.0, 5.0)))
    s = started(replace(scene, ropes=(replace(rope, lines=(line,)),)), **FINE)
    with pytest.raises(KernelError, match="5000 mm too short"):
        s.hook("rope")
    s.hook("rope", a=(0.0, 0.0, -0.5))
    s.settle()
    s.run(SECOND)
    assert times(s, "rope", "taut")[0] == pytest.approx(sqrt(2 * 0.5 / G), abs=2e-9)


def test_an_unhooked_rope_has_neither_tension_nor_events():
    s = started(hung(60.0 * (1 + EPS)), **FINE)
    hand_over(s, SECOND)
    s.unhook("rope")
    s.settle()
    s.run(2 * SECOND)
    assert events(s) == []
    hand_over(s, 2 * SECOND)
    assert s.state[1] == pytest.approx(-G * 1.0, rel=1e-9)
    s.unhook("rope")  # twice is no error
    with pytest.raises(KernelError, match=r"'towline': there is no rope with this name; there are rope"):
        s.unhook("towline")
