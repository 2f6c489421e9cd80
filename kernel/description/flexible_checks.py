"""What the description of a flexible body must fulfil before it becomes matrices."""

from __future__ import annotations

from heavylift.kernel.errors import KernelError

from .flexible import Beam, Flexible, Modal, Nodal


def check_flexible(body: str, flexible: Flexible) -> None:
    """Raises KernelError naming the body for the first thing that cannot be."""
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
    for name in ("length", "mass_per_length", "elements"):
        if not getattr(beam, name) > 0:
            return f"{name} of its beam is {getattr(beam, name):g}; it must be positive"
    for name in ("EI_y", "EI_z", "EA", "GJ", "polar"):
        if getattr(beam, name) < 0.0:
            return f"{name} of its beam is {getattr(beam, name):g}; it cannot be negative"
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
