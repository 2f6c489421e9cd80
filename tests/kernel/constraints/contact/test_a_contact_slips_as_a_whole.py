"""A body with several contact points slips when no forces within all friction cones hold it: closed forms."""

from __future__ import annotations

from math import atan, sqrt

import numpy as np
import pytest
from heavylift.kernel.description import WORLD, Ball, Body, Box, Contact, InputSignal, Joint, Load, Plane, Point, System
from heavylift.kernel.simulation import Simulation
from scipy.optimize import linprog
from small_scenes import SECOND, G, events, hand_over, started, times

INSTANT = 1e-7  # [s] by which a slip may be late: forces that grow for some nanoseconds beyond the limit, and 1e-9 m g
SIDES = 360  # of the polygons that stand for circles of friction: 4e-5 too large
RAMP = 1.5  # times the limit is reached after a second


def block(name: str, mass: float, size: tuple[float, float, float]) -> Body:
    x, y, z = (e * e * mass / 12.0 for e in size)
    return Body(name, mass, inertia=((y + z, 0.0, 0.0), (0.0, x + z, 0.0), (0.0, 0.0, x + y)))


def free(name: str, z: float) -> Joint:
    return Joint(f"{name}-free", "free", WORLD, name, q0=(0.0, 0.0, z, 0.0, 0.0, 0.0, 1.0))


def growing(most: float) -> InputSignal:
    return InputSignal(times=(0.0, 1.0), values=(0.0, most))


def pushed(mass: float, size, mu: float, height: float, most: float, direction: float = 0.0) -> Simulation:
    """A box on the ground, pushed at a height over its centre with a force that grows to `most` in a second."""
    towards = (np.cos(direction), np.sin(direction), 0.0)
    load = Load("push", Point("box", (0.0, 0.0, height)), towards, signal=growing(most))
    ground = Contact("ground", Box("box", size), Plane(), mu)
    scene = System(
        (block("box", mass, size),), (free("box", 0.5 * size[2]),), forces=(load,), contacts=(ground,), gravity=G
    )
    return started(scene)


@pytest.mark.parametrize("seed", range(8))
def test_a_box_that_is_pushed_slips_at_mu_m_g(seed: int) -> None:
    random = np.random.default_rng(seed)
    size, mu = tuple(random.uniform((0.5, 0.5, 0.2), (3.0, 3.0, 0.5))), random.uniform(0.05, 0.3)
    mass, height = 10.0 ** random.uniform(-1, 6), random.uniform(-0.5, 0.5) * size[2]
    s = pushed(mass, size, mu, height, RAMP * mu * mass * G)
    hand_over(s, 9 * SECOND // 10)
    assert times(s, "ground", "slip") == [pytest.approx(1.0 / RAMP, abs=INSTANT)]
    assert events(s) == [("ground", "slip")]


@pytest.mark.parametrize("part", [0.5, 0.97, 0.9999])
def test_a_push_below_the_friction_limit_causes_no_slip_event(part: float) -> None:
    s = pushed(5.0, (2.0, 2.0, 0.5), 0.3, 0.1, part * 0.3 * 5.0 * G)
    hand_over(s, 2 * SECOND)
    assert events(s) == []
    assert abs(s.state[0]) < 1e-12


def test_a_square_box_starts_to_turn_when_the_torque_exceeds_its_friction_torque() -> None:
    """M = mu m g r, with the corners at r from the axis."""
    mass, a, mu = 800.0, 1.5, 0.25
    limit = mu * mass * G * a / sqrt(2.0)
    turn = Load("turn", Point("box"), moment=(0.0, 0.0, 1.0), signal=growing(RAMP * limit))
    ground = Contact("ground", Box("box", (a, a, 0.6)), Plane(), mu)
    bodies, joints = (block("box", mass, (a, a, 0.6)),), (free("box", 0.3),)
    s = started(System(bodies, joints, forces=(turn,), contacts=(ground,), gravity=G))
    hand_over(s, 9 * SECOND // 10)
    assert times(s, "ground", "slip") == [pytest.approx(1.0 / RAMP, abs=INSTANT)]


@pytest.mark.parametrize(("upper", "lower", "slipping"), [(0.6, 0.2, "ground"), (0.5, 0.2, "seam"), (0.2, 0.5, "seam")])
@pytest.mark.large
def test_in_a_stack_only_the_weaker_contact_slips(upper: float, lower: float, slipping: str) -> None:
    """The upper box is pushed at its foot: the seam holds upper m g, the ground lower (M + m) g."""
    m, M, low, high = 3.0, 5.0, (2.0, 2.0, 0.5), (1.0, 1.0, 0.4)
    limit = min(upper * m, lower * (M + m)) * G
    load = Load("push", Point("top", (0.0, 0.0, -0.2)), (1.0, 0.0, 0.0), signal=growing(RAMP * limit))
    seam = Contact("seam", Box("top", high), Box("base", low), upper)
    ground = Contact("ground", Box("base", low), Plane(), lower)
    bodies, joints = (block("base", M, low), block("top", m, high)), (free("base", 0.25), free("top", 0.7))
    s = started(System(bodies, joints, forces=(load,), contacts=(ground, seam), gravity=G))
    hand_over(s, 7 * SECOND // 10)
    assert times(s, slipping, "slip") == [pytest.approx(1.0 / RAMP, abs=INSTANT)]
    assert ("ground" if slipping == "seam" else "seam", "slip") not in events(s)


@pytest.mark.parametrize("mu", [0.1, 0.4])
def test_a_box_on_a_steepening_slope_slips_at_the_friction_angle(mu: float) -> None:
    """Seen from the slope, gravity turns: g cos, g sin with an angle that grows; m g = 1 N stands for it."""
    rate = 2.0 * atan(mu)
    at = np.linspace(0.0, 1.0, 101)
    down = Load(
        "down",
        Point("box"),
        (0.0, 0.0, -1.0),
        signal=InputSignal(times=tuple(at.tolist()), values=tuple(np.cos(rate * at).tolist())),
    )
    along = Load(
        "along",
        Point("box"),
        (1.0, 0.0, 0.0),
        signal=InputSignal(times=tuple(at.tolist()), values=tuple(np.sin(rate * at).tolist())),
    )
    ground = Contact("ground", Box("box", (1.0, 2.0, 0.5)), Plane(), mu)
    bodies, joints = (block("box", 1.0, (1.0, 2.0, 0.5)),), (free("box", 0.25),)
    s = started(System(bodies, joints, forces=(down, along), contacts=(ground,), gravity=0.0))
    hand_over(s, 6 * SECOND // 10)
    assert times(s, "ground", "slip") == [pytest.approx(0.5, abs=1e-4)], "a history of straight pieces"


def test_friction_stops_a_sliding_body_and_reports_one_stick_event() -> None:
    """Pushed for a while, it slides, is braked by friction alone, and stands: t = v / mu g after the push."""
    mu, mass, push = 0.3, 5.0, 2.0 * 0.3 * 5.0 * G
    signal = InputSignal(times=(0.0, 0.5, 0.5000001, 2.0), values=(push, push, 0.0, 0.0))
    load = Load("push", Point("box", (0.0, 0.0, -0.25)), (1.0, 0.0, 0.0), signal=signal)
    ground = Contact("ground", Box("box", (2.0, 2.0, 0.5)), Plane(), mu)
    bodies, joints = (block("box", mass, (2.0, 2.0, 0.5)),), (free("box", 0.25),)
    s = started(System(bodies, joints, forces=(load,), contacts=(ground,), gravity=G))
    hand_over(s, 3 * SECOND // 2)
    assert [what for _, what in events(s)] in ([["slip", "stick"], ["stick"]])
    assert times(s, "ground", "stick") == [pytest.approx(1.0, abs=1e-6)]
    assert s.state[0] == pytest.approx(2.0 * 0.5 * mu * G * 0.5**2, rel=1e-6)


def collapse(feet: np.ndarray, mu: np.ndarray, weight: float, at: np.ndarray, towards: np.ndarray) -> float:
    """Largest force along `towards` at a point that the feet (n, 3) hold: static theorem, a linear program."""
    n, (x, y, z) = len(feet), feet.T
    bearing = np.linalg.pinv(np.array([np.ones(n), y, -x]))
    height = at[2] - z[0]
    still, more = bearing[:, 0] * weight, bearing @ [0.0, towards[1] * height, -towards[0] * height]
    angle = 2.0 * np.pi * np.arange(SIDES) / SIDES
    rows = np.kron(np.eye(n), np.stack([np.cos(angle), np.sin(angle)], axis=1))
    within = np.hstack([rows, -np.repeat(mu * more, SIDES)[:, None]])
    balance = np.zeros((3, 2 * n + 1))
    balance[0, 0:-1:2] = balance[1, 1:-1:2] = 1.0
    balance[2, 0:-1:2], balance[2, 1:-1:2] = -y, x
    balance[:, -1] = [*towards[:2], at[0] * towards[1] - at[1] * towards[0]]
    bounds = [(None, None)] * (2 * n) + [(0.0, None)]
    found = linprog(-np.eye(2 * n + 1)[-1], within, np.repeat(mu * still, SIDES), balance, np.zeros(3), bounds=bounds)
    assert (still + found.x[-1] * more > 0.0).all(), "no foot lifts"
    return float(found.x[-1])


def pushed_aside(random: np.random.Generator, feet: np.ndarray, shape, mu: np.ndarray, size) -> list[float]:
    """Times at which something slips on the ground under a force that grows to `RAMP` times the limit in a second,
    at a random point in a random direction."""
    mass, at, heading = 10.0 ** random.uniform(-1, 5), random.uniform(-0.3, 0.3, 3) * size, random.uniform(0.0, 6.28)
    towards = np.array([np.cos(heading), np.sin(heading), 0.0])
    limit = collapse(feet, mu, mass * G, at, towards)
    load = Load("push", Point("box", tuple(at)), tuple(towards), signal=growing(RAMP * limit))
    joint = free("box", float(-feet[0, 2]))
    s = started(System((block("box", mass, size),), (joint,), forces=(load,), contacts=shape, gravity=G))
    hand_over(s, 7 * SECOND // 10)
    assert {what for _, what in events(s)} == {"slip"}
    return [t * 1e-9 for t, _ in s.log]


@pytest.mark.parametrize("seed", range(6))
@pytest.mark.large(beyond=2)
def test_a_box_pushed_off_its_centre_slips_and_turns_at_its_friction_limit(seed: int) -> None:
    random = np.random.default_rng(seed)
    size, mu = random.uniform((0.5, 0.5, 0.2), (3.0, 3.0, 0.5)), random.uniform(0.05, 0.3)
    corners = 0.5 * size * np.array([(x, y, -1.0) for x in (-1.0, 1.0) for y in (-1.0, 1.0)])
    ground = (Contact("ground", Box("box", tuple(size)), Plane(), mu),)
    slips = pushed_aside(random, corners, ground, np.full(4, mu), tuple(size))
    assert slips == [pytest.approx(1.0 / RAMP, rel=1e-4)]


@pytest.mark.parametrize("seed", range(6))
@pytest.mark.large(beyond=2)
def test_a_plate_on_three_pads_of_different_friction_slips_at_its_friction_limit(seed: int) -> None:
    random = np.random.default_rng(100 + seed)
    angle, radius = 2.0 * np.pi * np.arange(3) / 3 + random.uniform(-0.4, 0.4, 3), random.uniform(1.0, 2.0, 3)
    feet = np.stack([radius * np.cos(angle), radius * np.sin(angle), np.full(3, -0.2)], axis=1)
    mu = random.uniform(0.05, 0.3, 3)
    pads = tuple(Contact(f"pad-{i}", Ball("box", tuple(p)), Plane(), float(mu[i])) for i, p in enumerate(feet))
    slips = pushed_aside(random, feet, pads, mu, (1.0, 1.0, 0.4))
    assert slips[0] == pytest.approx(1.0 / RAMP, rel=1e-4)
