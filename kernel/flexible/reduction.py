"""From a finite-element model to modes and to the constants of the kinetic energy of a flexible body.

With U_j = (velocity, angular velocity) of node j in body axes, nu = (w; v) the twist of the floating frame and eta the
mode coordinates,
    U = B(eta) nu + Phi eta',   B(eta) = B_0 + sum_k eta_k B_k,                                                  (1)
    B_0 = [[-skew(X_j), 1], [1, 0]] of node j at X_j,   B_k = [[-skew(Phi_kj), 0], [0, 0]],                        (2)
    T = 1/2 U^T M U = 1/2 nu^T I(eta) nu + nu^T C(eta) eta' + 1/2 eta'^T m eta'.                                  (3)
The constants follow from M and Phi alone, as in the nodal-based floating frame of reference formulation (Zwoelfer,
Gerstmayr 2019) and with the meaning of the standard input data (Wallrapp 1994; Shabana 2013, chapter 5):
    I = J0 + sum_k eta_k J1_k + 1/2 sum_kl eta_k eta_l J2_kl,   C_l = G0_l + sum_k eta_k G1_kl,                    (4)
    J0 = B_0^T M B_0,  J1_k = B_0^T M B_k + (..)^T,  J2_kl = B_k^T M B_l + (..)^T,  G0_l = B_0^T M Phi_l,
    G1_kl = B_k^T M Phi_l.                                                                                        (5)
The shortening of a bent beam (equation (9) of `attachment`) is a displacement of second order; it adds to G1 and J2 as
those of first order add to G0 and J1, which is the geometric stiffness.
The modes are M-orthogonal, so that m and the reduced stiffness are diagonal.  The momentum is that of the moving centre
of mass (so that acceleration of the ground and gravity are one) if the first moments in J1 are the forces in G0: for
matrices that interpolate displacements with slopes, (5) fulfils this to the order of the elements; it is set exactly.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.linalg import LinAlgError
from numpy.polynomial import chebyshev
from scipy.interpolate import make_interp_spline
from scipy.linalg import eigh

from ..errors import KernelError
from .attachment import Track
from .beam import beam_matrices, hermite, nodes_of, rigid_directions
from .description import Beam, Flexible

__all__ = ["Elastic", "Modes", "modes_of", "reduced"]

DIGITS = 12  # to which constants are rounded, so that they do not depend on a machine's linear algebra
DEPENDENT = 1e-8  # what is left of a shape that is a sum of the others
SMOOTH, NOT_SMOOTH = 1e-6, 1e-2  # errors of polynomials along a beam, sought and refused; shapes are 1 at most
NODE = 1e-6  # [m] how far an attached point may be off its node by rounding


@dataclass(frozen=True)
class Elastic:
    """The constants of equations (4)."""

    J0: np.ndarray  # (6, 6)
    J1: np.ndarray  # (m, 6, 6)
    J2: np.ndarray  # (m, m, 6, 6)
    G0: np.ndarray  # (m, 6)
    G1: np.ndarray  # (m, m, 6)
    mass: np.ndarray  # (m,) of the modes


@dataclass(frozen=True)
class Modes:
    """Shapes of a body's modes over the degrees of freedom of its model; mass, stiffness and damping of each."""

    name: str
    flexible: Flexible
    nodes: np.ndarray  # (n, 3) [m]
    M: np.ndarray  # (6n, 6n)
    shapes: np.ndarray  # (6n, m)
    mass: np.ndarray  # (m,)
    stiffness: np.ndarray  # (m,)
    damping: np.ndarray  # (m,)

    def station(self, p: tuple[float, float, float]) -> tuple[int | float, np.ndarray]:
        """Where a point of the body is attached: the number of its node or its x along the beam, and that place.

        Raises KernelError for a point beyond the beam's ends or at no node.
        """
        if beam := self.flexible.beam:
            if not -NODE <= p[0] <= beam.length + NODE:
                raise KernelError(f"body '{self.name}': x = {p[0]:g} m lies beyond its ends at 0 and {beam.length:g} m")
            return p[0], np.array([p[0], 0.0, 0.0])
        distance = np.linalg.norm(self.nodes - np.array(p), axis=1)
        node = int(np.argmin(distance))
        if distance[node] > NODE:
            near = ", ".join(f"{x:g}" for x in self.nodes[node])
            raise KernelError(f"body '{self.name}': ({p[0]:g}, {p[1]:g}, {p[2]:g}) is no node; the nearest is ({near})")
        return node, self.nodes[node]

    def at(self, station: int | float) -> np.ndarray:
        """(6, m) displacement and rotation of every mode at a station."""
        if beam := self.flexible.beam:
            return _rounded(hermite(beam, float(station)) @ self.shapes)
        return _rounded(self.shapes[6 * int(station) : 6 * int(station) + 6])

    def track(self, joint: str) -> Track:
        """Displacements and rotations (slopes) of every mode as polynomials of the place along the beam.

        Raises KernelError naming the joint that slides if this is no beam or a mode is not smooth.
        """
        beam, m = self.flexible.beam, len(self.mass)
        if beam is None:
            raise KernelError(f"joint '{joint}': body '{self.name}' is no beam; a slider needs one")
        x = np.cos(np.pi * (np.arange(4 * beam.elements) + 0.5) / (4 * beam.elements))
        places = (1.0 + x) * beam.length / 2.0
        nodal = self.shapes.reshape(-1, 6, m)[:, :4].reshape(-1, 4 * m)  # ux uy uz rx; ry and rz are slopes
        # where elements are most accurate, at their nodes, and smooth between them, as the modes are
        moved = make_interp_spline(self.nodes[:, 0], nodal, k=min(7, (beam.elements - 1) | 1))(places)
        fits = {n: chebyshev.chebfit(x, moved, n) for n in range(8, beam.elements + 9, 2)}
        errors = {n: float(np.abs(chebyshev.chebval(x, c).T - moved).max(initial=0.0)) for n, c in fits.items()}
        least = min(errors.values())
        if least > NOT_SMOOTH:
            raise KernelError(
                f"joint '{joint}': polynomials follow the modes of '{self.name}' to {least:.1g} only; "
                "give its beam fewer modes or loads, or more elements"
            )
        fit = fits[next(n for n, error in errors.items() if error <= max(SMOOTH, 2.0 * least))]
        fit = fit.reshape(-1, 4, m)
        slopes = np.zeros_like(fit)
        slopes[:-1] = chebyshev.chebder(fit) * (2.0 / beam.length)
        coefficients = _rounded(np.concatenate([fit, -slopes[:, 2:3], slopes[:, 1:2]], axis=1))
        g = np.zeros((2 * len(coefficients), m, m))
        for k, l, d in np.ndindex(m, m, 2):
            product = chebyshev.chebmul(coefficients[:, 4 + d, k], coefficients[:, 4 + d, l])
            integral = chebyshev.chebint(product, lbnd=-1.0) * (beam.length / 2.0)
            g[: len(integral), k, l] += integral
        g[0] += self.shortening(0.0)
        return Track(np.zeros(3), 2.0 / beam.length, coefficients, _rounded(g))

    def shortening(self, station: int | float) -> np.ndarray:
        """(m, m) g of equation (9) in `attachment` at a station: integrals of products of slopes [1/m]; 0 if no beam.

        From the root on, where that holds the frame; the mean along the beam vanishes where nothing does.
        """
        beam, m = self.flexible.beam, len(self.mass)
        if beam is None:
            return np.zeros((m, m))
        h = beam.length / beam.elements
        e = min(int(float(station) / h), beam.elements - 1)
        return _rounded(self.nodal_shortening[e] + self._product(beam, e * h, float(station)))

    @cached_property
    def nodal_shortening(self) -> np.ndarray:
        """(n, m, m) of all nodes."""
        beam, none = self.flexible.beam, np.zeros((len(self.mass),) * 2)
        if beam is None:
            return np.array([none] * len(self.nodes))
        h = beam.length / beam.elements
        g = np.cumsum([none, *(self._product(beam, e * h, (e + 1) * h) for e in range(beam.elements))], axis=0)
        return g - g.mean(axis=0) if self.flexible.frame == "free" else g

    def _product(self, beam: Beam, a: float, b: float) -> np.ndarray:
        """(m, m) integral of the products of slopes over a part of one element: of degree 4, exact with 3 points."""
        points, weights = np.polynomial.legendre.leggauss(3)
        slopes = [(hermite(beam, (a + b + (b - a) * x) / 2.0) @ self.shapes)[4:] for x in points]
        return np.asarray(sum(w * (b - a) / 2.0 * s.T @ s for w, s in zip(weights, slopes, strict=True)))


def _rounded(x: np.ndarray) -> np.ndarray:
    """x to DIGITS significant digits of its largest element, so that what should be zero is zero."""
    largest = float(np.abs(x).max(initial=0.0))
    if largest == 0.0:
        return x
    scale = 10.0 ** np.ceil(np.log10(largest))
    digits: np.ndarray = np.round(x / scale, DIGITS) * scale + 0.0  # no negative zeros
    return digits


def modes_of(name: str, flexible: Flexible) -> Modes:
    """Eigenmodes (lowest first) and attachment modes, or the given ones.

    Raises KernelError if there are too few or something can move without mass or stiffness.
    """
    nodes, M, K, held = _model(flexible)
    try:
        shapes = _shapes(name, flexible, nodes, M, K, held)
    except LinAlgError:
        raise KernelError(
            f"body '{name}': its mass matrix must be positive definite wherever the frame does not hold it"
        ) from None
    mass = np.einsum("ik,ij,jk->k", shapes, M, shapes)
    stiffness = np.einsum("ik,ij,jk->k", shapes, K, shapes)
    loose = [k + 1 for k, x in enumerate(stiffness) if not x > NODE * stiffness.max()]
    if loose:
        raise KernelError(f"body '{name}': mode {loose[0]} has no stiffness; let the frame hold the body against it")
    if flexible.start and len(flexible.start) != len(mass):
        raise KernelError(f"body '{name}': {len(flexible.start)} coordinates at the start for {len(mass)} modes")
    damping = 2.0 * flexible.damping * np.sqrt(mass * stiffness)
    return Modes(name, flexible, nodes, M, shapes, *(_rounded_each(x) for x in (mass, stiffness, damping)))


def _shapes(
    name: str, flexible: Flexible, nodes: np.ndarray, M: np.ndarray, K: np.ndarray, held: list[int]
) -> np.ndarray:
    """(6n, m) M-orthogonal shapes of largest displacement 1."""
    free = [d for d in range(len(M)) if d not in set(held)]
    M_f, K_f = M[np.ix_(free, free)], K[np.ix_(free, free)]
    nodal = flexible.nodal
    if nodal is not None and nodal.modes:
        basis = _padded(np.array(nodal.modes, float), len(nodes))[free]
    else:
        rigid = sum(_moves_freely(u, K, held) for u in _rigid(nodes).T)
        n = min(flexible.modes + rigid, len(free))
        if n - rigid < flexible.modes:
            raise KernelError(f"body '{name}': {flexible.modes} modes, but its model has only {n - rigid}")
        basis = eigh(K_f, M_f, subset_by_index=[0, n - 1])[1][:, rigid:] if n > rigid else np.zeros((len(free), 0))
        if flexible.loads:
            basis = _with_attachment_modes(flexible, basis, M_f, K_f, free)
    if basis.shape[1]:
        _, turn = eigh(basis.T @ K_f @ basis, basis.T @ M_f @ basis)
        basis = basis @ turn
    shapes = np.zeros((len(M), basis.shape[1]))
    shapes[free] = basis
    return np.stack([_normal(s) for s in shapes.T], axis=1) if basis.shape[1] else shapes


def _rounded_each(x: np.ndarray) -> np.ndarray:
    """Every element to DIGITS significant digits of its own."""
    return np.array([float(f"{e:.{DIGITS - 1}e}") for e in x])


def reduced(modes: Modes) -> Elastic:
    """The constants (5) of a body."""
    n, m = modes.shapes.shape
    B0 = _rigid(modes.nodes)
    B = np.zeros((m, n, 6))
    for k in range(m):
        B[k, :, :3] = _turning(modes.shapes[:, k])
    M_shapes = modes.M @ modes.shapes
    half = np.einsum("ia,ij,kjb->kab", B0, modes.M, B)
    second = np.einsum("kia,ij,ljb->klab", B[..., :3], modes.M, B[..., :3])
    blocks = [slice(0, 3), slice(3, 6)]
    J0, J1, G0 = B0.T @ modes.M @ B0, half + half.transpose(0, 2, 1), (B0.T @ M_shapes).T
    for a in blocks:  # moments, first moments and masses have units of their own
        G0[:, a] = _rounded(G0[:, a])
        for b in blocks:
            J0[a, b] = _rounded(J0[a, b])
    J1[:, :3, :3] = _rounded(J1[:, :3, :3])
    for k in range(m):
        J1[k, :3, 3:] = _skew(G0[k, 3:])
        J1[k, 3:, :3] = -_skew(G0[k, 3:])
    shorter = np.zeros((m, m, n))
    shorter[:, :, 0::6] = -modes.nodal_shortening.transpose(1, 2, 0)
    G1 = np.einsum("ia,ij,klj->kla", B0, modes.M, shorter)
    G1[:, :, :3] += np.einsum("kia,il->kla", B[..., :3], M_shapes)
    G1[:, :, :3], G1[:, :, 3:] = _rounded(G1[:, :, :3]), _rounded(G1[:, :, 3:])
    J2 = np.zeros((m, m, 6, 6))
    J2[:, :, :3, :3] = second + second.transpose(0, 1, 3, 2)
    for k in range(m):
        for l in range(m):
            cut = B0[:, :3].T @ modes.M @ _turning(shorter[k, l])
            J2[k, l, :3, :3] += cut + cut.T
            J2[k, l, :3, 3:], J2[k, l, 3:, :3] = _skew(G1[k, l, 3:]), -_skew(G1[k, l, 3:])
    J2[:, :, :3, :3] = _rounded(J2[:, :, :3, :3])
    return Elastic(J0, J1, J2, G0, G1, modes.mass)


def _model(flexible: Flexible) -> tuple[np.ndarray, np.ndarray, np.ndarray, list[int]]:
    """Nodes, matrices of six degrees of freedom per node, and those that do not deform."""
    if beam := flexible.beam:
        M, K = beam_matrices(beam)
        n = beam.elements + 1
        last = 6 * (n - 1)
        frame = {"clamped": [*range(6)], "simply supported": [0, 1, 2, 3, last + 1, last + 2], "free": []}
        stiff = {6 * j + d for j in range(n) for d in rigid_directions(beam)}
        return nodes_of(beam), M, K, sorted(stiff | set(frame[flexible.frame]))
    nodal = flexible.nodal
    assert nodal is not None, "checked with the description"
    nodes, n = np.array(nodal.nodes, float), len(nodal.nodes)
    per_node = len(nodal.mass) // n
    places = [6 * (d // per_node) + d % per_node for d in range(len(nodal.mass))]
    M, K = np.zeros((6 * n, 6 * n)), np.zeros((6 * n, 6 * n))
    M[np.ix_(places, places)], K[np.ix_(places, places)] = np.array(nodal.mass), np.array(nodal.stiffness)
    held = {places[d] for d in nodal.held} | (set(range(6 * n)) - set(places))
    return nodes, M, K, sorted(held)


def _moves_freely(u: np.ndarray, K: np.ndarray, held: list[int]) -> bool:
    """Whether a rigid motion of the nodes neither meets the frame nor strains anything."""
    return bool(np.any(u) and not np.any(u[held]) and np.abs(K @ u).max() <= NODE * np.abs(K).max() * np.abs(u).max())


def _padded(shapes: np.ndarray, n: int) -> np.ndarray:
    """(6n, m) from shapes over 3 or 6 degrees of freedom per node."""
    per_node, m = len(shapes) // n, shapes.shape[1]
    out = np.zeros((n, 6, m))
    out[:, :per_node] = shapes.reshape(n, per_node, m)
    return out.reshape(6 * n, m)


def _rigid(nodes: np.ndarray) -> np.ndarray:
    """(6n, 6) B_0 of equation (2)."""
    B = np.zeros((len(nodes), 6, 6))
    for j, X in enumerate(nodes):
        B[j, :3, :3] = -_skew(X)
    B[:, :3, 3:] = B[:, 3:, :3] = np.eye(3)
    return B.reshape(-1, 6)


def _turning(u: np.ndarray) -> np.ndarray:
    """(n, 3) what turning the frame adds to the velocity of displaced nodes, B_k of equation (2)."""
    B = np.zeros((len(u), 3))
    for j in range(0, len(u), 6):
        B[j : j + 3] = -_skew(u[j : j + 3])
    return B


def _skew(x: np.ndarray) -> np.ndarray:
    return np.array([[0.0, -x[2], x[1]], [x[2], 0.0, -x[0]], [-x[1], x[0], 0.0]])


def _with_attachment_modes(
    flexible: Flexible, basis: np.ndarray, M: np.ndarray, K: np.ndarray, free: list[int]
) -> np.ndarray:
    """The basis and what is new in the static deflections under unit forces at the stations `loads`."""
    beam = flexible.beam
    assert beam is not None, "checked with the description"
    directions = [d for d in (1, 2) if d not in rigid_directions(beam)]
    for x in flexible.loads:
        for d in directions:
            force = hermite(beam, x)[d][free]
            shape = np.linalg.solve(K, force)
            size = float(np.sqrt(shape @ M @ shape))
            if size == 0.0:
                continue
            shape = shape / size
            for column in (*basis.T, *basis.T):  # twice is enough (Kahan, Parlett)
                shape = shape - column * (column @ M @ shape)
            left = float(np.sqrt(max(shape @ M @ shape, 0.0)))
            if left > DEPENDENT:
                basis = np.column_stack([basis, shape / left])
    return basis


def _normal(shape: np.ndarray) -> np.ndarray:
    """The shape with a largest displacement (torsion: rotation) of 1; the first such one is positive."""
    parts = shape.reshape(-1, 6)
    moved = parts[:, :3] if np.abs(parts[:, :3]).max() > DEPENDENT * np.abs(parts[:, 3:]).max() else parts[:, 3:]
    flat = moved.ravel()
    largest = flat[int(np.argmax(np.abs(flat) > (1.0 - NODE) * np.abs(flat).max()))]
    return np.asarray(shape / largest)
