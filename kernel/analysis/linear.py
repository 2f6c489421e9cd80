"""Linearisation of a scene about an instant: x' = A x + B u, y = C x + D u, by derivatives of the traced equations.

x: displacements and velocities of the free coordinates, the states of radiation, and position and speed of the
references that u drives; u: the highest derivative of a reference that the equations use, or the value of a signal.
Slack ropes stay slack, and sticking contacts keep sticking. If there are closed loops, x holds only independent
coordinates (coordinate partitioning: Wehage, Haug, J. Mech. Design 104 (1982)).
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from fnmatch import fnmatchcase
from typing import TYPE_CHECKING

import numpy as np
from heavylift.kernel.algebra.spatial import skew
from heavylift.kernel.compiler.derivative import derivatives
from heavylift.kernel.compiler.function import Function, Outputs
from heavylift.kernel.compiler.symbol import Array
from heavylift.kernel.description.forces import Stream, TuggerLine, Wind
from heavylift.kernel.description.mechanics import JOINTS, RigidRope
from heavylift.kernel.errors import KernelError, closest
from heavylift.kernel.model.evaluation import evaluate
from heavylift.kernel.model.program import Program
from heavylift.kernel.multibody.graph import coordinate_names
from heavylift.kernel.simulation.native.sample_row import columns
from heavylift.kernel.simulation.native.samples import channels, differentiated

if TYPE_CHECKING:
    from heavylift.kernel.simulation.simulation import Simulation

STILL = 1e-12  # [m/s, rad/s]
DEPENDENT = 1e-9  # of the largest row: what is left of one that others imply
START, VALUE, SPEED, ACCELERATION, SPAN = range(5)  # places of a profile


@dataclass(frozen=True)
class LinearColumn:
    """A state, input or output of a linear model: its name, unit, and value at the point of linearisation."""

    name: str
    unit: str
    value: float = 0.0


@dataclass(frozen=True, eq=False)
class LinearModel:
    """Linearised model x' = A x + B u, y = C x + D u in deviations, with the name of each row and column.

    A (n, n), B (n, m), C (p, n), D (p, m) in SI units. It unpacks as A, B, C, D.
    """

    A: np.ndarray
    B: np.ndarray
    C: np.ndarray
    D: np.ndarray
    states: tuple[LinearColumn, ...]
    inputs: tuple[LinearColumn, ...]
    outputs: tuple[LinearColumn, ...]

    def __iter__(self) -> Iterator[np.ndarray]:
        return iter((self.A, self.B, self.C, self.D))


def linear_model(simulation: "Simulation", inputs: Sequence[str], outputs: Sequence[str]) -> LinearModel:
    """Linearise a started simulation about its present state.

    `inputs`: names of drives, winches, masters and signals; `outputs`: names of sampled signals, such as
    "joint/position/elbow.angle", or patterns of names. Raises KernelError.
    """
    return _Linearised(simulation, inputs, outputs).model()


class _Linearised:
    """Derivatives of a scene along raw directions: nq coordinates, nv velocities, radiation states, numbers of P."""

    def __init__(self, simulation: "Simulation", inputs: Sequence[str], outputs: Sequence[str]) -> None:
        self.simulation, self.program = simulation, simulation.program
        p, native = self.program, simulation.native
        self.speeds, self.memory = slice(p.nq, p.nq + p.nv), [*p.memory.values()]
        own = [*range(p.nq + p.nv), *self.memory]  # numbers of y with a direction
        self.raw = len(own)
        self.P, t = simulation.P.copy(), np.array([native["t"], native["t"] + 0.5])
        for name in [name for kind, name in p.parameters.at if kind == "reference"]:
            now = p.profile(t=[t[0], native.among()], p=self._numbers("reference", name))
            pieces = t[0], now.x[0], now.v[0], now.a[0], 1.0, 0.0, 0.0, 0.0
            self.P[p.parameters.at["reference", name]] = pieces
        self.inputs = [_Input(p, name) for name in dict.fromkeys(inputs)]
        y = simulation.state.copy()
        places = [place for x in self.inputs for place in x.places]
        seeds = {"y": np.eye(p.ny)[:, own], "P": np.zeros((len(self.P), self.raw))}
        seeds["y"] = np.concatenate([seeds["y"], np.zeros((p.ny, len(places)))], axis=1)
        seeds["P"] = np.concatenate([seeds["P"], np.eye(len(self.P))[:, places]], axis=1)
        self.found = derivatives(_traced(p), {"t": t, "y": y, "P": self.P}, seeds)
        self.v, self.water = y[self.speeds], y[self.memory]
        self.wanted = self._outputs(outputs)
        self._check()

    def _numbers(self, kind: str, name: str) -> np.ndarray:
        found: np.ndarray = self.P[self.program.parameters.at[kind, name]]
        return found

    def _check(self) -> None:
        names = self.program.constraints.names
        held = [i for i, on in enumerate(self.found["on"][0]) if on > 0.0]
        for i in held:
            if names[i].startswith("contact "):
                raise KernelError(
                    f"linearise: {names[i]} is closed; a scene can be linearised only while no contact is closed"
                )
        if held and np.abs(self.v).max() > STILL:
            raise KernelError(
                f"linearise: the bodies at {names[held[0]]} are moving; a scene with loops "
                "or rigid ropes can be linearised only at rest"
            )

    def model(self) -> LinearModel:
        """Return the linear model, with its matrices A, B, C, D reduced to independent states."""
        p = self.program
        dy, moves = self.found["dy"][1], self.found["dy"][1][: p.nq, self.speeds]
        fixed = {tree.v.start + k for tree, _ in p.instances for k in tree.prescribed_dofs}
        free = [k for k in range(p.nv) if k not in fixed]
        kept, T, given = self._partition(free, moves)
        n, extra = len(kept), [x for x in self.inputs for _ in x.held]
        water = slice(2 * n, 2 * n + len(self.memory))
        states = np.zeros((dy.shape[1], water.stop + len(extra)))  # raw directions of each state
        acts = np.zeros((dy.shape[1], len(self.inputs)))
        displaced, moved = moves[:, free], np.eye(p.nv)[:, free]
        states[: p.nq, :n], states[self.speeds, n : 2 * n] = displaced @ T, moved @ T
        states[self.speeds.stop : self.raw, water] = np.eye(len(self.memory))
        A, B = np.zeros((states.shape[1],) * 2), np.zeros((states.shape[1], len(self.inputs)))
        at, place = water.stop, self.raw
        for i, x in enumerate(self.inputs):
            for order in range(len(x.places)):
                target = states[:, at + order] if order < len(x.held) else acts[:, i]
                target[place] = 1.0
                if order + 1 < len(x.places):  # where rows hold, the others follow the reference
                    target[: p.nq] += displaced @ given[:, place - self.raw]
                    target[self.speeds] += moved @ given[:, place - self.raw - 1] if order else 0.0
                place += 1
            for k in range(len(x.held)):
                if k + 1 < len(x.held):
                    A[at + k, at + k + 1] = 1.0
                else:
                    B[at + k, i] = 1.0
            at += len(x.held)
        rate = self._turning(moves)
        own = [free[k] for k in kept]
        A[:n], A[n : 2 * n] = (rate @ states)[own], (dy[self.speeds] @ states)[own]
        B[:n], B[n : 2 * n] = (rate @ acts)[own], (dy[self.speeds] @ acts)[own]
        A[water], B[water] = dy[self.memory] @ states, dy[self.memory] @ acts
        C = np.array([row for _, row in self.wanted]).reshape(-1, dy.shape[1])
        named = self._states(own) + [LinearColumn(*state) for x in self.inputs for state in x.held]
        shown = tuple(LinearColumn(x.name, x.unit, float(self.P[x.places[-1]])) for x in self.inputs)
        return LinearModel(A, B, C @ states, C @ acts, tuple(named), shown, tuple(x for x, _ in self.wanted))

    def _partition(self, free: list[int], moves: np.ndarray) -> tuple[list[int], np.ndarray, np.ndarray]:
        """Return the indices (n,) of the independent free velocities, and the matrices that give all free velocities
        from these (n_free, n) and from the numbers of P (n_free, m), so that active rows of loops and ropes are
        satisfied."""
        gap = self.found["gap"][1]
        G, driven = gap[:, : self.program.nq] @ moves[:, free], gap[:, self.raw :]
        dependent: list[int] = []
        left = G.copy()
        while left.size:
            sizes = np.sum(left * left, axis=0)
            k = int(np.argmax(sizes))
            if sizes[k] <= DEPENDENT**2 * np.max(np.sum(G * G, axis=0)) or not sizes[k]:
                break
            dependent.append(k)
            direction = left[:, k] / np.sqrt(sizes[k])
            left -= np.outer(direction, direction @ left)
        kept = [k for k in range(len(free)) if k not in dependent]
        T, given = np.zeros((len(free), len(kept))), np.zeros((len(free), driven.shape[1]))
        T[kept, range(len(kept))] = 1.0
        if dependent:
            inverse = np.linalg.pinv(G[:, dependent])
            T[dependent], given[dependent] = -inverse @ G[:, kept], -inverse @ driven
        return kept, T, given

    def _turning(self, moves: np.ndarray) -> np.ndarray:
        """Return the rates (nv, raw) of the displacements along the raw directions: the velocities, and the change of
        axes of moving bodies with quaternions."""
        p = self.program
        rate = np.zeros((p.nv, self.found["dy"][1].shape[1]))
        rate[:, self.speeds] = np.eye(p.nv)
        displaced = np.zeros((p.nv, p.nq))
        for k in p.graph.links:
            if JOINTS[k.joint.kind].quaternion is None or not self.v[k.v].any():
                continue
            w = slice(k.v.stop - 3, k.v.stop)
            inverse = np.linalg.pinv(moves[k.q, k.v])
            spin = np.zeros((k.v.stop - k.v.start,) * 2)
            spin[-3:, -3:] = -skew(self.v[w])
            if len(spin) == 6:
                spin[:3, :3], spin[:3, 3:] = -skew(self.v[w]), -skew(self.v[k.v.start : k.v.stop - 3])
            displaced[k.v, k.q] = spin @ inverse
        rate[:, : p.nq] = displaced
        return rate

    def _outputs(self, asked: Sequence[str]) -> list[tuple[LinearColumn, np.ndarray]]:
        """Return the sampled columns that match the patterns `asked`, with their derivatives along the raw
        directions."""
        found: dict[str, tuple[LinearColumn, np.ndarray]] = {}
        method, (row, change) = self.simulation.method, self.found["row"]
        values, slopes = differentiated(method, row, change)
        for c in channels(method):
            for i, name in enumerate(c.names):
                if not np.isnan(values[c.start + i]):
                    unit = unit_of(self.program, c.topic, i, c.unit)
                    shown = LinearColumn(f"{c.topic}/{name}", unit, float(values[c.start + i]))
                    found[shown.name] = shown, slopes[:, c.start + i]
        out = dict[str, tuple[LinearColumn, np.ndarray]]()
        for pattern in asked:
            of = {name: x for name, x in found.items() if name == pattern or fnmatchcase(name, pattern)}
            if not of:
                groups = list(dict.fromkeys(name.rpartition("/")[0] for name in found))
                raise KernelError(
                    f"linearise: there is no output '{pattern}'; write signal/name, such as '{next(iter(found))}'; "
                    f"{closest(pattern.rpartition('/')[0], groups)}"
                )
            out |= of
        return list(out.values())

    def _states(self, own: Sequence[int]) -> list[LinearColumn]:
        names, velocities = _state_names(self.program), coordinate_names(self.program.graph)[1]
        units = [unit_of(self.program, "joint/velocity", k, "") for k in range(self.program.nv)]
        placed = [LinearColumn(f"joint/position/{names[k]}", units[k].removesuffix("/s")) for k in own]
        placed += [LinearColumn(f"joint/velocity/{velocities[k]}", units[k], float(self.v[k])) for k in own]
        waters = zip(self.program.memory, self.water, strict=True)
        return placed + [LinearColumn(f"radiation/{name}.{i + 1}", "J^0.5", float(x)) for (name, i), x in waters]


class _Input:
    """An input of the linear model: its positions in P, and the states of the integrators between u and the
    reference."""

    def __init__(self, p: Program, name: str) -> None:
        at, places = p.parameters.at, np.arange(len(p.parameters.initial))
        drive = next((d for d in p.system.drives if d.name == name), None)
        rope = next((r for r in p.system.all_ropes if r.name == name), None)
        law = next((x for x in p.laws if x.name == name), None)
        tugs = isinstance(rope, TuggerLine)
        driven = ("reference", name) in at and (drive or tugs or (rope.winch if rope else True))
        self.name, self.held = name, list[tuple[str, str]]()
        unit, order = "1", 0
        if driven:
            of = places[at["reference", name]]
            turns = drive and _turns(p, drive.joint, drive.coordinate)
            unit = "rad" if turns else "N" if tugs else "m" if drive or rope else "1"
            whole = isinstance(rope, RigidRope) or (drive.kind == "prescribed" if drive else not rope and not law)
            order = 2 if whole else 1 if drive or (rope and not tugs) else 0
            self.places = [int(of[k]) for k in (VALUE, SPEED, ACCELERATION)[: order + 1]]
            if drive and drive.kind == "speed":
                self.places = self.places[1:]
        elif law is not None and law.signal:
            unit = "m/s" if isinstance(law.force, Wind | Stream) else "m" if rope else "1"
            self.places = [int(places[at["signal", name]][1])]
        else:
            known = [kind_name for kind, kind_name in at if kind in ("reference", "signal")]
            known = [
                x for x in dict.fromkeys(known) if x not in {r.name for r in p.system.straight_ropes if not r.winch}
            ]
            raise KernelError(
                f"linearise: there is no input '{name}'; {closest(name, known) or 'the scene has no inputs'}"
            )
        units = [unit, f"{unit}/s", f"{unit}/s2"] if unit != "1" else ["1", "1/s", "1/s2"]
        self.held = [
            (f"reference/{name}{suffix}", units[k]) for k, suffix in enumerate(("", " rate")[: len(self.places) - 1])
        ]
        self.unit = units[order] if driven else unit


def _traced(p: Program) -> Function:
    """Return the function (t (2,), y, P) -> dy, sample row, gaps of the active rows, and which rows are active."""

    def body(t: Array, y: Array, P: Array) -> Outputs:
        x = evaluate(p, t[0], y, P, t[1])
        rows = x.rows.rows if x.rows else []
        gap = x.rows.held([r.gap for r in rows]) if x.rows else []
        return {"dy": x.dy, "row": columns(x), "gap": gap, "on": [r.on for r in rows]}

    return Function("linear", body, {"t": 2, "y": p.ny, "P": len(p.parameters.initial)})


def _turns(p: Program, joint: str, coordinate: str) -> bool:
    link = next(k for k in p.graph.links if k.joint.name == joint)
    kind = JOINTS[link.joint.kind]
    return kind.turns(list(kind.coordinates).index(coordinate) if coordinate else 0)


def _state_names(p: Program) -> list[str]:
    """Return the names of the displacements, one per velocity."""
    out = []
    for k in p.graph.links:
        kind = JOINTS[k.joint.kind]
        names = list(kind.coordinates) if kind.quaternion is None else ["x", "y", "z", "rx", "ry", "rz"][-kind.n_v :]
        out += [f"{k.joint.name}.{name}" for name in names]
        out += [f"{k.body.name}.mode{i + 1}" for i in range(k.n_modes)]
    return out


def unit_of(p: Program, topic: str, i: int, unit: str) -> str:
    """Return the unit of column i of a sample topic, such as m or rad; `unit`: the unit if all columns share one."""
    if topic.startswith("pose/"):
        return "m" if i < 3 else "1"
    units: dict[str, list[str]] = {"joint/position": [], "joint/velocity": []}
    for k in p.graph.links:
        kind, modes = JOINTS[k.joint.kind], ["m"] * k.n_modes
        if kind.quaternion is None:
            own = ["rad" if kind.turns(c) else "m" for c in range(kind.n_q)]
            units["joint/position"] += own + modes
            units["joint/velocity"] += [f"{x}/s" for x in own + modes]
        else:
            units["joint/position"] += ["m"] * kind.quaternion + ["1"] * 4 + modes
            units["joint/velocity"] += ["m/s"] * (kind.n_v - 3) + ["rad/s"] * 3 + [f"{x}/s" for x in modes]
    return units[topic][i] if topic in units else unit
