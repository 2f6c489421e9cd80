"""Buckling of flexible bodies: axial loads as a share of the loads under which a body buckles.

With the axial load N(s) and slopes w' of a basis of shapes, K + lambda integral of N w' w'^T ds is singular if the
loads, times lambda, buckle the body (Timoshenko, Gere 1961, sections 2.8 to 2.11). The basis consists of the body's
modes and the buckling modes of its whole model under one axial load, so that the result does not depend on the number
of modes. The body is held by its floating frame only. A body given by matrices is treated as a line between its
farthest nodes, each section of which moves as the mean of its nodes; its own equations of motion do not include
compression.
"""

from contextlib import suppress

import numpy as np
from heavylift.kernel.algebra.arrays import eigen, sizes, times, total
from heavylift.kernel.algebra.eigenvalues import largest
from heavylift.kernel.description.flexible import Beam

from .beam import BENDING_Y, BENDING_Z, rounded
from .small_deflections import ModeShapes

SHAPES = 8  # buckling modes, those of both planes
SLIGHT = 0.02  # of the buckling load: less is not looked at
MOST = 1e3  # of the buckling load: more is reported as that
HALVINGS = 30  # of the bracket around the part of the buckling load
DEPENDENT = 1e-10  # part of the largest stiffness below which a shape of the basis is none
SAME = 1e-9  # part of the length between nodes of one section


class FlexibleColumn:
    """A flexible body as a column under axial loads, which can buckle.

    `softens`: whether its equations of motion include the effect of these loads.
    """

    def __init__(self, modes: ModeShapes, K: np.ndarray, held: list[int]) -> None:
        self.softens = modes.flexible.beam is not None
        nodes = modes.nodes
        self.axis, sections = (np.array([1.0, 0.0, 0.0]), [[j] for j in range(len(nodes))])
        if not self.softens:
            self.axis, sections = _line(nodes)
        along = times(nodes, self.axis)
        self._at = np.array([float(total(along[x])) / len(x) for x in sections])
        pieces = (
            _elements(modes.flexible.beam) if modes.flexible.beam else _between_sections(sections, self._at, self.axis)
        )
        G = np.zeros_like(K)
        for at, g in pieces:
            G[np.ix_(at, at)] += g
        basis = _basis(modes, K, held, G)
        root = float(self._at[0]) if self.softens else _root(modes, along)
        products = [np.zeros((basis.shape[1],) * 2), *(times(basis[at].T, times(g, basis[at])) for at, g in pieces)]
        whole = np.cumsum(products, axis=0)
        self._whole = rounded(whole - _between(self._at, whole, root))
        moved = times(modes.M, np.array([*self.axis, 0.0, 0.0, 0.0] * len(nodes))).reshape(-1, 6)[:, :3]
        mass = np.array([float(total(times(moved[x], self.axis))) for x in sections])
        self._weighed = total(mass[:, None, None] * self._whole)
        self._spun = total((mass * self._at)[:, None, None] * self._whole)
        self._quick = float(total(np.abs(self._whole).transpose(2, 0, 1)).max(initial=0.0))
        self._mass, self._far = float(total(mass)), float(np.abs(self._at).max())

    def part(self, forces: np.ndarray, places: np.ndarray, a: np.ndarray, w: np.ndarray) -> float:
        """Return the axial load of the body divided by its buckling load; 0 for a quotient below the constant SLIGHT.

        Under forces (n, 3) at places (n, 3), acceleration a of the frame less gravity, and angular velocity w, in the
        frame's axes.
        """
        pulls, around = times(forces, self.axis), float(total(w * self.axis))
        pushed, spin = float(total(a * self.axis)), float(total(w * w)) - around * around
        size = float(total(np.abs(pulls))) + self._mass * (abs(pushed) + spin * self._far)
        if size * self._quick < SLIGHT:
            return 0.0
        G = spin * self._spun - pushed * self._weighed
        for s, f in zip(times(places, self.axis), pulls, strict=True):
            G = G + f * _between(self._at, self._whole, float(s))
        if _definite(G / SLIGHT):
            return 0.0
        low, high = 1.0 / MOST, 1.0 / SLIGHT
        for _ in range(HALVINGS):
            middle = 0.5 * (low + high)
            low, high = (middle, high) if _definite(middle * G) else (low, middle)
        return 1.0 / low


def _between(at: np.ndarray, values: np.ndarray, s: float) -> np.ndarray:
    """Interpolate values (n, m, m) at s linearly between the places `at`."""
    i = int(np.clip(np.searchsorted(at, s, side="right") - 1, 0, max(len(at) - 2, 0)))
    if len(at) < 2:
        return np.asarray(values[0])
    x = min(max((s - at[i]) / (at[i + 1] - at[i]), 0.0), 1.0)
    return np.asarray((1.0 - x) * values[i] + x * values[i + 1])


def _definite(G: np.ndarray) -> bool:
    """Return whether 1 + G is positive definite, by L D L^T pivots of floats."""
    A = (np.eye(len(G)) + G).tolist()
    for k, row in enumerate(A):
        if not row[k] > 0.0:
            return False
        for i in range(k + 1, len(A)):
            part = A[i][k] / row[k]
            for j in range(i, len(A)):
                A[i][j] -= part * row[j]
                A[j][i] = A[i][j]
    return True


def _basis(modes: ModeShapes, K: np.ndarray, held: list[int], G: np.ndarray) -> np.ndarray:
    """Return shapes (6n, m) with unit stiffness (K = 1): modes and buckling modes."""
    loose = set(held)
    free = [d for d in range(len(K)) if d not in loose]
    K_f, shapes = K[np.ix_(free, free)], modes.shapes[free]
    with suppress(ZeroDivisionError):  # where the frame lets it move freely
        shapes = np.column_stack([shapes, largest(G[np.ix_(free, free)], K_f, SHAPES)[1]])
    shapes = shapes / np.sqrt(total(shapes * times(K_f, shapes)))
    values, turn = eigen(times(shapes.T, times(K_f, shapes)))
    kept = values > DEPENDENT * values[-1]
    out = np.zeros((len(K), len(np.flatnonzero(kept))))
    out[free] = times(shapes, turn[:, kept] / np.sqrt(values[kept]))
    return out


def _elements(beam: Beam) -> list[tuple[list[int], np.ndarray]]:
    """Return degrees of freedom (12,) and geometric stiffness (12, 12) of each beam element under one newton [1/m]
    (Przemieniecki 1968, section 15.3): integrals of products of slopes."""
    h = beam.length / beam.elements
    own = np.array([[36.0, 3.0, -36.0, 3.0], [3.0, 4.0, -3.0, -1.0], [-36.0, -3.0, 36.0, -3.0], [3.0, -1.0, -3.0, 4.0]])
    g = np.zeros((12, 12))
    for at, sign in (BENDING_Z, BENDING_Y):
        s = np.array([1.0, sign * h, 1.0, sign * h])
        g[np.ix_(at, at)] += own * np.outer(s, s) / (30.0 * h)
    return [(list(range(6 * e, 6 * e + 12)), g) for e in range(beam.elements)]


def _line(nodes: np.ndarray) -> tuple[np.ndarray, list[list[int]]]:
    """Return the direction between the farthest nodes, and the nodes of each section across it."""
    apart = sizes(nodes[:, None] - nodes[None])
    length = float(apart.max())
    if not length > 0.0:
        return np.array([1.0, 0.0, 0.0]), [list(range(len(nodes)))]
    i, j = (int(x[0]) for x in np.nonzero(apart > (1.0 - SAME) * length))
    axis = rounded((nodes[j] - nodes[i]) / length)
    along = times(nodes, axis)
    sections: list[list[int]] = []
    for k in np.argsort(along, kind="stable"):
        if sections and along[k] - along[sections[-1][0]] <= SAME * length:
            sections[-1].append(int(k))
        else:
            sections.append([int(k)])
    return axis, sections


def _between_sections(
    sections: list[list[int]], at: np.ndarray, axis: np.ndarray
) -> list[tuple[list[int], np.ndarray]]:
    """Return degrees of freedom and geometric stiffness under one newton between sections, whose mean displacements are
    interpolated linearly."""
    across, out = np.eye(3) - np.outer(axis, axis), []
    for a, b, h in zip(sections[:-1], sections[1:], np.diff(at), strict=True):
        slope = np.concatenate([across * (sign / (len(x) * h)) for x, sign in ((a, -1.0), (b, 1.0)) for _ in x], axis=1)
        out.append(([6 * j + d for j in (*a, *b) for d in range(3)], float(h) * times(slope.T, slope)))
    return out


def _root(modes: ModeShapes, along: np.ndarray) -> float:
    """Return the support point, along the axis, of a body given by matrices: that of its most constrained nodes which
    is nearest to the origin."""
    nodal = modes.flexible.nodal
    assert nodal is not None, "of matrices"
    per_node = len(nodal.mass) // len(nodal.nodes)
    held = [sum(d // per_node == j and d % per_node < 3 for d in nodal.held) for j in range(len(nodal.nodes))]
    return min((float(s) for s, n in zip(along, held, strict=True) if n == max(held)), key=abs)
