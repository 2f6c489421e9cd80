"""Limits of small-deflection theory: bending and twist of a flexible body as shares of the limit.

The deformation is measured from the floating frame.  Its displacement u and its rotation theta at a place count as
    |u| / (WARNED L)   and   |theta| / (TURNED WARNED),                                                           (13)
L being the length of a beam, or the largest distance of two nodes.  The ends of a simply supported beam that sags by
WARNED of its length turn by 3 to TURNED times that, those of a cantilever by 1.5 to 2 times.  At WARNED the linear
deflection of a cantilever is 0.3 % too large, at REFUSED 7 % (Bisshopp, Drucker 1945, Large deflection of cantilever
beams), and the rotation of a frame at its end is too small by as much.
"""

from dataclasses import dataclass
from math import degrees, sqrt
from typing import Any, Protocol

import numpy as np
from heavylift.kernel.algebra.arrays import sizes
from heavylift.kernel.compiler.symbol import Array, Scalar, maximum
from heavylift.kernel.description.flexible import WARNED, Flexible

from .beam import rounded

TURNED = 4.5  # rad, for each part of the length
PLACES = 8  # parts into which a beam is divided for this
BEFORE, NEVER = 4, -1.0  # numbers in P before the rows; a time at which nothing began
TIES = 1e-6  # part of the largest displacement by which nodes may differ that move alike


@dataclass(frozen=True)
class Smallness:
    """Limits up to which the deflection of a flexible body counts as small, equation (13) of the module."""

    rows: np.ndarray  # (n, m) linear in the mode coordinates
    groups: tuple[int, ...]  # number of rows for each place and kind
    turns: tuple[bool, ...]  # whether a group is a rotation

    @property
    def numbers(self) -> list[float]:
        """The parameters of a body's deflection check, as stored in the parameter block P.

        The square of the limit that applies now, whether a note about compression was added, the times since which the
        body has been near buckling and beyond it, and the rows.
        """
        return [1.0, 0.0, NEVER, NEVER, *self.rows.ravel().tolist()]

    def use(self, eta: Array, rows: Array) -> list[Scalar]:
        """Return the squared utilisation of each deflection limit of the body, for mode coordinates eta (m,)."""
        out, first = [], 0
        for n in self.groups:
            parts = [row @ eta for row in rows[first : first + n]]
            out.append(sum(x * x for x in parts))
            first += n
        return out

    def guard(self, p: Array, eta: Array) -> Any:
        """Return the guard of the deflection limit: negative once a deflection exceeds the limit that applies now."""
        largest: Scalar = 0.0
        for x in self.use(eta, np.reshape(p[BEFORE:], self.rows.shape)):
            largest = maximum(largest, x)
        return p[0] - largest

    def largest(self, eta: np.ndarray) -> tuple[float, bool]:
        """Return the largest utilisation of a deflection limit of the body, and whether a rotation causes it."""
        use = self.use(eta.astype(object), self.rows)  # floats of Python, whose products are summed in order
        first = max(range(len(use)), key=use.__getitem__)
        return sqrt(float(use[first])), self.turns[first]


class ModeShapes(Protocol):
    """Interface of `modes.FlexibleModes`: mode shapes (6n, m), modal masses (m,), mass matrix M (6n, 6n)."""

    @property
    def flexible(self) -> Flexible: ...
    @property
    def nodes(self) -> np.ndarray: ...
    @property
    def M(self) -> np.ndarray: ...
    @property
    def shapes(self) -> np.ndarray: ...
    @property
    def mass(self) -> np.ndarray: ...
    def at(self, station: int | float) -> np.ndarray: ...


def smallness(modes: ModeShapes) -> Smallness:
    """Return the limits for small deflections: at equal distances along a beam, else at the most displaced nodes."""
    found: list[tuple[np.ndarray | None, np.ndarray | None]] = []
    if beam := modes.flexible.beam:
        length = beam.length
        places = [beam.start + length * k / PLACES for k in range(PLACES + 1)]
        found += [(modes.at(x)[:3], modes.at(x)[3:]) for x in places]
    else:
        shapes = modes.shapes.reshape(len(modes.nodes), 6, -1)
        apart = sizes(modes.nodes[:, None] - modes.nodes[None])
        length = float(max(apart.max(), sizes(modes.nodes).max()))
        turning = shapes[:, 3:]
        if not np.any(turning) and len(apart) > 1:  # nodes of three: what a line to the next one turns or stretches
            apart[np.arange(len(apart)), np.arange(len(apart))] = np.inf
            near = [int(np.flatnonzero(row <= (1.0 + TIES) * row.min())[0]) for row in apart]
            turning = np.array([(shapes[i, :3] - shapes[j, :3]) / apart[i, j] for i, j in enumerate(near)])
        moved, turned = (sorted(_most(x)) for x in (shapes[:, :3], turning))
        found += [*((shapes[i, :3], None) for i in moved), *((None, turning[i]) for i in turned)]
    rows: list[np.ndarray] = []
    groups, turns = list[int](), list[bool]()
    for place in found:
        for part, limit, turn in zip(place, (WARNED * length, TURNED * WARNED), (False, True), strict=True):
            kept = [row / limit for row in rounded(part) if np.any(row)] if part is not None and limit > 0.0 else []
            if kept:
                rows += kept
                groups.append(len(kept))
                turns.append(turn)
    given = np.array(rows).reshape(-1, len(modes.mass))
    return Smallness(rounded(given), tuple(groups), tuple(turns))


def sentence(body: str, joint: str, t: float, turns: bool, use: float, refused: bool) -> str:
    """Return the message that a body's deflection at t [s] reaches a limit of small deflections.

    `use`: deflection as a share of the limit, equation (13) of the module.
    """
    size = use * WARNED
    turned, bent = (
        f"turns by {degrees(TURNED * size):.3g} degrees within itself",
        f"bends by {100.0 * size:.3g} % of its length",
    )
    where = f"body '{body}' on joint '{joint}' at {t:.3f} s: it {turned if turns else bent}"
    cure = "make it stiffer, relieve it, or divide it into several bodies"
    if refused:
        return f"{where}, where the theory of small deflections means nothing; {cure}"
    return (
        f"{where}, beyond what the theory of small deflections covers well; do not trust what depends on its shape, "
        f"or {cure}"
    )


def _most(parts: np.ndarray) -> set[int]:
    """Return the nodes where a mode has its largest motion; `parts`: motions (n, 3, m) of n nodes in m modes."""
    moved = sizes(parts.transpose(2, 0, 1))
    return {int(i) for size in moved if np.any(size) for i in np.flatnonzero(size > (1.0 - TIES) * size.max())}
