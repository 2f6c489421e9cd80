"""Modes of a flexible body from its finite-element model: eigenmodes, attachment modes or given ones, and their shapes
at the stations where something is attached.

Eigenmodes solve K u = w^2 M u under the boundary conditions of the floating frame; attachment modes add the static
deflections under unit forces (Craig 2000; Shabana 2013, chapter 6), so that few modes carry concentrated loads.
They are M-orthogonal and of largest displacement 1.  Along a beam, elements interpolate with Hermite polynomials; for
what slides, Chebyshev polynomials follow them smoothly.
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
from .buckling import Column
from .description import Beam, Flexible
from .numbers import rigid_motions, rounded, rounded_each
from .small_deflections import Smallness, smallness

__all__ = ["Modes", "modes_of"]

DEPENDENT = 1e-8  # what is left of a shape that is a sum of the others
SMOOTH, NOT_SMOOTH = 1e-6, 1e-2  # errors of polynomials along a beam, sought and refused; shapes are 1 at most
HARDLY = 0.005  # of a mode's stiffness: so small a part of the buckling load is not looked at
NODE = 1e-6  # [m] how far an attached point may be off its node by rounding


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
            return rounded(hermite(beam, float(station)) @ self.shapes)
        return rounded(self.shapes[6 * int(station) : 6 * int(station) + 6])

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
        coefficients = rounded(np.concatenate([fit, -slopes[:, 2:3], slopes[:, 1:2]], axis=1))
        g = np.zeros((2 * len(coefficients), m, m))
        for k, l, d in np.ndindex(m, m, 2):
            product = chebyshev.chebmul(coefficients[:, 4 + d, k], coefficients[:, 4 + d, l])
            integral = chebyshev.chebint(product, lbnd=-1.0) * (beam.length / 2.0)
            g[: len(integral), k, l] += integral
        g[0] += self.shortening(0.0)
        return Track(np.zeros(3), 2.0 / beam.length, coefficients, rounded(g))

    def shortening(self, station: int | float) -> np.ndarray:
        """(m, m) g of equation (9) in `attachment` at a station: integrals of products of slopes [1/m]; 0 if no beam.

        From the root on, where that holds the frame; the mean along the beam vanishes where nothing does.
        """
        beam, m = self.flexible.beam, len(self.mass)
        if beam is None:
            return np.zeros((m, m))
        h = beam.length / beam.elements
        e = min(int(float(station) / h), beam.elements - 1)
        return rounded(self.nodal_shortening[e] + self._product(beam, e * h, float(station)))

    @cached_property
    def smallness(self) -> Smallness:
        """How far it may be bent."""
        return smallness(self)

    def hardly_compressed(self, forces: np.ndarray, a: np.ndarray, w: np.ndarray) -> bool:
        """Whether that is seen without `column`, which costs some linear algebra; arguments as of `Column.part`."""
        beam = self.flexible.beam
        if beam is None:
            return False
        size = np.abs(forces[:, 0]).sum() + beam.mass_per_length * beam.length * (abs(a[0]) + beam.length * (w @ w))
        return bool(size * self._softness < HARDLY)

    @cached_property
    def _softness(self) -> float:
        """What a newton along it takes of the stiffness of a mode at most [1/N]."""
        own = np.einsum("nkk->nk", self.nodal_shortening)
        return float((np.abs(own).max(axis=0) / self.stiffness).max())

    @cached_property
    def column(self) -> Column:
        """What its axial loads are to it."""
        _, _, K, held = _model(self.flexible)
        return Column(self, K, held)

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
    return Modes(name, flexible, nodes, M, shapes, *(rounded_each(x) for x in (mass, stiffness, damping)))


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
        rigid = sum(_moves_freely(u, K, held) for u in rigid_motions(nodes).T)
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
