"""Modes of a flexible body from its finite-element model: eigenmodes, attachment modes or given ones, and their shapes
at the stations where something is attached.

Eigenmodes solve K u = w^2 M u under the boundary conditions of the floating frame; attachment modes add the static
deflections under unit forces, so that few modes carry concentrated loads, as do the constraint modes of Craig-Bampton
(Craig 2000; Shabana 2013, chapter 6). They are M-orthogonal and of largest displacement 1. Along a beam, elements
interpolate with Hermite polynomials; for sliders, Chebyshev polynomials approximate them smoothly. Everything is
computed by operations on elements (`arrays`), since simulations depend on the bits: rounding cannot hide the
differences between LAPACK libraries in the low modes of a fine model.
"""

import hashlib
from dataclasses import dataclass
from functools import cached_property
from math import pi, sqrt

import numpy as np
from heavylift.kernel.algebra.arrays import eigen, factored, sizes, times, total
from heavylift.kernel.algebra.eigenvalues import eigenmodes, orthonormal
from heavylift.kernel.cache import remembered, sources
from heavylift.kernel.description.flexible import Beam, Flexible, Modal
from heavylift.kernel.errors import KernelError

from .beam import beam_matrices, hermite, moves_freely, nodes_of, rigid_directions, rigid_motions, rounded, rounded_each
from .buckling import FlexibleColumn
from .small_deflections import Smallness, smallness

DEPENDENT = 1e-8  # what is left of a shape that is a sum of the others
HARDLY = 0.005  # of a mode's stiffness: so small a part of the buckling load is not looked at
GAUSS = ((-sqrt(0.6), 5.0 / 9.0), (0.0, 8.0 / 9.0), (sqrt(0.6), 5.0 / 9.0))  # points and weights
MOST_KEPT = 32  # bodies
NODE = 1e-6  # [m] how far an attached point may be off its node by rounding


@dataclass(frozen=True, eq=False)
class FlexibleModes:
    """The modes of a flexible body: shapes over the degrees of freedom of its finite-element model, modal mass,
    stiffness and damping."""

    name: str
    flexible: Flexible
    nodes: np.ndarray  # (n, 3) [m]
    M: np.ndarray  # (6n, 6n)
    shapes: np.ndarray  # (6n, m)
    mass: np.ndarray  # (m,)
    stiffness: np.ndarray  # (m,)
    damping: np.ndarray  # (m,)

    def station(self, p: tuple[float, float, float]) -> tuple[int | float, np.ndarray]:
        """Return the station of a point (node number, or x along the beam) and its position.

        Raises KernelError for a point beyond the beam's ends or at no node.
        """
        if beam := self.flexible.beam:
            if not -NODE <= p[0] - beam.start <= beam.length + NODE:
                ends = f"{beam.start:g} and {beam.start + beam.length:g} m"
                raise KernelError(f"body '{self.name}': x = {p[0]:g} m lies beyond its ends at {ends}")
            return p[0], np.array([p[0], 0.0, 0.0])
        distance = sizes(self.nodes - np.array(p))
        node = int(np.argmin(distance))
        # modal data give motion at listed places only; all other points move with the frame
        if distance[node] > NODE and self.flexible.modal:
            return len(self.nodes) - 1, self.nodes[-1]
        if distance[node] > NODE:
            near = ", ".join(f"{x:g}" for x in self.nodes[node])
            raise KernelError(
                f"body '{self.name}': ({p[0]:g}, {p[1]:g}, {p[2]:g}) is not a node; the nearest one is ({near})"
            )
        return node, self.nodes[node]

    def at(self, station: int | float) -> np.ndarray:
        """Return displacement and rotation (6, m) of every mode at a station."""
        if beam := self.flexible.beam:
            return rounded(times(hermite(beam, float(station)), self.shapes))
        return rounded(self.shapes[6 * int(station) : 6 * int(station) + 6])

    def shortening(self, station: int | float) -> np.ndarray:
        """Return the geometric shortening by the modes at a station: integrals of slope products [1/m].

        g (m, m) of equation (9) in `attachment`; 0 for bodies other than beams. Integrals start at the root if the
        frame is held there; for a free frame their mean along the beam vanishes.
        """
        beam, m = self.flexible.beam, len(self.mass)
        if beam is None:
            return np.zeros((m, m))
        h, along = beam.length / beam.elements, float(station) - beam.start
        e = min(int(along / h), beam.elements - 1)
        return rounded(self.nodal_shortening[e] + self._product(beam, e * h, along))

    @cached_property
    def smallness(self) -> Smallness:
        """The limits up to which the body's deflections count as small."""
        return smallness(self)

    def hardly_compressed(self, forces: np.ndarray, a: np.ndarray, w: np.ndarray) -> np.ndarray:
        """Return, for n instants, whether axial loads are far below buckling; arguments as in `FlexibleColumn.part`."""
        beam = self.flexible.beam
        if beam is None:
            return np.full(len(a), self.flexible.modal is not None)
        # largest axial acceleration of any element: of the frame and centrifugal
        reach = np.abs(a[:, 0]) + (beam.length + abs(beam.start)) * total((w * w).T)
        size = total(np.abs(forces[:, :, 0]).T) + beam.mass_per_length * beam.length * reach
        return np.asarray(size * self._softness < HARDLY)

    @cached_property
    def _softness(self) -> float:
        """The largest loss of modal stiffness per axial force [1/N]."""
        own = self.nodal_shortening.diagonal(axis1=1, axis2=2)
        return float((np.abs(own).max(axis=0) / self.stiffness).max())

    @cached_property
    def column(self) -> FlexibleColumn:
        """The model of this flexible body as a column that can buckle under axial loads."""
        return FlexibleColumn(self, *_model(self.flexible)[2:])

    @cached_property
    def nodal_shortening(self) -> np.ndarray:
        """The geometric shortening by the modes at all nodes: integrals of slope products (n, m, m) [1/m]."""
        beam, none = self.flexible.beam, np.zeros((len(self.mass),) * 2)
        if beam is None:
            return np.array([none] * len(self.nodes))
        kept = remembered(f"{_key(self.flexible)}.shortening", bytes, lambda: self._shortened(beam).tobytes())
        return np.frombuffer(kept).reshape(len(self.nodes), *none.shape)

    def _shortened(self, beam: Beam) -> np.ndarray:
        h, none = beam.length / beam.elements, np.zeros((len(self.mass),) * 2)
        g = np.cumsum([none, *(self._product(beam, e * h, (e + 1) * h) for e in range(beam.elements))], axis=0)
        # with a free frame the shortening is relative to the mean position of the beam
        return g - total(g) / len(g) if self.flexible.frame == "free" else g

    def _product(self, beam: Beam, a: float, b: float) -> np.ndarray:
        """Return the integral (m, m) of slope products over an element's first part; degree 4, exact with 3 points."""
        out = np.zeros((len(self.mass),) * 2)
        # slope products are of degree 4 in an element: three Gauss points integrate degree 5 exactly
        for x, weight in GAUSS:
            slopes = times(hermite(beam, beam.start + (a + b + (b - a) * x) / 2.0)[4:], self.shapes)
            out += weight * (b - a) / 2.0 * times(slopes.T, slopes)
        return out


_last: dict[tuple[str, str], FlexibleModes] = {}  # by what was asked for, the oldest first


def _key(flexible: Flexible) -> str:
    """Return the name under which data of such a body are cached."""
    return hashlib.sha256(sources() + repr(flexible).encode()).hexdigest()


def modes_of(name: str, flexible: Flexible) -> FlexibleModes:
    """Return the eigenmodes (lowest first) and attachment modes of a body, or its given modes; cached for recent
    bodies.

    Raises KernelError if the model has too few modes, or if something can move without mass or without stiffness.
    """
    key = name, repr(flexible)
    found = _last.pop(key, None) or _modes_of(name, flexible)
    _last[key] = found
    for old in list(_last)[: max(0, len(_last) - MOST_KEPT)]:
        _last.pop(old, None)
    return found


def _modes_of(name: str, flexible: Flexible) -> FlexibleModes:
    if flexible.modal:
        return _given(name, flexible, flexible.modal)
    nodes, M, K, held = _model(flexible)
    kept = remembered(f"{_key(flexible)}.modes", bytes, lambda: _shapes(name, flexible, nodes, M, K, held).tobytes())
    shapes = np.frombuffer(kept).reshape(len(M), -1)
    mass, stiffness = (total(shapes * times(A, shapes)) for A in (M, K))
    for k, x in enumerate(stiffness):
        if not x > NODE * stiffness.max():
            raise _loose(name, k + 1)
    if flexible.start and len(flexible.start) != len(mass):
        raise KernelError(
            f"body '{name}': {len(flexible.start)} start coordinates are given for {len(mass)} modes; give one each"
        )
    damping = 2.0 * flexible.damping * np.sqrt(mass * stiffness)
    return FlexibleModes(name, flexible, nodes, M, shapes, *(rounded_each(x) for x in (mass, stiffness, damping)))


def _shapes(
    name: str, flexible: Flexible, nodes: np.ndarray, M: np.ndarray, K: np.ndarray, held: list[int]
) -> np.ndarray:
    """Return M-orthogonal shapes (6n, m) with largest displacement 1."""
    free = [d for d in range(len(M)) if d not in set(held)]
    M_f, K_f = M[np.ix_(free, free)], K[np.ix_(free, free)]
    nodal = flexible.nodal
    massless = KernelError(
        f"body '{name}': its mass matrix must be positive definite wherever the frame does not hold it"
    )
    if nodal is not None and nodal.modes:
        basis = _padded(np.array(nodal.modes, float), len(nodes))[free]
    else:
        try:
            factored(M_f)
        except ZeroDivisionError:
            raise massless from None
        moves = [u[free] for u in rigid_motions(nodes).T if moves_freely(u, K, held)]
        rigid = np.array(moves).reshape(len(moves), len(free)).T
        rigid = orthonormal(rigid, times(M_f, rigid))[0]
        n = len(free) - rigid.shape[1]
        if n < flexible.modes:
            raise KernelError(
                f"body '{name}': {flexible.modes} modes are requested, but its model has only {n}; request fewer"
            )
        try:
            basis = eigenmodes(M_f, K_f, flexible.modes, rigid)
        except ZeroDivisionError:
            raise _loose(name, 1) from None
        if flexible.loads:
            basis = np.column_stack([basis, _static(flexible, M_f, K_f, free, rigid)])
    given = basis.shape[1]
    basis, _ = orthonormal(basis, times(M_f, basis), DEPENDENT)
    if nodal is not None and basis.shape[1] < given:
        raise massless
    basis = times(basis, eigen(times(basis.T, times(K_f, basis)))[1])
    shapes = np.zeros((len(M), basis.shape[1]))
    shapes[free] = basis
    return np.stack([_normal(s) for s in shapes.T], axis=1) if basis.shape[1] else shapes


def _model(flexible: Flexible) -> tuple[np.ndarray, np.ndarray, np.ndarray, list[int]]:
    """Return nodes, matrices with six degrees of freedom per node, and the fixed degrees of freedom."""
    if beam := flexible.beam:
        M, K = beam_matrices(beam)
        last = 6 * beam.elements
        frame = {"clamped": [*range(6)], "simply supported": [0, 1, 2, 3, last + 1, last + 2], "free": []}
        stiff = {6 * j + d for j in range(beam.elements + 1) for d in rigid_directions(beam)}
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


def _padded(shapes: np.ndarray, n: int) -> np.ndarray:
    """Return shapes (6n, m) from shapes over 3 or 6 degrees of freedom per node."""
    per_node, m = len(shapes) // n, shapes.shape[1]
    out = np.zeros((n, 6, m))
    out[:, :per_node] = shapes.reshape(n, per_node, m)
    return out.reshape(6 * n, m)


def _given(name: str, flexible: Flexible, modal: Modal) -> FlexibleModes:
    """Return tabulated modes with largest displacement 1, at their places and at a node fixed to the frame."""
    nodes = np.array([*modal.nodes, (0.0, 0.0, 0.0)])
    given = np.array(modal.shapes, float).reshape(len(modal.shapes), -1).T
    scale = np.abs(given).max(axis=0, initial=0.0)
    shapes = _padded(np.concatenate([given / scale, np.zeros((3, len(scale)))]), len(nodes))
    omega, mass = 2.0 * pi * np.array(modal.frequency), np.array(modal.mass) / (scale * scale)
    damping = 2.0 * np.array(modal.damping) * mass * omega
    numbers = (rounded_each(x) for x in (mass, mass * omega * omega, damping))
    return FlexibleModes(name, flexible, nodes, np.zeros((6 * len(nodes),) * 2), shapes, *numbers)


def _static(flexible: Flexible, M: np.ndarray, K: np.ndarray, free: list[int], rigid: np.ndarray) -> np.ndarray:
    """Return static deflections (n, m) under unit forces at the stations `loads`; for a free body with rigid motions
    (n, r), without inertia forces."""
    beam = flexible.beam
    assert beam is not None, "checked with the description"
    directions = [d for d in (1, 2) if d not in rigid_directions(beam)]
    given = [hermite(beam, x)[d][free] for x in flexible.loads for d in directions]
    forces = np.array(given).reshape(len(given), len(free)).T
    if rigid.shape[1]:
        W, far = times(M, rigid), max(float(K[k, k] / M[k, k]) for k in range(len(K)))
        K, forces = K + far * times(W, W.T), forces - times(W, times(rigid.T, forces))
    return factored(K).solve(forces)


def _loose(name: str, mode: int) -> KernelError:
    return KernelError(f"body '{name}': mode {mode} has no stiffness; let the frame hold the body against it")


def _normal(shape: np.ndarray) -> np.ndarray:
    """Return a shape scaled to a largest displacement (torsion: rotation) of 1, positive at its first maximum."""
    parts = shape.reshape(-1, 6)
    moved = parts[:, :3] if np.abs(parts[:, :3]).max() > DEPENDENT * np.abs(parts[:, 3:]).max() else parts[:, 3:]
    flat = moved.ravel()
    largest = flat[int(np.argmax(np.abs(flat) > (1.0 - NODE) * np.abs(flat).max()))]
    return np.asarray(shape / largest)
