"""Geometry of a rope over sheaves: straight parts between tangent points, and arcs.

A node is a point (radius 0) or a sheave around which the rope turns positively about its axis.  With u the direction
of a straight part and n the axis, a rope leaves a circle at c + r w, w = u x n; so for two circles
u = (l D + (r_a - r_b) n x D) / |D|^2 with D from centre to centre and l^2 = |D|^2 - (r_a - r_b)^2.  A point has r = 0.
Sheaves are planar: D lies across the axis up to a small fleet angle; neighbouring axes are parallel, or opposite where
the rope turns the other way (a crossed belt).

The arc is divided at a direction that is fixed on the sheave's body, so that the length of each part has the rate
u . (v_B - v_A) of the material tangent points, which tensions of any ratio do work on.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

from ..elementary import atan2
from ..spatial import cross
from ..symbol import sqrt

__all__ = ["Node", "Part", "parts", "turn"]


@dataclass(frozen=True)
class Node:
    """A point or sheave of a rope: centre from its tree's point, in the world, velocity, angular velocity of the body,
    axis and dividing direction in world axes; radius None for a point."""

    x: Any
    c: Any
    v: Any
    w: Any
    axis: Any
    divide: Any
    radius: Any = None


@dataclass(frozen=True)
class Part:
    """A straight part with its arcs: length [m], its rate, direction u, arms from the trees' points at both ends."""

    length: Any
    rate: Any
    u: Any
    arms: tuple[Any, Any]
    plane: Any = None  # u across the axis, for wraps
    turning: Any = None  # (3,) angular velocity of that direction [rad/s]


def parts(nodes: Sequence[Node], turning: Sequence[bool]) -> list[Part]:
    """The parts of a rope over its nodes; `turning`: whether the direction at a node matters, for its wrap."""
    return [_part(a, b, turning[i] or turning[i + 1]) for i, (a, b) in enumerate(pairwise(nodes))]


def _part(a: Node, b: Node, turning: bool) -> Part:
    D, dD = b.c - a.c, b.v - a.v
    if not turning and a.radius is None and b.radius is None:
        length = sqrt(D @ D)
        u = D * (1.0 / length)
        return Part(length, u @ dD, u, (a.x, b.x))
    n = b.axis if a.axis is None else a.axis
    r_a, r_b = (0.0 if x.radius is None else x.radius * (x.axis @ n) for x in (a, b))  # < 0: turns the other way
    h = D @ n
    across = D - h * n
    square = across @ across
    bias = r_a - r_b
    flat = sqrt(square - bias * bias)
    plane = (flat * across + bias * cross(n, across)) * (1.0 / square)
    w = cross(plane, n)
    straight = sqrt(flat * flat + h * h)
    u = (flat * plane + h * n) * (1.0 / straight)
    length, rate = straight, u @ dD
    arms = []
    for x, arm, sign in ((a, r_a * w, 1.0), (b, r_b * w, -1.0)):
        if x.radius is None:
            arms.append(x.x)
            continue
        length = length + sign * x.radius * turn(x, plane)
        rate = rate - sign * (u @ cross(x.w, arm))
        arms.append(x.x + arm)
    return Part(length, rate, u, (arms[0], arms[1]), plane, ((cross(n, plane) @ dD) * (1.0 / flat)) * n)


def turn(x: Node, plane: Any) -> Any:
    """[rad] from the dividing direction of a node to where a part of this direction touches."""
    w = cross(plane, x.axis)
    return atan2(x.axis @ cross(x.divide, w), x.divide @ w)
