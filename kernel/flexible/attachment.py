"""The frame that a joint finds on a flexible body: carried by the modes at a station, or at one that slides.

With the shapes Phi (displacement) and Psi (rotation) of the modes at place X, d = X + Phi eta and theta = Psi eta,
    R = 1 + n (skew(theta) + skew(theta)^2 / 2),  n = 1/(1 + theta^2/4)     (Cayley's rotation: no singular zero)   (9)
    w = n (theta' + theta x theta'/2)                                       its exact angular velocity            (10)
so that columns are derivatives of places and the accounts of energy close.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from ..spatial import cross, join, motion_cross, skew

__all__ = ["Carried", "Place", "carry"]


@dataclass(frozen=True)
class Place:
    """A station: its place X (3,) on the undeformed body [m] and the modes' displacements and rotations (6, m)."""

    X: np.ndarray
    shape: np.ndarray


@dataclass(frozen=True)
class Carried:
    """The frame at a place, in world axes: rotation R, r from the tree's point, twist V, bias acceleration A; and a
    column per mode."""

    R: Any
    r: Any
    V: Any
    A: Any
    columns: list[Any]


def carry(place: Any, eta: Any, rates: Any, R: Any, r: Any, V: Any, A: Any) -> Carried:
    """The frame at a place on a body whose floating frame has pose R, r and motion V, A in world axes."""
    U, T = place.shape[:3], place.shape[3:]
    d, theta = place.X + U @ eta, T @ eta
    n = 1.0 / (1.0 + 0.25 * (theta @ theta))

    def turning(rate: Any) -> Any:
        return n * (rate + 0.5 * cross(theta, rate))

    d_rate, theta_rate = U @ rates, T @ rates
    n_rate = -0.5 * n * n * (theta @ theta_rate)
    w_bias = n_rate * (theta_rate + 0.5 * cross(theta, theta_rate))
    r_X = r + R @ d

    def column(angular: Any, linear: Any) -> Any:
        w = R @ angular
        return join(w, R @ linear + cross(r_X, w))

    w = turning(theta_rate)
    V_X = column(w, d_rate)
    K = skew(theta)
    return Carried(
        R=R @ (np.eye(3) + n * (K + 0.5 * (K @ K))),
        r=r_X,
        V=V + V_X,
        A=A + motion_cross(V) @ V_X + column(w_bias, cross(d_rate, w)),
        columns=[column(turning(T[:, k]), U[:, k]) for k in range(len(eta))],
    )
