"""A rope leaves its sheave where the wrap angle becomes zero, runs straight, and meets the sheave again."""

from dataclasses import replace
from math import acos, atan2, dist, exp, hypot, pi, sqrt

import mujoco
import numpy as np
import pytest
from heavylift.kernel import KernelError
from heavylift.kernel.analysis import equilibrium
from heavylift.kernel.description import Body, Drive, InputSignal, Joint, Load, Point, Reeving, Sheave, System
from scipy.optimize import brentq
from scipy.spatial import ConvexHull
from small_scenes import SECOND, G, X, Y, Z, column, cube, events, hand_over, imbalance, started, times

ROUNDING = 5e-9  # [s] events are rounded up to the next nanosecond, 1e-9 rad behind the wrap of zero
EXACT = 1e-9  # relative: lengths are closed forms of the place
POLYGON = 1e-7  # relative: circles of so many corners
CLOSES = 1e-8  # of the energy turned over
FINE = {"tolerance": 1e-10, "sample_ns": SECOND // 50}
EA, CORNERS = 1e6, 20000
WORLD = Point("world")


def rope(sheaves, end, L0, **more) -> Reeving:
    return Reeving("r", Point("end"), sheaves, Point("world", (end[0], 0.0, end[1])), EA, InputSignal(L0), **more)


def driven(made: Reeving, start) -> System:
    """The rope's first end on two slides, which drives move along x and z."""
    slides = (
        Joint("slide", "prismatic", "world", "cart", axis=X, q0=(start[0],)),
        Joint("lift", "prismatic", "cart", "end", axis=Z, q0=(start[1],)),
    )
    drives = (Drive("x", "slide", "prescribed"), Drive("z", "lift", "prescribed"))
    return System((Body("cart", 1.0), Body("end", 50.0)), slides, forces=(made,), drives=drives, gravity=G)


def led(scene: System, moves, **options):
    """Started and led through moves (drive, speed, way), one after the other."""
    s, now = started(scene, **FINE, **options), 0.0
    for drive, speed, distance in moves:
        s.set_profile(drive, round(now * SECOND), speed, 1e6, distance)
        s.settle()
        now += abs(distance / speed) + 1e-3
        hand_over(s, round(now * SECOND))
    s.settle()
    return s


def wrap(a, b, r: float) -> float:
    """[rad] of a rope from a to b over a sheave of radius r at the origin; below zero where it lies above that."""
    return atan2(-a[0], a[1]) + atan2(b[0], b[1]) - acos(r / hypot(*a)) - acos(r / hypot(*b))


def length(a, b, r: float) -> float:
    turned = wrap(a, b, r)
    return sum(sqrt(hypot(*p) ** 2 - r * r) for p in (a, b)) + r * turned if turned > 0.0 else dist(a, b)


def shown(s):
    """Times, places of the end, lengths and tensions of the parts, wraps."""
    t, q = column(s, "joint/position")
    return t, q, *(column(s, f"reeving/{x}")[1] for x in ("length", "tension", "wrap"))


@pytest.mark.parametrize("seed", range(6))
def test_the_length_of_a_rope_over_a_sheave_is_that_of_its_tangents_and_arc_or_its_straight_line(seed):
    """Up until it is straight, and back down; both events are where the closed form says."""
    random = np.random.default_rng(seed)
    r, a, b = random.uniform(0.2, 0.8), (-random.uniform(3.0, 6.0), 0.0), (random.uniform(3.0, 6.0), -2.0)
    L0 = 0.9 * length(a, b, r)
    leaves = brentq(lambda z: wrap((a[0], z), b, r), 0.0, 20.0)
    distance = leaves + 1.5
    s = led(driven(rope((Sheave(WORLD, Y, r),), b, L0), a), [("z", 1.0, distance), ("z", -1.0, -distance)])
    t, q, lengths, T, turned = shown(s)
    for i, (x, z) in enumerate(q):
        whole = length((x, z), b, r)
        assert lengths[i].sum() == pytest.approx(whole, rel=EXACT)
        assert T[i] == pytest.approx(np.full(2, EA * (whole / L0 - 1.0)), rel=1e-7)
        assert turned[i, 0] == pytest.approx(max(0.0, wrap((x, z), b, r)), abs=1e-8)
    steps = np.abs(np.diff(lengths, axis=0)).max() / np.diff(t).max()
    assert steps < 1.5, "no part jumps where it leaves the sheave: it changes no faster than the end moves"
    assert times(s, "r", "left") == pytest.approx([leaves], abs=2e-6)  # the drive's ramp of a microsecond
    assert times(s, "r", "found") == pytest.approx([distance + 1e-3 + 1.5], abs=4e-6)
    assert events(s) == [("r", "taut"), ("r", "left"), ("r", "found")][-len(events(s)) :]


@pytest.mark.parametrize("seed", range(6))
@pytest.mark.large(beyond=3)
def test_the_path_of_a_rope_over_several_sheaves_is_the_upper_hull(seed):
    """Circles of one rope that turns one way: taut, it is the convex hull of circles and ends above them."""
    random = np.random.default_rng(seed)
    xs, end = (0.0, 2.5, 5.0, 7.5), (11.0, -4.0)
    circles = [
        ((x, random.uniform(0.5, 1.0) if n in (1, 2) else 0.0), random.uniform(0.2, 0.9)) for n, x in enumerate(xs)
    ]
    sheaves = tuple(Sheave(Point("world", (x, 0.0, z)), Y, r) for (x, z), r in circles)
    turns = np.linspace(0.0, 2.0 * pi, CORNERS, endpoint=False)
    rims = [np.stack([x + r * np.cos(turns), z + r * np.sin(turns)], axis=1) for (x, z), r in circles]

    def hull(place) -> float:
        points = np.concatenate([*rims, [place, end]])
        ring = [int(i) for i in ConvexHull(points).vertices]  # counterclockwise
        first, last = ring.index(len(points) - 1), ring.index(len(points) - 2)
        distance = (ring[first:] + ring)[: (last - first) % len(ring) + 1]
        return float(np.linalg.norm(np.diff(points[distance], axis=0), axis=1).sum())

    a = (-4.0, -4.0)
    s = led(driven(rope(sheaves, end, 14.0), a), [("z", 4.0, 16.0), ("x", 4.0, 6.0), ("z", -4.0, -9.0)])
    _, q, lengths, T, _ = shown(s)
    for i in range(0, len(q), 7):
        assert lengths[i].sum() == pytest.approx(hull(tuple(q[i])), rel=POLYGON)
        assert T[i] == pytest.approx(np.full(5, T[i, 0]), rel=EXACT)
    assert len(times(s, "r", "left")) >= 3
    assert len(times(s, "r", "found")) >= 1


def test_a_rope_leaves_and_meets_its_sheave_as_mujocos_tendon_does():
    """Two sheaves with an eye between them; the end goes up, across and down again."""
    one, eye, two, r1, r2, b = (0.0, 0.0), (3.0, -0.5), (6.0, 0.3), 0.6, 0.4, (9.0, -2.0)

    def at(p):
        return f"{p[0]} 0 {p[1]}"

    def wheel(name, p, r):
        shape = f'type="cylinder" size="{r} 0.2" euler="{pi / 2} 0 0" mass="0"'
        return f'<geom name="{name}" {shape} pos="{at(p)}"/><site name="over-{name}" pos="{at((p[0], p[1] + 2 * r))}"/>'

    model = mujoco.MjModel.from_xml_string(
        '<mujoco><compiler angle="radian"/><worldbody>'
        f"{wheel('one', one, r1)}{wheel('two', two, r2)}"
        f'<site name="eye" pos="{at(eye)}"/><site name="b" pos="{at(b)}"/>'
        '<body><joint type="slide" axis="1 0 0"/><joint type="slide" axis="0 0 1"/>'
        '<inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/><site name="a"/></body></worldbody>'
        '<tendon><spatial><site site="a"/><geom geom="one" sidesite="over-one"/><site site="eye"/>'
        '<geom geom="two" sidesite="over-two"/><site site="b"/></spatial></tendon></mujoco>'
    )
    data = mujoco.MjData(model)
    sheaves = (
        Sheave(Point("world", (one[0], 0.0, one[1])), Y, r1),
        Sheave(Point("world", (eye[0], 0.0, eye[1]))),
        Sheave(Point("world", (two[0], 0.0, two[1])), Y, r2),
    )
    s = led(driven(rope(sheaves, b, 11.0), (-4.0, -1.0)), [("z", 3.0, 9.0), ("x", 3.0, 2.5), ("z", -3.0, -9.0)])
    _, q, lengths, _, _ = shown(s)
    for place, ours in zip(q, lengths.sum(axis=1), strict=True):
        data.qpos[:] = place
        mujoco.mj_forward(model, data)
        assert ours == pytest.approx(data.ten_length[0], rel=EXACT)
    assert {what for _, what in events(s)} >= {"left", "found"}


@pytest.mark.parametrize(("mu", "efficiency"), [(0.15, 1.0), (0.0, 0.95), (0.1, 0.97)])
def test_sheave_friction_acts_only_while_the_rope_touches_it(mu, efficiency):
    r, a, b = 0.5, (-5.0, 0.0), (5.0, -3.0)
    leaves = brentq(lambda z: wrap((a[0], z), b, r), 0.0, 20.0)
    made = rope((Sheave(WORLD, Y, r, mu, efficiency),), b, 9.0)
    s = led(driven(made, a), [("z", 0.5, leaves + 1.0), ("z", -0.5, -leaves - 1.0)])
    t, q, _, T, turned = shown(s)
    off = turned[:, 0] == 0.0
    assert 10 < off.sum() < len(off) - 10
    assert T[off, 0] == pytest.approx(T[off, 1], rel=EXACT)
    most = np.array([exp(mu * x) / efficiency for x in turned[:, 0]])
    ratio = T[:, 0] / T[:, 1]
    assert (ratio[~off] <= most[~off] * (1.0 + 1e-6)).all()
    assert (ratio[~off] >= 1.0 / most[~off] * (1.0 - 1e-6)).all()
    sliding = (t > times(s, "r", "slip")[0]) & (t < times(s, "r", "left")[0])
    assert sliding.sum() > 10
    assert ratio[sliding] == pytest.approx(most[sliding], rel=1e-6), "it slides towards the end that rises"
    assert imbalance(s) < CLOSES
    assert q[-1] == pytest.approx(a, abs=1e-9)


def test_a_load_that_swings_off_and_onto_its_sheave_conserves_the_energy_balance():
    """A load on a slide is thrown up, tears the rope off its sheave and falls back, again and again."""
    made = rope((Sheave(WORLD, Y, 0.5),), (4.0, -1.0), 8.3)
    slide = Joint("slide", "prismatic", "world", "end", (-4.0, 0.0, 0.0), axis=Z, q0=(-1.0,), v0=(22.0,))
    scene = System((Body("end", 500.0),), (slide,), forces=(made,), gravity=G)
    s = started(scene, **FINE)
    s.run(2 * SECOND)
    again = started(scene, **FINE)
    again.restore(s.snapshot())
    for run in (s, again):
        hand_over(run, 6 * SECOND)
        run.settle()
    assert len(times(s, "r", "left")) >= 3
    assert len(times(s, "r", "found")) >= 3
    assert imbalance(s) < CLOSES
    assert np.array_equal(s.state, again.state)


def test_machine_code_and_interpreted_python_agree_on_ropes_leaving_sheaves():
    made = rope((Sheave(WORLD, Y, 0.5, 0.1),), (4.0, -1.0), 8.3)
    scene = driven(made, (-4.0, 1.8))
    native, oracle = (led(scene, [("z", 2.0, 0.6)], native=n, h_max=0.05) for n in (True, False))
    assert events(native) == events(oracle)
    assert ("r", "left") in events(native)
    assert native.row().shown == pytest.approx(oracle.row().shown, rel=1e-11)


@pytest.mark.parametrize("push", [1e4, 3e5])
def test_statics_finds_equilibria_with_a_rope_on_its_sheave_and_off_its_sheave(push):
    """A load pushes the end of the rope up its slide until rope and load are in balance."""
    r, x, b, L0 = 0.5, -4.0, (4.0, -1.0), 8.3
    made = rope((Sheave(WORLD, Y, r),), b, L0)
    slide = Joint("slide", "prismatic", "world", "end", (x, 0.0, 0.0), axis=Z)
    up = Load("up", Point("end"), (0.0, 0.0, push))
    s = started(System((Body("end", 1.0),), (slide,), forces=(made, up), gravity=G))
    rest = equilibrium(s)

    def rises(z: float) -> float:
        """Derivative of the energy."""
        h = 1e-6
        slope = (length((x, z + h), b, r) - length((x, z - h), b, r)) / (2.0 * h)
        return EA * (length((x, z), b, r) / L0 - 1.0) * slope - push + G

    z = brentq(rises, 0.0, 20.0)
    assert rest.q[0] == pytest.approx(z, abs=1e-6)
    assert (wrap((x, z), b, r) > 0.0) == (push < 1e5), "one case of each"
    assert s.row().shown[6] == pytest.approx(max(0.0, wrap((x, z), b, r)), abs=1e-6)


def test_a_rope_that_would_wrap_the_other_side_of_its_sheave_ends_the_run():
    """The end goes up, around its other end and back below the sheave."""
    scene = driven(rope((Sheave(WORLD, Y, 0.5),), (5.0, -3.0), 9.0), (-5.0, 0.0))
    moves = [("z", 4.0, 10.0), ("x", 4.0, 14.0), ("z", -4.0, -20.0), ("x", -4.0, -12.0), ("z", 4.0, 13.0)]
    with pytest.raises(KernelError, match=r"^reeving 'r' at \d+\.\d+ s: meets sheave 1 from its other side"):
        led(scene, moves)


@pytest.mark.parametrize("speed", [0.7, -2.0])
def test_a_sheave_that_turns_without_friction_under_its_rope_winds_up_no_rope(speed):
    """The body of the sheave turns about its axle by turns; without friction that is nothing to the rope."""
    r, a, b = 0.5, (-4.0, 0.0), (4.0, -1.0)
    made = rope((Sheave(Point("drum"), Y, r),), b, 8.0)
    scene = driven(made, a)
    inertia = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
    axle = Joint("axle", "revolute", "world", "drum", axis=Y, v0=(2.0 * pi * speed,))
    scene = replace(scene, bodies=(*scene.bodies, Body("drum", 1.0, inertia=inertia)), joints=(*scene.joints, axle))
    s = led(scene, [("z", 0.25, 0.5)])
    _, q, lengths, _, _ = shown(s)
    assert lengths.sum(axis=1) == pytest.approx([length(p[:2], b, r) for p in q], rel=EXACT)
    assert q[-1, 2] == pytest.approx(2.0 * pi * speed * 2.001, abs=1e-6)


@pytest.mark.parametrize(("seed", "ends"), [(0, ""), (3, ""), (4, ""), (5, "part 2 comes within its sheave")])
def test_frictionless_ropes_over_several_sheaves_lose_no_energy_while_their_loads_are_thrown(seed, ends):
    """Free loads, friction, slack and shocks, sheaves left and found; or a sentence, where an end meets a sheave."""
    random = np.random.default_rng(seed)
    n = int(random.integers(1, 4))
    xs, sheaves = np.cumsum(random.uniform(1.5, 3.0, n)), list[Sheave]()
    for x in xs:
        at = Point("world", (float(x), 0.0, float(random.uniform(-0.5, 0.5))))
        r, mu, efficiency = random.uniform(0.2, 0.6), random.choice([0.0, 0.1]), random.choice([1.0, 0.96])
        sheaves.append(Sheave(at, Y, float(r), float(mu), float(efficiency)))
    v0 = (float(random.normal() * 2.0), 0.0, float(random.uniform(0.0, 14.0)), 0.0, 0.0, 0.0)
    float_ = Joint("float", "free", "world", "end", q0=(-3.0, 0.0, -2.0, 0.0, 0.0, 0.0, 1.0), v0=v0)
    damping = float(random.choice([0.0, 50.0]))
    end = Point("world", (float(xs[-1]) + 3.0, 0.0, -2.0))
    made = Reeving("r", Point("end"), tuple(sheaves), end, 2e5, InputSignal(float(xs[-1]) + 7.5), damping)
    load = Body("end", 100.0, inertia=cube(100.0, 0.5))
    s = started(System((load,), (float_,), forces=(made,), gravity=G), **FINE | {"tolerance": 1e-9})
    if ends:
        with pytest.raises(KernelError, match=rf"^reeving 'r' at \d\.\d+ s: {ends}"):
            hand_over(s, 4 * SECOND)
    else:
        hand_over(s, 4 * SECOND)
        s.settle()
        assert imbalance(s) < CLOSES
    assert {"left", "found", "slack"} <= {what for _, what in events(s)} | ({"slack"} if ends else set())
