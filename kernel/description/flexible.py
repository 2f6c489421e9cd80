"""Flexible bodies as plain data: a straight beam, the matrices of any finite-element model, or modes alone.

The body's frame is the floating frame: the deformation is measured from it, and is a sum of modes. It must stay small:
beyond the share WARNED of the length the run gets a note, beyond REFUSED it ends with an error (`small_deflections`).
Tension stiffens and compression softens beams, but no other bodies. Without NumPy, as all descriptions. SI units; the
mode coordinates are displacements in m (rad for torsion) where a mode is largest.
"""

from dataclasses import dataclass
from typing import Annotated, Literal

from heavylift.kernel.errors import KernelError
from msgspec import Meta

from . import units as u
from .units import Vector

WARNED, REFUSED = 0.05, 0.25  # deflections, parts of the length


@dataclass(frozen=True)
class Beam:
    """A uniform Euler-Bernoulli beam along the x axis of the body's frame, beginning at `start`.

    A stiffness of 0 means that the beam is rigid in this respect.
    """

    length: u.Extent
    mass_per_length: u.MassPerLength
    EI_y: u.Rigidity = 0.0  # bending about y: displacements along z
    EI_z: u.Rigidity = 0.0
    EA: u.Tension = 0.0
    GJ: u.Rigidity = 0.0
    polar: u.RotaryInertia = 0.0  # about the beam's axis, per length
    elements: Annotated[int, Meta(ge=1, le=200)] = 32
    start: float = 0.0  # x of its first end [m]


@dataclass(frozen=True)
class Nodal:
    """Mass and stiffness matrices of a finite-element model with 3 (ux uy uz) or 6 (and rx ry rz) degrees of freedom
    per node.

    `held`: degrees of freedom fixed to the floating frame. `modes`: shapes (columns) used instead of the eigenmodes. A
    frame attached to a node with 3 degrees of freedom keeps the direction of the floating frame.
    """

    nodes: tuple[Vector, ...]  # places in the body's frame [m]
    mass: tuple[tuple[float, ...], ...]
    stiffness: tuple[tuple[float, ...], ...]
    held: tuple[int, ...] = ()
    modes: tuple[tuple[float, ...], ...] = ()


@dataclass(frozen=True)
class Modal:
    """Modes of a free body from measurement or another program: displacements at places, frequencies, modal masses.

    The whole mass belongs to the rigid body, and modal masses are not subtracted from it: the modes are those of an
    unsupported body. All other points of the body move with the floating frame.
    """

    nodes: tuple[Vector, ...]  # places in the body's frame [m]
    shapes: tuple[tuple[Vector, ...], ...]  # of each mode: displacement at each place, of any scale
    frequency: tuple[float, ...]  # [Hz]
    mass: tuple[float, ...]  # of each mode at the scale of its shape [kg]
    damping: tuple[float, ...]  # of each mode, ratio to critical


@dataclass(frozen=True)
class Gauge:
    """A measuring point of a flexible body, in its frame [m], whose displacement is sampled."""

    name: str
    p: Vector


@dataclass(frozen=True)
class Flexible:
    """Elastic part of a body: model, reference frame of the deformation, modes.

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


def check_flexible(body: str, flexible: Flexible) -> None:
    """Raise KernelError, naming the body, for the first impossible property of its flexible part."""
    wrong = _wrong(flexible)
    if wrong:
        raise KernelError(f"body '{body}': {wrong}")


def _wrong(flexible: Flexible) -> str:
    beam, nodal = flexible.beam, flexible.nodal
    if sum(x is not None for x in (beam, nodal, flexible.modal)) != 1:
        return "a flexible body has either a beam or nodal matrices or modes"
    if flexible.modes < 0 or flexible.damping < 0.0:
        return f"{flexible.modes} modes of damping ratio {flexible.damping:g}; neither can be negative"
    if beam is not None:
        return _wrong_beam(beam, flexible)
    return _wrong_matrices(nodal) if nodal is not None else _wrong_modes(flexible.modal)


def _wrong_beam(beam: Beam, flexible: Flexible) -> str:
    name, message = u.wrong_sign(beam)
    if name or beam.elements <= 0:
        return f"{name or 'elements'} of its beam {message or f'is {beam.elements}; it must be positive'}"
    if beam.GJ > 0.0 and beam.polar == 0.0:
        return "its beam twists (GJ), but nothing resists that: give the moment of inertia 'polar'"
    for x in flexible.loads:
        if not 0.0 <= x - beam.start <= beam.length:
            return f"a load at {x:g} m lies beyond its ends at {beam.start:g} and {beam.start + beam.length:g} m"
    return ""


def _wrong_matrices(nodal: Nodal) -> str:
    n = len(nodal.nodes)
    size = len(nodal.mass)
    if n == 0 or size not in (3 * n, 6 * n):
        return f"a mass matrix of {size} rows for {n} nodes; there are 3 or 6 for each"
    for name, matrix in (("mass", nodal.mass), ("stiffness", nodal.stiffness)):
        if len(matrix) != size or any(len(row) != size for row in matrix):
            return f"its {name} matrix is not one of {size} rows and columns"
        largest = max(abs(x) for row in matrix for x in row)
        if any(abs(matrix[i][j] - matrix[j][i]) > 1e-9 * largest for i in range(size) for j in range(i)):
            return f"its {name} matrix is not symmetric"
    if nodal.modes and (len(nodal.modes) != size or len({len(row) for row in nodal.modes}) > 1):
        return (
            f"its modes are columns of {size} numbers, but there are {len(nodal.modes)} rows or they differ in length"
        )
    wrong = [d for d in nodal.held if not 0 <= d < size]
    return f"held degree of freedom {wrong[0]}; there are 0 to {size - 1}" if wrong else ""


def _wrong_modes(modal: Modal | None) -> str:
    assert modal is not None, "one of the three"
    n = len(modal.shapes)
    if not n == len(modal.frequency) == len(modal.mass) == len(modal.damping):
        return "each of its modes has a shape, a frequency, a mass and a damping"
    for k, shape in enumerate(modal.shapes, 1):
        if len(shape) != len(modal.nodes) or not any(x for u in shape for x in u):
            return f"mode {k} needs a displacement at each place, and one that is not zero"
    for what, values in (("frequency", modal.frequency), ("mass", modal.mass)):
        for k, x in enumerate(values, 1):
            if not x > 0.0:
                return f"the {what} of mode {k} is {x:g}; it must be positive"
    return "" if min(modal.damping, default=0.0) >= 0.0 else "a damping ratio cannot be negative"
