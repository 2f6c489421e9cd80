"""Motion of the frame of a joint on a flexible body, which the modes carry at a fixed or a sliding station, and the
body's inertia.

With the shapes Phi (displacement) and Psi (rotation) of the modes at place X,
    d = X + Phi eta - 1/2 e (eta^T g eta),  g_kl(x) = integral of the products of the slopes of modes k and l,      (9)
    theta = Psi eta,  R = 1 + n (skew(theta) + skew(theta)^2 / 2),  n = 1/(1 + theta^2/4)   (Cayley: no singular 0) (10)
    w = n (theta' + theta x theta'/2)                                       its exact angular velocity            (11)
so that columns are derivatives of positions and the energy balance closes.  The last term of (9) is the shortening of a
bent beam: with it, tension stiffens and compression softens (Kane, Ryan, Banerjee 1987).  A slider moves along the
beam, X = s e, and the shapes depend on s: theta' = Psi eta' + Psi_s eta s', theta" = 2 Psi_s eta' s' + Psi_ss eta s'^2
(+ terms of eta", s"), d likewise.                                                                              (12)

Inertia of a flexible body in the recursion: the equations of its floating frame and of its modes.

From the kinetic energy (3) of `tracks`, with momentum P = I nu + C eta' in body axes, Poincare's equations are
    dP/dt + nu x* P = wrench,     d/dt (C_l^T nu + m_l eta'_l) - dT/deta_l = force on mode l,                      (6)
and with D_k = dI/deta_k = J1_k + sum_l eta_l J2_kl, I' = sum_k eta'_k D_k, C'_l = sum_k eta'_k G1_kl:
    wrench  = I a + C eta'' + I' nu + C' eta' + nu x* (I nu + C eta'),                                             (7)
    force_l = C_l^T a + m_l eta''_l + C'_l^T nu - 1/2 nu^T D_l nu - sum_k eta'_k G1_lk^T nu.                        (8)
a is the acceleration of the frame in body axes; that of the ground, upwards, is gravity.  The terms follow
from T alone, so that energy and momentum are conserved exactly for any constants.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from heavylift.kernel.algebra.spatial import cross, force_cross, join, mirror, motion_cross, skew
from heavylift.kernel.compiler.symbol import Array, Scalar

ALONG = np.array([1.0, 0.0, 0.0])  # e: beams lie along x


@dataclass(frozen=True)
class Place:
    """A station (point of attachment) on a flexible body: its undeformed position (3,) [m] and the modes there."""

    X: np.ndarray  # (3,) on the undeformed body [m]
    shape: np.ndarray  # (6, m) displacements and rotations of the modes
    shortening: np.ndarray  # (m, m) slope integrals g of equation (9)


@dataclass(frozen=True)
class Track:
    """The modes of a beam, on which sliders move, as Chebyshev polynomials along it."""

    X: np.ndarray  # offset of a slider from its station, always zero here
    slope: Scalar  # 2 / L [1/m]
    coefficients: np.ndarray  # (n, 6, m) over 0 to L
    shortening: np.ndarray  # (n', m, m) for the geometric terms

    def shapes(self, s: Scalar) -> tuple[Array, Array, Array, Array]:
        """Return mode shapes (6, m) at s [m] along the beam, with two derivatives, and slope integrals g (m, m)."""
        # Chebyshev polynomials are defined on -1..1
        x = self.slope * s - 1.0
        # three-term recurrences of T_n and their derivatives
        T, dT, ddT = [1.0, x], [0.0, 1.0], [0.0, 0.0]
        for _ in range(2, max(len(self.coefficients), len(self.shortening))):
            T, dT, ddT = (
                [*T, 2.0 * x * T[-1] - T[-2]],
                [*dT, 2.0 * (T[-1] + x * dT[-1]) - dT[-2]],
                [*ddT, 2.0 * (2.0 * dT[-1] + x * ddT[-1]) - ddT[-2]],
            )

        def along(coefficients: Array, P: list[Any]) -> Any:
            return sum((c * t for c, t in zip(coefficients, P, strict=False)), np.zeros(np.shape(coefficients)[1:]))

        value, first, second = (along(self.coefficients, P) for P in (T, dT, ddT))
        return value, first * self.slope, second * (self.slope * self.slope), along(self.shortening, T)


@dataclass(frozen=True)
class Carried:
    """The frame at a station of a flexible body, in world axes: its pose, motion and velocity columns.

    Rotation R, r from the tree's reference point, twist V, bias acceleration A, one velocity column per mode; `along`:
    the column of the slider's coordinate.
    """

    R: Array
    r: Array
    V: Array
    A: Array
    columns: list[Scalar]
    along: Array | None = None


def carry(place: Place, eta: Array, rates: Array, R: Array, r: Array, V: Array, A: Array) -> Carried:
    """Return pose and motion of a station (attachment point) of a flexible body, from its floating frame R, r, V, A."""
    # g eta serves the position, eta^T g eta / 2, and its rate, eta'^T g eta
    pull = place.shortening @ eta
    U, T = place.shape[:3] - np.outer(ALONG, pull), place.shape[3:]
    d = place.X + place.shape[:3] @ eta - ALONG * (0.5 * (eta @ pull))
    moving = (d, U @ rates, -ALONG * (rates @ (place.shortening @ rates)))
    return _carried(U, T, eta, moving, (T @ rates, np.zeros(3)), (R, r, V, A))


def carry_along(
    track: Track, s: Scalar, speed: Scalar, eta: Array, rates: Array, R: Array, r: Array, V: Array, A: Array
) -> Carried:
    """Return the frame of a slider that is at s [m] along a beam and moves along it with a speed [m/s]."""
    shape, first, second, g = track.shapes(s)
    pull = g @ eta
    U, T = shape[:3] - np.outer(ALONG, pull), shape[3:]
    # slope and bending of the beam: g depends on s through the product of slopes, whose derivative is known exactly
    slope, bend, slope_rate = T[1:] @ eta, first[4:] @ eta, T[1:] @ rates  # about y and z; g_s is their product
    tangent = first @ eta + join(ALONG, np.zeros(3)) - join(ALONG, np.zeros(3)) * (0.5 * (slope @ slope))
    # Coriolis and centripetal terms of sliding along a moving, bent beam
    bias = 2.0 * speed * (first @ rates) + speed * speed * (second @ eta)
    shorter = rates @ (g @ rates) + 2.0 * speed * (slope @ slope_rate) + speed * speed * (slope @ bend)
    d = ALONG * s + shape[:3] @ eta - ALONG * (0.5 * (eta @ pull))
    moving = (d, U @ rates + tangent[:3] * speed, bias[:3] - ALONG * shorter)
    turning = (T @ rates + tangent[3:] * speed, bias[3:])
    return _carried(U, T, eta, moving, turning, (R, r, V, A), tangent)


def _carried(
    U: Array,
    T: Array,
    eta: Array,
    moving: tuple[Array, Array, Array],
    turning: tuple[Array, Array],
    frame: tuple[Array, Array, Array, Array],
    tangent: Array | None = None,
) -> Carried:
    """Evaluate equations (10) and (11). `moving`: d with its rate and its second derivative without eta" and s";
    `turning`: rate and second derivative of theta likewise."""
    R, r, V, A = frame
    theta = T @ eta
    # Cayley's map has no singularity at zero and needs no trigonometric functions
    n = 1.0 / (1.0 + 0.25 * (theta @ theta))

    def turned(rate: Array) -> Any:
        return n * (rate + 0.5 * cross(theta, rate))

    d, d_rate, d_bias = moving
    theta_rate, theta_bias = turning
    n_rate = -0.5 * n * n * (theta @ theta_rate)
    w = turned(theta_rate)
    w_bias = n_rate * (theta_rate + 0.5 * cross(theta, theta_rate)) + turned(theta_bias)
    r_X = r + R @ d

    def column(angular: Array, linear: Array) -> Any:
        w = R @ angular
        return join(w, R @ linear + cross(r_X, w))

    V_X = column(w, d_rate)
    K = skew(theta)
    return Carried(
        R=R @ (np.eye(3) + n * (K + 0.5 * (K @ K))),
        r=r_X,
        V=V + V_X,
        # the bias: transport by the floating frame, then terms quadratic in rates of modes and slider
        A=A + motion_cross(V) @ V_X + column(w_bias, d_bias + cross(d_rate, w)),
        columns=[column(turned(T[:, k]), U[:, k]) for k in range(len(eta))],
        along=None if tangent is None else column(turned(tangent[3:]), tangent[:3]),
    )


@dataclass(frozen=True)
class FlexibleInertia:
    """Inertia of a flexible body at one instant, in world axes about the reference point of the tree.

    I: inertia (6, 6); C: momentum per mode rate (m, 6); wrench (6,) and forces (m,): the right-hand sides of (7) and
    (8); momentum (6,); kinetic energy [J]; moment: first moment of mass about the tree's point [kg m].
    """

    I: Array
    C: list[Array]
    mass: list[Scalar]
    wrench: Array
    forces: list[Array]
    momentum: Array
    kinetic: Scalar
    moment: Array


def flexible_inertia(
    e: Any, eta: Array, rates: Array, accelerations: Array, R: Array, r: Array, V: Array, A: Array
) -> FlexibleInertia:
    """Return mass matrix and inertia forces of a flexible body, equations (7) and (8) of the module.

    e: `tracks.ReducedBody` of floats or symbols; mode coordinates (m,); pose R_WB, r and V, A (6,) in world axes.
    """
    m = range(len(eta))
    to_body = np.block([[R.T, np.zeros((3, 3))], [-(R.T @ skew(r)), R.T]])
    nu, a = to_body @ V, to_body @ A
    none = np.zeros(6)
    D = [e.J1[k] + sum((e.J2[k, l] * eta[l] for l in m), np.zeros((6, 6))) for k in m]
    # second-order expansion: J0 + J1 eta + eta J2 eta / 2, symmetric by construction
    I = mirror(e.J0 + 0.5 * sum(((e.J1[k] + D[k]) * eta[k] for k in m), np.zeros((6, 6))))
    C = [e.G0[l] + sum((e.G1[k, l] * eta[k] for k in m), none) for l in m]
    C_rate = [sum((e.G1[k, l] * rates[k] for k in m), none) for l in m]
    I_rate = sum((D[k] * rates[k] for k in m), np.zeros((6, 6)))
    moving = sum((C[l] * rates[l] for l in m), none)
    P = I @ nu + moving
    speeding = sum((C[l] * accelerations[l] for l in m), none)
    # I' nu + C' eta' + nu x* momentum, of equation (7)
    turning = I_rate @ nu + sum((C_rate[l] * rates[l] for l in m), none) + force_cross(nu) @ P
    forces = [
        C[l] @ a
        + e.mass[l] * accelerations[l]
        + C_rate[l] @ nu
        - 0.5 * (nu @ (D[l] @ nu))
        # - dT/deta: with it the equations conserve energy for any constants
        - sum((e.G1[l, k] * rates[k] for k in m), none) @ nu
        for l in m
    ]
    return FlexibleInertia(
        I=mirror(to_body.T @ I @ to_body),
        C=[to_body.T @ c for c in C],
        mass=e.mass,
        wrench=to_body.T @ (I @ a + speeding + turning),
        forces=forces,
        momentum=to_body.T @ P,
        kinetic=0.5 * (nu @ (P + moving) + sum((e.mass[l] * rates[l] * rates[l] for l in m), 0.0)),
        # the off-diagonal block of the spatial inertia is m c x: read the first moment of mass from it
        moment=e.J0[3, 3] * r + R @ np.array([I[2, 4], I[0, 5], I[1, 3]]),
    )
