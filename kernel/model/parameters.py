"""Layout of the parameter block P, which holds all numbers of a scene that the machine code reads.

Masses, geometry, laws, references and discrete states are run-time numbers: between native calls the simulation writes
them, so hooking, switching and commands never compile anything.
"""

from dataclasses import dataclass

import numpy as np
from heavylift.kernel.constraints.contact.contact_points import contact_numbers
from heavylift.kernel.constraints.loop_closures import closure_numbers
from heavylift.kernel.constraints.row_structure import rigid_numbers
from heavylift.kernel.description.forces import WaveSum
from heavylift.kernel.description.mechanics import System
from heavylift.kernel.forces.ropes import led_ends, straight_drives
from heavylift.kernel.forces.table import SharedForce, signals
from heavylift.kernel.multibody.graph import Graph
from heavylift.kernel.multibody.trees import Tree

from .quantities import numbers as quantity_numbers, points
from .wave_pieces import COEFFICIENTS

PROFILE = 8  # start, x0, v0, a1, d1, cruise, a2, d2


@dataclass(frozen=True)
class ParameterLayout:
    """Positions of all parameters in the parameter block P, by kind and name; `initial` is P at the start of a run."""

    at: dict[tuple[str, str], slice]
    initial: np.ndarray  # (n,)

    @staticmethod
    def of(system: System, graph: Graph, trees: list[Tree], laws: tuple[SharedForce, ...]) -> "ParameterLayout":
        """Return the parameter layout for a system, with references at rest and thresholds disarmed."""
        at: dict[tuple[str, str], slice] = {}
        values: list[float] = []

        def put(kind: str, name: str, numbers_: list[float]) -> None:
            at[kind, name] = slice(len(values), len(values) + len(numbers_))
            values.extend(numbers_)

        put("gravity", "", [system.gravity])
        for i, tree in enumerate(trees):
            put("tree", str(i), tree.numbers)
        masters = [*system.masters, *system.measured]
        for m in system.masters:
            put("reference", m.name, [0.0, m.value] + [0.0] * (PROFILE - 2))
        starts = [(d.name, graph.q0[graph.coordinate(d.name, *d.along)[0]]) for d in system.drives]
        starts += [(r.name, r.L0) for r in system.straight_ropes]
        starts += [(x.name, x.signal.value) for x in laws if x.signal and x.signal.driven and x.law.kind != "rope"]
        for name, x0 in starts:
            put("reference", name, [0.0, x0] + [0.0] * (PROFILE - 2))
            put("follow", name, [0.0] * 3 * len(masters))
        for link in graph.links:
            if link.modes:
                put("modes", link.body.name, [*link.modes.stiffness, *link.modes.damping])
            if link.modes and link.n_modes:
                put("bending", link.body.name, link.modes.smallness.numbers)
        for d in system.drives:
            put("drive", d.name, [d.kp, d.kv])
        for x in laws:
            put(x.law.kind, x.name, x.numbers)
            if x.signal:
                put("signal", x.name, [0.0, x.signal.value, 0.0])
        waves = {d.name: d.wave for d in system.drives if d.wave}
        waves |= {x.name: x.signal.wave for x in laws if x.signal and x.signal.wave}
        for name, wave in waves.items():
            put("wave", name, [wave.amplitude, wave.frequency, wave.phase, 1.0 / wave.ramp])
        for name in irregular_waves(system):
            put("waves", name, [0.0] * COEFFICIENTS)
        if waves or any(x.law.timed for x in laws):
            put("clock", "", [0.0])  # time of the run at the epoch
        for rigid in system.rigid_ropes:
            put("rigid", rigid.name, rigid_numbers(rigid))
            if rigid.mass:
                put("weight", rigid.name, [rigid.mass * system.gravity])
        for n, led in enumerate(leading := [*led_ends(system, graph)]):
            put("led", str(n), [led.mass])
        for name, (_, along) in straight_drives(system, graph).items() if leading else ():
            put("along", name, along)
        for j in graph.loops:
            put("loop", j.name, closure_numbers(j))
        weight = system.gravity * sum(b.mass for b in system.bodies)
        for c in system.contacts:
            for (kind, name), numbers_ in contact_numbers(c, abs(weight)).items():
                put(kind, name, numbers_)
        for h in system.thresholds:
            places = [x for point in points(h, system) for x in point.p]
            put("threshold", h.name, [0.0, 1.0, *places, *quantity_numbers(h, system)])
        return _side_by_side(at, np.array(values))


def irregular_waves(system: System) -> dict[str, WaveSum]:
    """Return the irregular waves of a system, by the names of the drives and forces that follow them."""
    given = [(d.name, d.waves) for d in system.drives] + [(n, s.waves) for n, s in signals(system.forces).items()]
    return {name: waves for name, waves in given if waves}


def _side_by_side(at: dict[tuple[str, str], slice], initial: np.ndarray) -> ParameterLayout:
    """Return the layout with numbers of equal laws and trees interleaved for vector calls (see `simd_batches`)."""
    groups: dict[tuple[str, int], list[tuple[str, str]]] = {}
    for key, s in at.items():
        groups.setdefault((key[0], s.stop - s.start), []).append(key)
    out: dict[tuple[str, str], slice] = {}
    values = np.empty_like(initial)
    first = 0
    for (_, size), keys in groups.items():
        last = first + size * len(keys)
        for i, key in enumerate(keys):
            out[key] = slice(first + i, last, len(keys))
            values[out[key]] = initial[at[key]]
        first = last
    return ParameterLayout({key: out[key] for key in at}, values)
