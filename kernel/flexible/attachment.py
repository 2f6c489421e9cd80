"""The frame that a joint finds on a flexible body: carried by the modes at a station, or at one that slides.

With the shapes Phi (displacement) and Psi (rotation) of the modes at place X, d = X + Phi eta and theta = Psi eta,
    R = 1 + n (skew(theta) + skew(theta)^2 / 2),  n = 1/(1 + theta^2/4)     (Cayley's rotation: no singular zero)   (9)
    w = n (theta' + theta x theta'/2)                                       its exact angular velocity            (10)
so that columns are derivatives of places and the accounts of energy close.  A slider moves along the beam, X = s e, and
the shapes depend on s: theta' = Psi eta' + Psi_s eta s', theta" = 2 Psi_s eta' s' + Psi_ss eta s'^2 (+ what eta", s"
bring), d likewise.                                                                                               (11)
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from ..spatial import cross, join, motion_cross, skew

__all__ = ["Carried", "Place", "Track", "carry", "carry_along"]

ALONG = np.array([1.0, 0.0, 0.0])  # beams lie along x


@dataclass(frozen=True)
class Place:
    """A station: its place X (3,) on the undeformed body [m] and the modes' displacements and rotations (6, m)."""

    X: np.ndarray
    shape: np.ndarray


@dataclass(frozen=True)
class Track:
    """The modes along a whole beam: (n, 6, m) coefficients of Chebyshev polynomials T_0 to T_n-1 over 0 to L.

    `slope` is 2/L [1/m]; X is the rest of a slider's offset from its station: none.
    """

    X: np.ndarray
    slope: Any
    coefficients: np.ndarray

    def shapes(self, s: Any) -> tuple[Any, Any, Any]:
        """(6, m) shapes at s [m] and their first and second derivative in s, by the polynomials' recurrences."""
        x = self.slope * s - 1.0
        T, dT, ddT = [1.0, x], [0.0, 1.0], [0.0, 0.0]
        for _ in range(2, len(self.coefficients)):
            T, dT, ddT = (
                [*T, 2.0 * x * T[-1] - T[-2]],
                [*dT, 2.0 * (T[-1] + x * dT[-1]) - dT[-2]],
                [*ddT, 2.0 * (2.0 * dT[-1] + x * ddT[-1]) - ddT[-2]],
            )
        c, zero = self.coefficients, np.zeros(self.coefficients.shape[1:])
        value, first, second = (sum((c[n] * t for n, t in enumerate(P)), zero) for P in (T, dT, ddT))
        return value, first * self.slope, second * (self.slope * self.slope)


@dataclass(frozen=True)
class Carried:
    """The frame at a place, in world axes: rotation R, r from the tree's point, twist V, bias acceleration A; a column
    per mode, and that of the slider's coordinate."""

    R: Any
    r: Any
    V: Any
    A: Any
    columns: list[Any]
    along: Any = None


def carry(place: Place, eta: Any, rates: Any, R: Any, r: Any, V: Any, A: Any) -> Carried:
    """The frame at a station of a body whose floating frame has pose R, r and motion V, A in world axes."""
    return _carried(place.shape, eta, rates, (place.X, 0.0 * place.X, 0.0 * place.X), np.zeros((2, 3)), (R, r, V, A))


def carry_along(track: Track, s: Any, speed: Any, eta: Any, rates: Any, R: Any, r: Any, V: Any, A: Any) -> Carried:
    """The frame at s [m] along a beam, sliding with a speed [m/s]."""
    shape, first, second = track.shapes(s)
    tangent = first @ eta + join(ALONG, np.zeros(3))
    bias = 2.0 * speed * (first @ rates) + speed * speed * (second @ eta)
    moving = (ALONG * s, tangent[:3] * speed, bias[:3])
    turning = np.array([tangent[3:] * speed, bias[3:]])
    return _carried(shape, eta, rates, moving, turning, (R, r, V, A), tangent)


def _carried(
    shape: Any, eta: Any, rates: Any, moving: Any, turning: Any, frame: tuple[Any, Any, Any, Any], tangent: Any = None
) -> Carried:
    """Equations (9) and (10); moving: X, and the velocity and acceleration of the place that the modes do not bring;
    turning: likewise of theta."""
    R, r, V, A = frame
    U, T = shape[:3], shape[3:]
    theta = T @ eta
    n = 1.0 / (1.0 + 0.25 * (theta @ theta))

    def turned(rate: Any) -> Any:
        return n * (rate + 0.5 * cross(theta, rate))

    d_rate, theta_rate = U @ rates + moving[1], T @ rates + turning[0]
    n_rate = -0.5 * n * n * (theta @ theta_rate)
    w = turned(theta_rate)
    w_bias = n_rate * (theta_rate + 0.5 * cross(theta, theta_rate)) + turned(turning[1])
    r_X = r + R @ (moving[0] + U @ eta)

    def column(angular: Any, linear: Any) -> Any:
        w = R @ angular
        return join(w, R @ linear + cross(r_X, w))

    V_X = column(w, d_rate)
    K = skew(theta)
    return Carried(
        R=R @ (np.eye(3) + n * (K + 0.5 * (K @ K))),
        r=r_X,
        V=V + V_X,
        A=A + motion_cross(V) @ V_X + column(w_bias, moving[2] + cross(d_rate, w)),
        columns=[column(turned(T[:, k]), U[:, k]) for k in range(len(eta))],
        along=None if tangent is None else column(turned(tangent[3:]), tangent[:3]),
    )
