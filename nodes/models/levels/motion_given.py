"""Vessels whose motion is given: each follows its own linear response to the waves, and no load acts back on it.

The response x solves (-w^2 (M + A) + i w B + K) x = X at each frequency w of the wave loads X. M is the mass of the
vessel with the bodies that joints carry on it and those that stand on it at the start, all as one rigid body; A and B
are added mass and damping, for two hulls near each other those of both; K holds hydrostatics, and the stiffness of
mooring lines and springs at the start. Left out are the transient, drift, and the mean heel and offset.
"""

from collections.abc import Sequence
from dataclasses import replace
from functools import lru_cache
from math import sqrt
from typing import TypeAlias

import msgspec
from heavylift.kernel.algebra.dense import cross, dot, product, solve
from heavylift.kernel.description.forces import Bushing, Load, MooringLine, Radiation, Spring, Wave, WaveSum
from heavylift.kernel.description.mechanics import WORLD, Point, Vector, merge
from heavylift.kernel.forces.catenary import line_shape
from heavylift.nodes.plan.fidelity import Fidelity, attitude
from heavylift.nodes.plan.mechanism import Mechanism
from heavylift.nodes.plan.plan import Plan
from heavylift.nodes.plan.shapes import HULL
from heavylift.nodes.sea.hydrodynamics import FINE
from heavylift.nodes.sea.prescribed import MODES, carried, one_wave

from .water import Rows, harmonics, radiated

STEP = 1e-3  # [m, rad]: displacements in central differences of the pull of lines
UNITS = tuple(tuple(1.0 if i == j else 0.0 for j in range(6)) for i in range(6))
Loads: TypeAlias = dict[float, list[float]]  # frequency [rad/s] -> real parts in all modes, then imaginary parts


def rides(machine: Mechanism) -> bool:
    """Return whether a machine is a vessel that floats freely in waves."""
    joints, hull = machine.system.joints, any(x.part == HULL for x in machine.shapes)
    free = len(joints) == 1 and joints[0].kind == "free" and joints[0].parent == WORLD
    return hull and free and any(True for f in machine.system.forces for _ in _waves_of(f))


def motion_given(machine: Mechanism, fidelity: Fidelity, plan: Plan) -> Mechanism:
    """Return a vessel on six joints that follow its own response to the waves, if the model level requires it."""
    if fidelity.water != "motion given" or not rides(machine):
        return machine
    (body,), (joint,) = machine.system.bodies, machine.system.joints
    light, (x, y, z) = replace(body, added=None, shared=None), joint.q0[:3]
    motions = dict(zip(MODES, _Vessels(machine, plan).motions(), strict=True))
    system = carried(light, (x, y, z), attitude(joint.q0[3:]), motions, plan.gravity)
    return msgspec.structs.replace(machine, system=system)


class _Vessels:
    """A vessel and, if they exchange waves, the hull beside it: the matrices of both, in the axes of each at rest."""

    def __init__(self, machine: Mechanism, plan: Plan) -> None:
        from heavylift.kernel.model.program import Program  # slow to import

        self.whole = merge([x.system for x in plan.machines], plan.gravity)
        pairs = [(f.at.body, f.beside.body) for f in self.whole.forces if isinstance(f, Radiation) and f.beside]
        self.names = next((x for x in pairs if machine.name in x), (machine.name,))
        self.machines = [next(x for x in plan.machines if x.name == name) for name in self.names]
        self.own, self.closed = self.names.index(machine.name), {name for x in plan.machines for name in x.closed}
        poses, self.poses = Program(self.whole).poses_at_start, dict[str, tuple[list[list[float]], list[float]]]()
        for name in (WORLD, *(body.name for body in self.whole.bodies)):
            R, p = poses(name)
            self.poses[name] = R.astype(float).tolist(), p.astype(float).tolist()

    def motions(self) -> list[Wave | WaveSum]:
        """Return the motions [m, rad] of the vessel in its six modes, computed from its wave loads."""
        n = 6 * len(self.names)
        M, D, K = ([[0.0] * n for _ in range(n)] for _ in range(3))
        loads, waters = Loads(), list[tuple[Rows, Rows]]()
        for i, machine in enumerate(self.machines):
            (body,), at = machine.system.bodies, 6 * i
            on = self._on(body.name)
            _add(M, self._mass(body.name, on), at, at)
            _add(M, body.added or (), at, at)
            _add(K, self._lines(body.name, on), at, at)
            if body.shared:
                other = 6 * self.names.index(body.shared.beside)
                _add(M, body.shared.added, at, other)
                _add(M, tuple(zip(*body.shared.added, strict=True)), other, at)
            for f in machine.system.forces:
                if isinstance(f, Bushing):
                    _add(D, f.D, at, at)
                    _add(K, f.K, at, at)
                elif isinstance(f, Radiation):
                    both = zip(f.G, f.G_beside, strict=True) if f.beside else ((row,) for row in f.G)
                    waters.append((f.F, tuple(tuple(x for row in rows for x in row) for rows in both)))
                for w, c, s in _waves_of(f):
                    assert isinstance(f, Load)
                    x = loads.setdefault(w, [0.0] * (2 * n))
                    for k, g in enumerate([*self._turned(body.name, f.force), *self._turned(body.name, f.moment)]):
                        x[at + k] += c * g
                        x[n + at + k] -= s * g
        given = tuple((w, tuple(x)) for w, x in loads.items())
        found = _responses(*(tuple(map(tuple, X)) for X in (M, D, K)), tuple(waters), given)
        signal = next(
            f.signal for f in self.machines[self.own].system.forces if isinstance(f, Load) and [*_waves_of(f)]
        )
        wave = signal.waves or signal.wave
        assert wave
        parts = [([x[k] for x in found], [-x[n + k] for x in found]) for k in range(6 * self.own, 6 * self.own + 6)]
        if len(found) == 1:
            return [one_wave(given[0][0], c, s, wave.ramp) for (c,), (s,) in parts]
        frequencies = tuple(loads)
        piece = FINE / max(frequencies)
        return [WaveSum(frequencies, tuple(c), tuple(s), wave.ramp, piece) for c, s in parts]

    def _on(self, name: str) -> set[str]:
        """Return the names of a vessel and of all bodies that joints carry on it or that stand on it at the start."""
        on, more = {name}, True
        while more:
            found = {j.child for j in self.whole.joints if j.parent in on}
            found |= {s.point.body for s in self.whole.supports if s.on in on and s.name in self.closed}
            more, on = not found <= on, on | found
        return on

    def _turned(self, vessel: str, x: Sequence[float]) -> list[float]:
        """Return a vector of the world in the axes of a vessel."""
        return product([list(column) for column in zip(*self.poses[vessel][0], strict=True)], x)

    def _place(self, vessel: str, point: Point) -> list[float]:
        """Return the place of a point in the frame of a vessel at the start."""
        R, p = self.poses[point.body]
        origin = self.poses[vessel][1]
        return self._turned(vessel, [a + b - c for a, b, c in zip(product(R, point.p), p, origin, strict=True)])

    def _mass(self, vessel: str, on: set[str]) -> Rows:
        """Return the mass matrix (6, 6) about the origin of a vessel of all bodies on it, each column the momentum of a
        unit twist."""
        M = [[0.0] * 6 for _ in range(6)]
        for body in (body for body in self.whole.bodies if body.name in on):
            c, axes = self._place(vessel, Point(body.name, body.com)), self.poses[body.name][0]
            R = list(zip(*(self._turned(vessel, column) for column in zip(*axes, strict=True)), strict=True))
            for k, twist in enumerate(UNITS):
                v, w = twist[:3], twist[3:]
                P = [body.mass * (a + b) for a, b in zip(v, cross(w, c), strict=True)]
                spin = product(R, product(body.inertia, product(list(zip(*R, strict=True)), w)))
                for i, x in enumerate((*P, *(a + b for a, b in zip(cross(c, P), spin, strict=True)))):
                    M[i][k] += x
        return tuple(map(tuple, M))

    def _lines(self, vessel: str, on: set[str]) -> Rows:
        """Return the stiffness (6, 6) of all mooring lines and springs from a vessel to what does not stand on it."""
        K = [[0.0] * 6 for _ in range(6)]
        for f in (f for f in self.whole.forces if isinstance(f, MooringLine | Spring)):
            if (f.a.body in on) == (f.b.body in on) or not getattr(f, "hooked", True):
                continue
            a, b = self._place(vessel, f.a), self._place(vessel, f.b)
            for k, twist in enumerate(UNITS):
                ends = []
                for step in (STEP, -STEP):
                    end, other = (b, a) if f.b.body in on else (a, b)
                    moved = [x + step * (v + u) for x, v, u in zip(end, twist[:3], cross(twist[3:], end), strict=True)]
                    arm = [x - step * v for x, v in zip(moved, twist[:3], strict=True)]
                    force = self._pull(f, other, moved) if end is b else self._pull(f, moved, other, first=True)
                    ends.append((*force, *cross(arm, force)))
                for i, (x, y) in enumerate(zip(*ends, strict=True)):
                    K[i][k] -= (x - y) / (2.0 * STEP)
        return tuple(map(tuple, K))

    def _pull(self, f: MooringLine | Spring, a: Sequence[float], b: Sequence[float], *, first: bool = False) -> Vector:
        """Return the force [N] of a line on its second end b, or on its first end a."""
        x, y, z = (p - q for p, q in zip(b, a, strict=True))
        if isinstance(f, Spring):
            length = sqrt(dot((x, y, z), (x, y, z)))
            size = (1.0 if first else -1.0) * f.k * (1.0 - f.rest / length)
            return size * x, size * y, size * z
        weight, far = f.mass * self.whole.gravity * f.length, sqrt(x * x + y * y)
        end = line_shape(far / f.length, z / f.length, 0.5 * weight / f.EA, f.seabed, 1)[0]
        size = (1.0 if first else -1.0) * weight * float(end.H) / far
        return size * x, size * y, weight * (float(end.V) - 1.0) if first else -weight * float(end.V)


def _waves_of(f: object) -> list[tuple[float, float, float]]:
    """Return the harmonics of a wave load: frequency, amplitudes of cosine and sine."""
    return [*harmonics(f.signal)] if isinstance(f, Load) else []


def _add(to: list[list[float]], A: Rows, row: int, column: int) -> None:
    for i, given in enumerate(A):
        for j, x in enumerate(given):
            to[row + i][column + j] += x


@lru_cache(maxsize=8)
def _responses(
    M: Rows, D: Rows, K: Rows, waters: tuple[tuple[Rows, Rows], ...], loads: tuple[tuple[float, tuple[float, ...]], ...]
) -> list[list[float]]:
    """Return the response at each frequency of the loads, real parts in all modes before imaginary parts."""
    found, n = [], range(len(M))
    for w, load in loads:
        water = [radiated(F, G, w) for F, G in waters]
        real = [[K[i][j] - w * w * (M[i][j] + sum(A[i][j] for A, _ in water)) for j in n] for i in n]
        imaginary = [[w * (D[i][j] + sum(B[i][j] for _, B in water)) for j in n] for i in n]
        top = [[*a, *(-x for x in b)] for a, b in zip(real, imaginary, strict=True)]
        found.append(solve([*top, *([*b, *a] for a, b in zip(real, imaginary, strict=True))], load))
    return found
