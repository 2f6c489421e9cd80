"""Radiation of waves by floating bodies without memory: added mass and damping at one frequency.

The frequency is the mean of those of the wave loads on the body, weighted by the squares of their amplitudes in each
mode. In a regular wave nothing but the transient is lost.
"""

from collections.abc import Iterator
from dataclasses import replace
from functools import lru_cache
from typing import TypeAlias

import msgspec
from heavylift.kernel.algebra.dense import dot, product, solutions
from heavylift.kernel.algebra.elementary import cos, sin
from heavylift.kernel.description.forces import Bushing, InputSignal, Load, Matrix6, Radiation
from heavylift.kernel.description.mechanics import WORLD, Body, Point
from heavylift.nodes.plan.fidelity import Fidelity
from heavylift.nodes.plan.mechanism import Mechanism

Rows: TypeAlias = tuple[tuple[float, ...], ...]
NONE: Matrix6 = ((0.0,) * 6,) * 6


def radiating(machine: Mechanism) -> dict[str, tuple[Radiation, float]]:
    """Return the radiation force model of each single floating body in waves, with the mean wave frequency [rad/s]."""
    forces = [f for f in machine.system.forces if isinstance(f, Radiation) and not f.beside]
    found = {f.at.body: (f, _mean(machine, f.at.body)) for f in forces}
    return {body: x for body, x in found.items() if x[1]}


def without_memory(machine: Mechanism, fidelity: Fidelity) -> Mechanism:
    """Return the machine with its hulls' added mass and damping at one frequency, if the model level requires it."""
    found = radiating(machine) if fidelity.water == "one frequency" else {}
    if not found:
        return machine
    system, bodies, forces = machine.system, list(machine.system.bodies), list(machine.system.forces)
    for body, (f, w) in found.items():
        added, damping = at_frequency(f, w)
        bodies = [_heavier(x, added) if x.name == body else x for x in bodies]
        forces = [Bushing(f.name, Point(WORLD), f.at, NONE, damping, f.R) if x is f else x for x in forces]
    return msgspec.structs.replace(machine, system=replace(system, bodies=tuple(bodies), forces=tuple(forces)))


def at_frequency(f: Radiation, w: float) -> tuple[Matrix6, Matrix6]:
    """Return the added mass (beyond that at infinite frequency) and the radiation damping at a frequency w [rad/s],
    made symmetric."""
    A, B = (tuple(tuple(0.5 * (X[i][j] + X[j][i]) for j in range(6)) for i in range(6)) for X in radiated(f.F, f.G, w))
    return A, B  # type: ignore[return-value]


def radiated(F: Rows, G: Rows, w: float) -> tuple[list[list[float]], list[list[float]]]:
    """Return added mass and damping at a frequency w [rad/s] of a radiation model with the matrices F and G.

    These are -G^T Y and -G^T F Y, with (F^2 + w^2) Y = G."""
    squares = [[x + (w * w if i == j else 0.0) for j, x in enumerate(row)] for i, row in enumerate(_squared(F))]
    modes, each = list(zip(*G, strict=True)), list(zip(*solutions(squares, G), strict=True))
    return [[-dot(x, y) for y in each] for x in modes], [[-dot(x, product(F, y)) for y in each] for x in modes]


@lru_cache
def _squared(F: Rows) -> Rows:
    columns = list(zip(*F, strict=True))
    return tuple(tuple(dot(row, column) for column in columns) for row in F)


def _heavier(body: Body, more: Matrix6) -> Body:
    rows = zip(body.added or NONE, more, strict=True)
    return replace(body, added=tuple(tuple(a + b for a, b in zip(*row, strict=True)) for row in rows))  # type: ignore[arg-type]


def _mean(machine: Mechanism, body: str) -> float:
    """Return the mean frequency [rad/s] of the wave loads on a body over all modes; 0 without any."""
    loads = [f for f in machine.system.forces if isinstance(f, Load) and f.at.body == body]
    means = []
    for powers in ([(w, c * c + s * s) for w, c, s in harmonics(f.signal)] for f in loads):
        whole = sum(power for _, power in powers)
        means += [sum(w * power for w, power in powers) / whole] if whole else []
    return sum(means) / len(means) if means else 0.0


def harmonics(x: InputSignal) -> Iterator[tuple[float, float, float]]:
    """Yield frequency w and amplitudes of cos(w t) and sin(w t) of each harmonic of a signal, but not of products of
    two harmonics."""
    if x.wave and x.wave.frequency:
        size, phase = x.wave.amplitude, x.wave.phase
        yield x.wave.frequency, size * float(cos(phase)), -size * float(sin(phase))
    if x.waves and not any(x.waves.by):
        yield from zip(x.waves.frequencies, x.waves.cosines, x.waves.sines, strict=True)
