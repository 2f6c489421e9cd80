"""What makes a body flexible, as plain data: a straight beam, the matrices of any finite-element model, or modes alone.

The body's frame is the floating frame: the deformation is measured from it, and is a sum of modes.  It must stay small:
beyond WARNED of the length a run carries a note, beyond REFUSED it ends (`small_deflections`).  Tension and compression
stiffen and soften beams (no other bodies).  Without NumPy, as all descriptions.  SI units; the mode
coordinates are displacements in m (rad for torsion) where a mode is largest.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

WARNED, REFUSED = 0.05, 0.25  # deflections, parts of the length

Vector = tuple[float, float, float]


@dataclass(frozen=True)
class Beam:
    """A uniform Euler-Bernoulli beam along x of the body's frame, from `start` on; a stiffness of 0 means rigid."""

    length: float  # [m]
    mass_per_length: float  # [kg/m]
    EI_y: float = 0.0  # bending about y, displacements along z [N m2]
    EI_z: float = 0.0  # bending about z, displacements along y [N m2]
    EA: float = 0.0  # [N]
    GJ: float = 0.0  # [N m2]
    polar: float = 0.0  # moment of inertia about x per length [kg m]
    elements: int = 32
    start: float = 0.0  # x of its first end [m]


@dataclass(frozen=True)
class Nodal:
    """Matrices of a finite-element model whose nodes have 3 (ux uy uz) or 6 (and rx ry rz) degrees of freedom.

    `held`: degrees of freedom that the floating frame holds.  `modes`: shapes (columns) to be taken instead of the
    eigenmodes.  A frame attached to a node of 3 keeps the direction of the floating frame.
    """

    nodes: tuple[Vector, ...]  # places in the body's frame [m]
    mass: tuple[tuple[float, ...], ...]
    stiffness: tuple[tuple[float, ...], ...]
    held: tuple[int, ...] = ()
    modes: tuple[tuple[float, ...], ...] = ()


@dataclass(frozen=True)
class Modal:
    """Modes of a free body as measured or computed elsewhere: displacements at places, frequencies, modal masses.

    All mass sits in the body's frame, from which the modes take none: they are those of a body that nothing holds.  A
    point of the body that is none of the places moves with the frame.
    """

    nodes: tuple[Vector, ...]  # places in the body's frame [m]
    shapes: tuple[tuple[Vector, ...], ...]  # of each mode: displacement at each place, of any scale
    frequency: tuple[float, ...]  # [Hz]
    mass: tuple[float, ...]  # of each mode at the scale of its shape [kg]
    damping: tuple[float, ...]  # of each mode, ratio to critical


@dataclass(frozen=True)
class Gauge:
    """A place of a flexible body, in its frame [m], whose displacement within it is sampled."""

    name: str
    p: Vector


@dataclass(frozen=True)
class Flexible:
    """The elastic part of a body: one model, the frame that its deformation is measured from, and its modes.

    frame (of a beam): "clamped" moves with the cross-section at x = 0, "simply supported" passes through both ends,
    "free" is the mean frame.  `loads`: stations x [m] of a beam whose static deflections under forces along y and z
    are added to the eigenmodes (attachment modes of Craig and Bampton), so that loads there bend it exactly.
    `start`: mode coordinates at the start, if not undeformed.  `gauges`: places whose displacement is sampled.
    """

    modes: int
    beam: Beam | None = None
    nodal: Nodal | None = None
    modal: Modal | None = None
    frame: Literal["clamped", "simply supported", "free"] = "clamped"
    damping: float = 0.0  # ratio of every mode to critical damping
    loads: tuple[float, ...] = ()
    start: tuple[float, ...] = ()
    gauges: tuple[Gauge, ...] = ()
