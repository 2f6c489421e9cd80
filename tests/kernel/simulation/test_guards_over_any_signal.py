"""Thresholds on off-lead, swing, radius, gap, load, moment and wind fire at closed-form times."""

from dataclasses import replace
from math import atan2, cos, hypot, pi, sin, sqrt

import numpy as np
import pytest
from heavylift.kernel import KernelError
from heavylift.kernel.description import (
    Body,
    Drive,
    InputSignal as Driven,
    Joint,
    Line,
    Point,
    Rope,
    ScalarSignal,
    System,
    Wind,
    guard_of,
)
from heavylift.kernel.model import scalar
from heavylift.kernel.simulation.native import reader
from scipy.optimize import lsq_linear
from scipy.spatial.transform import Rotation
from small_scenes import EA, SECOND, G, X, Z, cube, hung, started

FINE = {"tolerance": 1e-10, "h_max": 0.01}
ROUNDING = 1.5  # [ns]


def fired(system, signal, value, rising=True, until=20 * SECOND, **commands):
    """When a guard over a signal fires [s]; commands: speed and ramp of actuators."""
    s = started(replace(system, thresholds=(guard_of("it", signal),)), **FINE)
    for name, (speed, accel) in commands.items():
        s.set_profile(name, 0, speed, accel, None)
    s.switches.watch("it", value, rising)
    s.settle()
    s.run(until)
    (t,) = [t for t, e in s.log if e.name == "it"]
    return t * 1e-9


def cart(speed: float, y: float = 0.0) -> System:
    """A cart of 2 x 2 x 2 m that runs along x, past the world's origin at distance y."""
    joint = Joint("rail", "prismatic", "world", "cart", axis=X, p_PJ=(-10.0, y, 1.0), v0=(speed,))
    return System((Body("cart", 1000.0, inertia=cube(1000.0)),), (joint,), gravity=G)


def jib(load: float) -> System:
    """A load of this mass on a rope of 10 m below a trolley that runs out from the origin; its drive is prescribed."""
    bodies = Body("trolley", 100.0), Body("load", load, inertia=cube(load))
    joints = (
        Joint("beam", "prismatic", "world", "trolley", axis=X, p_PJ=(5.0, 0.0, 20.0)),
        Joint("guide", "prismatic", "trolley", "load", axis=Z, q0=(-10.0,)),
    )
    rope = Rope("fall", (Line(Point("trolley"), Point("load")),), EA, 10.0 / (1.0 + load * G / EA))
    drive = Drive("out", "beam", "prescribed")
    return System(bodies, joints, ropes=(rope,), drives=(drive,), gravity=G)


def test_radius_and_gap_signals_of_a_passing_cart_have_their_exact_values():
    radius = ScalarSignal("radius", point=Point("cart"), origin=Point("world"))
    assert fired(cart(2.0, 3.0), radius, 5.0, rising=False) == pytest.approx(3.0, abs=ROUNDING * 1e-9)
    gap = ScalarSignal(
        "gap", point=Point("cart"), origin=Point("world", (0.0, 0.0, 1.0)), numbers=(1.0, 1.0, 1.0, 2.0, 1.0, 1.0)
    )
    assert fired(cart(2.0), gap, 0.5, rising=False) == pytest.approx(3.25, abs=ROUNDING * 1e-9)


def test_the_gap_signal_of_turned_boxes_never_exceeds_their_distance():
    """A stick of 4 x 2 m turns beside a wall at x = 4: their gap falls as its corner comes near."""
    spin = Joint("axle", "revolute", "world", "stick", axis=Z, q0=(pi / 2,), v0=(-0.5,))
    stick = System((Body("stick", 10.0, inertia=cube(10.0)),), (spin,), gravity=0.0)
    wall = Point("world", (5.0, 0.0, 0.0))
    gap = ScalarSignal("gap", point=Point("stick"), origin=wall, numbers=(2.0, 1.0, 1.0, 1.0, 9.0, 1.0))
    when = fired(stick, gap, 2.0, rising=False)
    angle = pi / 2 - 0.5 * when
    assert 2.0 * cos(angle) + 1.0 * sin(angle) == pytest.approx(2.0, abs=1e-8)


@pytest.mark.parametrize("shape", ["any", "booms"])
def test_the_gap_signal_agrees_with_distances_computed_by_independent_code(shape):
    """Least squares within bounds (SciPy) find the nearest points of two boxes as they stand at random."""
    rng = np.random.default_rng(1)
    for _ in range(60):
        halves = [np.array([20.0, 0.75, 0.75]) if shape == "booms" else rng.uniform(0.2, 3.0, 3) for _ in (0, 1)]
        turned = [Rotation.from_quat(rng.normal(size=4)).as_matrix() for _ in (0, 1)]
        middles = [np.zeros(3), rng.normal(size=3) * (30.0 if shape == "booms" else 6.0)]
        places = [p for c, R in zip(middles, turned, strict=True) for p in ([*c], *(c + R[:, i] for i in range(3)))]
        signal = ScalarSignal("gap", point=Point("a"), origin=Point("b"))
        gap = scalar(signal, places, [*halves[0], *halves[1]], [])
        both = np.concatenate(halves)
        nearest = lsq_linear(np.hstack([turned[0], -turned[1]]), middles[1] - middles[0], bounds=(-both, both))
        distance = sqrt(2.0 * nearest.cost)
        if distance > 1e-6:
            assert gap <= distance + 1e-9
            assert gap == pytest.approx(distance, rel=0.25 if shape == "booms" else 0.02)
        else:
            assert gap < 1e-6


def test_off_lead_and_swing_signals_of_a_pendulum_have_their_exact_values():
    """A pendulum that is let go at 0.1 rad in a plane at 30 degrees to x: its rope is as far off as its angle."""
    e = (cos(pi / 6), sin(pi / 6), 0.0)
    pivot = Joint("pivot", "revolute", "world", "bob", axis=(-e[1] * -1.0, -e[0], 0.0), q0=(0.1,))
    rope = Rope("rod", (Line(Point("world"), Point("bob", (0.0, 0.0, -9.0))),), 1.0, 99.0)
    scene = System((Body("bob", 1.0, com=(0.0, 0.0, -9.0)),), (pivot,), ropes=(rope,), gravity=G)
    through = [fired(scene, ScalarSignal(kind, ropes=("rod",)), v, rising=False) for kind, v in (("off-lead", 1e-3),)]
    quarter = pi / 2 * sqrt(9.0 / G) * (1.0 + 0.1**2 / 16.0)
    assert through[0] == pytest.approx(quarter, abs=0.011)
    s = started(scene, **FINE)
    row = s.native.raw().tolist()
    along, across = (
        reader(s.program, ScalarSignal(kind, ropes=("rod",)))(row) for kind in ("swing along", "swing across")
    )
    out = 9.0 * sin(0.1)
    assert hypot(along, across) > 0.09
    assert (abs(along), abs(across)) == pytest.approx(
        (atan2(out * e[0], 9.0 * cos(0.1)), atan2(out * e[1], 9.0 * cos(0.1))), rel=1e-12
    )
    assert reader(s.program, ScalarSignal("off-lead", ropes=("rod",)))(row) == pytest.approx(0.1, rel=1e-12)


def test_the_hook_load_signal_is_the_rope_tension_minus_the_weight_of_the_hook_block():
    scene = hung(60.0, L0=60.0)
    s = started(scene, **FINE)
    read = reader(s.program, ScalarSignal("load", ropes=("rope",), numbers=(1.0 / G, 25e3)))
    tension = reader(s.program, ScalarSignal("tension", ropes=("rope",)))
    s.run(SECOND)
    row = s.native.raw().tolist()
    assert read(row) == pytest.approx(tension(row) / G - 25e3, rel=1e-14)


CHART = (1.1 * 500.0 * G, 10.0, 20e3 * G, 15.0, 12e3 * G, 20.0, 8e3 * G)  # 20 t to 10 m, 12 t to 15 m, 8 t to 20 m


@pytest.mark.parametrize(("load", "reached"), [(15e3, 10.0), (10e3, 15.0), (7e3, 20.0), (400.0, None)])
def test_a_load_chart_uses_the_next_larger_radius_without_interpolation(load, reached):
    """A trolley runs out at 1 m/s from 5 m: beyond the radius that its load may have it is at more than 100 %, and with
    no more than its hook block anywhere."""
    moment = ScalarSignal("moment", ropes=("fall",), point=Point("load"), origin=Point("world"), numbers=CHART)
    if reached is None:
        with pytest.raises(ValueError, match="not enough"):
            fired(jib(load), moment, 1.0, out=(1.0, 1e3))
        return
    when = fired(jib(load), moment, 1.0, out=(1.0, 1e3))
    assert when == pytest.approx(reached - 5.0 + 0.5e-3, abs=1e-8)


@pytest.mark.parametrize("seed", range(5))
def test_a_utilisation_limit_that_varies_with_position_is_interpolated_as_by_numpy(seed):
    """Before the first place and beyond the last one that of the nearest counts."""
    rng = np.random.default_rng(seed)
    places, allowed = np.cumsum(rng.uniform(1.0, 9.0, seed + 1)), rng.uniform(1e4, 5e4, seed + 1)
    chart = [x for pair in zip(places, allowed, strict=True) for x in pair]
    signal = ScalarSignal("use by place", ropes=("a", "b"), point=Point("load"), numbers=(1.0 / G, 300.0, *chart))
    for y in (*rng.uniform(-5.0, places[-1] + 5.0, 20), *places):
        pulls = rng.uniform(1e4, 9e4, 2)
        use = scalar(signal, [[7.0, y, 3.0]], signal.numbers, pulls)
        assert use == pytest.approx((pulls.sum() / G - 300.0) / np.interp(y, places, allowed), rel=1e-12)


def test_the_utilisation_of_several_ropes_is_their_largest_utilisation():
    rated = np.array([3e5, 1e5, 2e5])
    signal = ScalarSignal("use", ropes=("a", "b", "c"), numbers=tuple(1.0 / rated))
    for pulls in np.random.default_rng(1).uniform(0.0, 3e5, (20, 3)):
        assert scalar(signal, [], signal.numbers, pulls) == pytest.approx((pulls / rated).max(), rel=1e-14)


def test_a_load_chart_threshold_fires_where_the_capacity_falls_below_the_load():
    """5 t that go along y at 1 m/s, where the chart falls by a tonne a metre from 9 t at 2 m: at 6 m it is used."""
    scene = jib(5e3)
    joints = tuple(
        replace(j, axis=(0.0, 1.0, 0.0), p_PJ=(0.0, 0.0, 20.0)) if j.name == "beam" else j for j in scene.joints
    )
    signal = ScalarSignal(
        "use by place", ropes=("fall",), point=Point("trolley"), numbers=(1.0 / G, 0.0, 2.0, 9e3, 10.0, 1e3)
    )
    when = fired(replace(scene, joints=joints), signal, 1.0, out=(1.0, 1e3))
    assert when == pytest.approx(6.0 + 0.5e-3, abs=1e-6)


def test_a_condition_on_wind_speed_fires_during_a_gust():
    wind = Wind("gust", Point("cart"), 1.0, 1.0, (0.0, 1.0, 0.0), Driven(0.0, (0.0, 10.0), (5.0, 25.0)))
    scene = replace(cart(0.0), forces=(wind,))
    assert fired(scene, ScalarSignal("wind", of="gust", point=Point("cart")), 12.0) == pytest.approx(
        3.5, abs=ROUNDING * 1e-9
    )


def test_the_sampled_value_of_a_signal_is_the_value_at_which_its_threshold_fires():
    """Of random signals the sample is the value at which a guard of that value has just fallen, and not before."""
    rng = np.random.default_rng(3)
    for _ in range(5):
        p, o, half = rng.normal(size=3), rng.normal(size=3), rng.uniform(0.1, 1.0, 6)
        kinds = [
            ScalarSignal("radius", point=Point("cart", tuple(p)), origin=Point("world", tuple(o))),
            ScalarSignal("height difference", point=Point("cart", tuple(p)), origin=Point("world", tuple(o))),
            ScalarSignal("gap", point=Point("cart", tuple(p)), origin=Point("world", tuple(o)), numbers=tuple(half)),
        ]
        for x in kinds:
            s = started(replace(cart(1.0), thresholds=(guard_of("it", x),)), **FINE)
            value = reader(s.program, x)(s.native.raw().tolist())
            s.switches.watch("it", value - 1e-9, True)
            s.settle()
            assert s.next_ns == 0


@pytest.mark.parametrize(
    ("signal", "message"),
    [
        (ScalarSignal("radius", point=Point("cart")), "a radius needs an origin"),
        (ScalarSignal("off-lead", ropes=("nylon",)), "there is no rope 'nylon'"),
        (ScalarSignal("off-lead"), "an off-lead needs a rope"),
        (ScalarSignal("gap", point=Point("cart"), origin=Point("world")), "a gap needs 6 values in `numbers`, not 0"),
        (ScalarSignal("wind", of="breeze"), "there is no wind or other force 'breeze'"),
        (
            ScalarSignal("moment", ropes=("fall",), point=Point("load"), origin=Point("world")),
            "the empty hook, then a chart",
        ),
        (ScalarSignal("use", ropes=("fall",)), "a utilisation needs a limit for each of 1 ropes, not 0"),
        (
            ScalarSignal("use by place", ropes=("fall",), point=Point("load"), numbers=(1.0, 0.0, 2.0, 0.0)),
            "offset of the load, then pairs",
        ),
    ],
)
def test_invalid_threshold_signals_are_reported(signal, message):
    scene = jib(1e3) if "fall" in signal.ropes else cart(1.0)
    with pytest.raises(KernelError, match=message):
        started(replace(scene, thresholds=(guard_of("it", signal),)))
