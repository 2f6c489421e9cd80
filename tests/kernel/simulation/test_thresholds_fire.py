"""Thresholds: each fires once when it is crossed, and at once if it is already exceeded."""

from dataclasses import replace
from math import pi, sqrt

import pytest
from heavylift.kernel.description import Body, Drive, Joint, Line, Point, Rope, System, Threshold
from small_scenes import EA, LENGTH, MASS, SECOND, G, X, cube, hand_over, hung, slider, started

FINE = {"tolerance": 1e-11, "h_max": 0.01}
ROUNDING = 1.01  # [ns] events are rounded up to the next nanosecond


def fired(simulation):
    return [(t, e.name, e.what, e.value) for t, e in simulation.log]


def falling(*thresholds):
    """A load that falls from height 0."""
    return started(replace(slider(), thresholds=thresholds), **FINE)


@pytest.mark.parametrize(
    ("threshold", "value", "rising", "when"),
    [
        (Threshold("low", "height", point=Point("load", (0.0, 0.0, 1.0))), -1.0, False, sqrt(2 * 2.0 / G)),
        (Threshold("travel", "joint", of="load-guide"), -3.0, False, sqrt(2 * 3.0 / G)),
        (Threshold("fast", "speed", of="load-guide"), -7.0, False, 7.0 / G),
    ],
)
def test_a_falling_body_fires_the_threshold_on_its_height(threshold, value, rising, when):
    s = falling(threshold)
    s.switches.watch(threshold.name, value, rising)
    s.settle()
    s.run(3 * SECOND)
    ((t_ns, name, what, reported),) = fired(s)
    assert (name, what, reported) == (threshold.name, "reached", value)
    assert -1e-2 <= t_ns - when * 1e9 < ROUNDING


def test_a_threshold_on_the_angle_of_a_body_fires_in_the_requested_direction_only():
    """A wheel that turns about -x, w towards +y, at half a radian per second."""
    wheel = System(
        (Body("wheel", 0.0, inertia=cube(6.0)),),
        (Joint("axle", "revolute", "world", "wheel", axis=(-1.0, 0.0, 0.0), v0=(0.5,)),),
        thresholds=(Threshold("up", "angle", of="wheel"), Threshold("down", "angle", of="wheel")),
        gravity=G,
    )
    s = started(wheel, **FINE)
    s.switches.watch("up", 1.0, True)
    s.switches.watch("down", pi / 2, False)
    s.settle()
    assert s.next_ns == 0, "0 lies below 90 degrees already"
    s.run(10 * SECOND)
    (first, second) = fired(s)
    assert first[:2] == (0, "down")
    assert second[1] == "up"
    assert 0 <= second[0] - 2.0e9 < ROUNDING


def test_thresholds_on_tension_and_length_of_a_hoisting_winch_fire_exactly():
    v = 0.05
    rest = 60.0 * (1 + MASS * G / EA)
    scene = replace(
        hung(rest, winch=True, damping=1e5),
        thresholds=(
            Threshold("heavy", "tension", ropes=("rope",)),
            Threshold("short", "length", ropes=("rope",)),
        ),
    )
    s = started(scene, **FINE)
    s.references.set_profile("rope", 0, -v, 0.5, -1.0)
    s.switches.watch("heavy", 1.001 * MASS * G, True)
    s.switches.watch("short", LENGTH - 0.5, False)
    s.settle()
    s.run(30 * SECOND)
    (heavy, short) = fired(s)
    assert heavy[1:3] == ("heavy", "reached")
    assert heavy[0] < 1e8, "while the drum is still speeding up"
    at = s.method.row_layout.at["tension"]
    tension = next(row for t, row in s.rows if t == heavy[0])[at][0]
    assert 0.0 <= tension / (1.001 * MASS * G) - 1.0 < 1e-6
    assert short[1] == "short"
    assert 0 <= short[0] - (0.5 / v + 0.05) * 1e9 < ROUNDING  # half of the ramp of 0.1 s is lost


def test_a_threshold_on_a_sum_of_tensions_fires_exactly():
    """Two slings carry half of the load each; the threshold sees both."""
    lines = [Line(Point("world", (0.0, y, 0.0)), Point("load", (0.0, y, 0.0))) for y in (-1.0, 1.0)]
    ropes = tuple(Rope(f"sling{i}", (line,), EA, 10.0, 3e6) for i, line in enumerate(lines))
    both = Threshold("sum", "tension", ropes=("sling0", "sling1"))
    scene = replace(slider(q0=-9.999), ropes=ropes, thresholds=(both,))
    s = started(scene, **FINE)
    s.switches.watch("sum", 0.5 * MASS * G, True)
    s.settle()
    s.run(SECOND)
    t_ns = next(t for t, name, *_ in fired(s) if name == "sum")
    at = s.method.row_layout.at["tension"]
    T = next(row for t, row in s.rows if t == t_ns)[at]
    assert T[0] == pytest.approx(T[1])
    assert T.sum() == pytest.approx(0.5 * MASS * G, rel=1e-4)


def test_a_threshold_exceeded_when_it_is_set_fires_once_at_the_same_nanosecond():
    s = falling(Threshold("low", "joint", of="load-guide"))
    hand_over(s, SECOND)
    s.switches.watch("low", -1.0, False)
    s.settle()
    assert s.next_ns == SECOND
    assert not s.event, "nobody subscribed"
    s.run(3 * SECOND)
    assert fired(s) == [(SECOND, "low", "reached", -1.0)]


def test_a_threshold_that_is_no_longer_watched_does_not_fire_and_can_be_watched_again():
    s = falling(Threshold("low", "joint", of="load-guide"))
    s.switches.watch("low", -1.0, False)
    s.switches.unwatch("low")
    s.settle()
    hand_over(s, SECOND)
    assert fired(s) == []
    s.switches.watch("low", -20.0, False)
    s.settle()
    s.run(3 * SECOND)
    assert [x[1:] for x in fired(s)] == [("low", "reached", -20.0)]


def test_two_thresholds_crossed_in_one_nanosecond_fire_together_in_a_fixed_order():
    names = ("a", "b")
    s = started(
        replace(slider(), thresholds=tuple(Threshold(n, "joint", of="load-guide") for n in names)),
        subscribed=frozenset(names),
        **FINE,
    )
    for n in reversed(names):
        s.switches.watch(n, -1.0, False)
    s.settle()
    s.run(3 * SECOND)
    assert s.event
    assert [e.name for e in s.preview()] == ["a", "b"]
    assert s.preview() == s.fire()


def test_a_drive_that_stops_exactly_at_a_threshold_fires_the_threshold():
    """A trolley that is driven to 2 m and watched at 2 m less a rounding error."""
    scene = replace(
        slider(axis=X),
        drives=(Drive("drive", "load-guide", "prescribed"),),
        thresholds=(Threshold("there", "joint", of="load-guide"),),
    )
    s = started(scene)
    s.references.set_profile("drive", 0, 0.5, 0.1, 2.0)
    s.switches.watch("there", 2.0 - 1e-9, True)
    s.settle()
    s.run(60 * SECOND)
    ((t_ns, *_),) = fired(s)
    assert t_ns * 1e-9 == pytest.approx(2 * sqrt(2.0 / 0.1), abs=2e-4)  # the last nanometre takes 0.14 ms
