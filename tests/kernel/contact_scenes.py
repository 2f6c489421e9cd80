"""Bricks, balls and slopes that touch."""

from math import atan, cos, hypot, sin

import numpy as np
from heavylift.kernel.description import Ball, Body, Box, Contact, Joint, Plane, System
from scipy.spatial.transform import Rotation
from small_scenes import G

LEVEL = (0.0, 0.0, 0.0, 1.0)
STILL = (0.0,) * 6


def brick(name, size, mass):
    a, b, c = size
    x, y, z = (mass * k / 12.0 for k in (b * b + c * c, a * a + c * c, a * a + b * b))
    return Body(name, mass, inertia=((x, 0.0, 0.0), (0.0, y, 0.0), (0.0, 0.0, z)))


def floating(name, p, q=LEVEL, v=STILL):
    return Joint(f"{name}-float", "free", "world", name, q0=(*map(float, p), *map(float, q)), v0=tuple(v))


def on_slope(angle, mu, v=0.0, size=(2.0, 1.5, 1.0), mass=10.0):
    """A brick on a plane that falls along the brick's own x axis, moving down it with v."""
    R = Rotation.from_rotvec([0.0, angle, 0.0])
    n = R.apply([0.0, 0.0, 1.0])
    body = brick("brick", size, mass)
    joint = floating("brick", 0.5 * size[2] * n, R.as_quat(), (v, 0.0, 0.0, 0.0, 0.0, 0.0))
    slope = Contact("slope", Box("brick", size), Plane(normal=tuple(n)), mu)
    return System((body,), (joint,), contacts=(slope,), gravity=G)


def way(state, angle):
    """Down the slope, across it, and above it."""
    return Rotation.from_rotvec([0.0, angle, 0.0]).inv().apply(state[:3])


def rocker(b, h, theta, mass=10.0, mu=0.8):
    """A block of half width b and half height h that leans by theta on one lower edge, through the origin."""
    R = Rotation.from_rotvec([0.0, theta, 0.0])
    size = (2 * b, 1.0, 2 * h)
    joint = floating("block", R.apply([-b, 0.0, h]), R.as_quat())
    ground = Contact("ground", Box("block", size), Plane(), mu)
    return System((brick("block", size, mass),), (joint,), contacts=(ground,), gravity=G)


def rocking(b, h):
    """Angle of the diagonal [rad], and p = sqrt(m g R / I) about an edge [1/s] (Housner 1963)."""
    R = hypot(b, h)
    return atan(b / h), (G * R / (4.0 / 3.0 * R * R)) ** 0.5


def ball(name, radius, mass, p, v=STILL):
    i = 0.4 * mass * radius * radius
    return Body(name, mass, inertia=((i, 0.0, 0.0), (0.0, i, 0.0), (0.0, 0.0, i))), floating(name, p, v=v)


def row_of_balls(gap, restitution):
    """Three equal balls, the first running at 1 m/s into the other two."""
    balls = [
        ball(n, 0.5, 1.0, (x, 0.0, 0.0), (v, *STILL[1:]))
        for n, x, v in zip("abc", (-2.0, 0.0, 1.0 + gap), (1.0, 0.0, 0.0), strict=True)
    ]
    pairs = [Contact(x + y, Ball(x, radius=0.5), Ball(y, radius=0.5), 0.0, restitution) for x, y in ("ab", "bc")]
    return System(tuple(b for b, _ in balls), tuple(j for _, j in balls), contacts=tuple(pairs), gravity=0.0)


def bouncing(height, restitution):
    """A ball of radius 0.5 m that falls from a height of its underside."""
    body, joint = ball("ball", 0.5, 2.0, (0.0, 0.0, 0.5 + height))
    floor = Contact("floor", Ball("ball", radius=0.5), Plane(), 0.0, restitution)
    return System((body,), (joint,), contacts=(floor,), gravity=G)


def stacked(offset, size=(1.0, 1.0, 1.0), yaw=0.0, mu=0.5):
    """A brick on a fixed, larger one."""
    q = Rotation.from_euler("z", yaw).as_quat()
    post = Joint("post", "fixed", "world", "low", p_PJ=(0.0, 0.0, 0.5))
    up = floating("up", (offset, 0.0, 1.0 + 0.5 * size[2]), q)
    pair = Contact("pair", Box("up", size), Box("low", (2.0, 2.0, 1.0)), mu)
    return System(
        (brick("low", (2.0, 2.0, 1.0), 10.0), brick("up", size, 5.0)), (post, up), contacts=(pair,), gravity=G
    )


def tumbling(seed):
    """A cube in a random attitude falls on the upper edge of a larger one."""
    rng = np.random.default_rng(seed)
    q, spin = Rotation.random(random_state=seed).as_quat(), rng.normal(size=3)
    tilt = Rotation.from_euler("x", 45, degrees=True).as_matrix()
    post = Joint("post", "fixed", "world", "low", p_PJ=(0.0, 0.0, 0.5), R_PJ=tuple(map(tuple, tilt.tolist())))
    x, y = 0.2 * rng.normal(size=2)
    up = floating("up", (x, y, 3.0), q, (0.0, 0.0, 0.0, *map(float, spin)))
    bodies = (brick("low", (2.0, 2.0, 2.0), 10.0), brick("up", (1.0, 1.0, 1.0), 5.0))
    pair = Contact("pair", Box("up", (1.0, 1.0, 1.0)), Box("low", (2.0, 2.0, 2.0)), 0.3)
    return System(bodies, (post, up), contacts=(pair,), gravity=G)


def on_three_feet(x, y, mass=6.0):
    """A plate on three points whose centre of mass lies at (x, y)."""
    body = Body("plate", mass, (x, y, 0.3), ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)))
    feet = {"a": (-1.0, -1.0), "b": (1.0, -1.0), "c": (0.0, 2.0)}
    contacts = tuple(Contact(n, Ball("plate", (*p, 0.0)), Plane(), 0.5) for n, p in feet.items())
    return System((body,), (floating("plate", (0.0, 0.0, 0.0)),), contacts=contacts, gravity=G)


def sliding_acceleration(angle, mu):
    return G * (sin(angle) - mu * cos(angle))


def leaning(state):
    """Angle of a body's z axis from the vertical [rad]."""
    return float(np.arccos(np.clip(Rotation.from_quat(state[3:7]).apply([0.0, 0.0, 1.0])[2], -1.0, 1.0)))
