"""The recorded channels of a run, each with one topic and unit, computed from the sample rows of the native code.

Poses are (x, y, z, qx, qy, qz, qw) of a body's frame in the world; the energy channel carries the balance: kinetic +
potential + stored - work + heat is constant.

The module also reads signals from a sample row, for listening models, by IEEE arithmetic alone.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TypeAlias, TypeVar
from weakref import WeakKeyDictionary

import numpy as np
from heavylift.kernel.algebra.arrays import times
from heavylift.kernel.algebra.attitudes import quaternions
from heavylift.kernel.algebra.spatial import skew
from heavylift.kernel.description.mechanics import Point
from heavylift.kernel.description.signals import ScalarSignal
from heavylift.kernel.errors import KernelError
from heavylift.kernel.model.program import Program
from heavylift.kernel.model.quantities import check_signal, lines, names, numbers, points, scalar
from heavylift.kernel.multibody.graph import Link, coordinate_names

from .native_functions import Stepping
from .sample_row import ROW, row_layout

POSE = ("x", "y", "z", "qx", "qy", "qz", "qw")
UNITS = {c.name: c.unit for c in ROW}


@dataclass(frozen=True)
class SampleSlice:
    """Columns `start` to `stop` of a sample, which share one topic and unit."""

    topic: str
    names: tuple[str, ...]
    unit: str
    start: int
    stop: int


class RawRows:
    """Sample rows (n, columns) as native code wrote them, accessible by group of columns."""

    def __init__(self, method: Stepping, rows: np.ndarray) -> None:
        self._rows, self._at = rows, method.row_layout.at

    def __getitem__(self, group: str) -> np.ndarray:
        i = self._at[group]
        return self._rows[:, i if isinstance(i, slice) else slice(i, i + 1)]

    def sum(self, group: str, which: Sequence[int] | slice = slice(None)) -> np.ndarray:
        """Return the sums (n, 1) over the columns of a group, added in a fixed order, so independent of batches."""
        found = self[group][:, which]
        return found.cumsum(axis=1)[:, -1:] + 0.0 if found.shape[1] else np.zeros((len(found), 1))

    def read(self, where: "Where") -> np.ndarray:
        """Return the columns (n, m) of a channel."""
        return where(self) if callable(where) else self._rows.take(where, axis=1)

    @cached_property
    def poses(self) -> np.ndarray:
        """The poses (n, 7 bodies): position [m] and quaternion of every body."""
        n = len(self._rows)
        frames = self["poses"].reshape(n, -1, 12)
        turns = quaternions(frames[:, :, 3:].reshape(-1, 3, 3))
        return np.concatenate([frames[:, :, :3], turns.reshape(n, -1, 4)], axis=2).reshape(n, -1)


Where: TypeAlias = Callable[[RawRows], np.ndarray] | list[int]  # what computes columns, or their places in a raw row
Topic = tuple[str, Sequence[str], str, Where]  # topic, names, unit, where its columns are read
T = TypeVar("T")


def _kept(make: Callable[[Program], T]) -> Callable[[Program], T]:
    """Keep what a function returns for a program as long as the program is used; variants of a scene are many."""
    known: WeakKeyDictionary[Program, T] = WeakKeyDictionary()

    def found(p: Program) -> T:
        if p not in known:
            known[p] = make(p)
        return known[p]

    return found


@_kept
def _topics(p: Program) -> list[Topic]:
    """Return all channels of a scene that have columns, in order."""
    s, loops = p.system, [f"{j.name}.{x}" for j in p.graph.loops for x in "xyz"]
    ropes, straight = ([r.name for r in group] for group in (s.ropes, s.straight_ropes))
    winches = [i for i, r in enumerate(s.ropes) if r.winch]
    works, heats = ([i for i, (kind, _) in enumerate(p.accounts) if kind == what] for what in ("work", "heat"))
    positions, velocities = coordinate_names(p.graph)
    gauges = [_gauges(k) for k in p.graph.links if k.modes and k.modes.flexible.gauges]
    at = {k: [*range(i.start, i.stop)] if isinstance(i, slice) else [i] for k, i in row_layout(p).at.items()}
    loop = np.array(at["loop"], dtype=int).reshape(-1, 2, 3)

    def of(topic: str, names: Sequence[str], *groups: str) -> Topic:
        """Return a recorded channel that consists of the columns of some column groups of a sample row."""
        return topic, names, UNITS[groups[0]], [i for g in groups for i in at[g]]

    def energies(raw: RawRows) -> np.ndarray:
        sums = [raw.sum("stored"), raw.sum("accounts", works), raw.sum("accounts", heats)]
        return np.concatenate([raw["kinetic"], raw["potential"], *sums], axis=1)

    topics = [
        of("joint/position", positions, "q"),
        of("joint/velocity", velocities, "v"),
        of("rope/tension", straight, "tension", "pull"),
        of("rope/peak", straight, "peak"),
        of("rope/peak_time", straight, "peak_time"),
        of("rope/length", straight, "length", "span"),
        of("rope/length_rate", ropes, "length_rate"),
        of("rope/elongation", ropes, "elongation"),
        ("hook/load", [ropes[i] for i in winches], "N", [at["tension"][i] for i in winches]),
        of("support/force", [u.name for u in s.supports], "normal"),
        of("rigid/slack", [r.name for r in s.rigid_ropes], "slack"),
        of("contact/force", [c.name for c in s.contacts], "pressing"),
        ("loop/force", loops, "N", loop[:, 0].ravel().tolist()),
        ("loop/moment", loops, "N m", loop[:, 1].ravel().tolist()),
        ("energy", ("kinetic", "potential", "stored", "work", "heat"), "J", energies),
        of("account", [f"{name}.{what}" for what, name in p.accounts], "accounts"),
        *(
            (topic, [n for n, _ in columns], unit, [at["shown"][i] for _, i in columns])
            for (topic, unit), columns in shown(p).items()
        ),
        ("deflection", [n for names, *_ in gauges for n in names], "m", lambda raw: _bent(raw, gauges)),
        *((f"pose/{k.body.name}", POSE, "m, quaternion x y z w", _pose(7 * i)) for i, k in enumerate(p.graph.links)),
    ]
    return [topic for topic in topics if topic[1]]


def _gauges(link: Link) -> tuple[list[str], slice, np.ndarray]:
    """Return names, modal coordinates and displacement matrix (n, m) of the sampled places of a flexible body."""
    assert link.modes is not None, "of a flexible body"
    names, rows = list[str](), list[np.ndarray]()
    for gauge in link.modes.flexible.gauges:
        station, X = link.modes.station(gauge.p)
        shape = link.modes.at(station)
        moved = shape[:3] - times(skew(np.array(gauge.p) - X), shape[3:])
        names += [f"{link.body.name}.{gauge.name}.{x}" for x in "xyz"]
        rows += list(moved)
    return names, link.q_modes, np.array(rows)


def _bent(raw: RawRows, gauges: list[tuple[list[str], slice, np.ndarray]]) -> np.ndarray:
    """Return the displacements of sampled places within flexible bodies."""
    return np.concatenate([times(raw["q"][:, modes], shapes.T) for _, modes, shapes in gauges], axis=1)


def _pose(first: int) -> Where:
    return lambda raw: raw.poses[:, first : first + 7]


def shown(p: Program) -> dict[tuple[str, str], list[tuple[str, int]]]:
    """Return, for each topic and unit of sampled force quantities, the names and the indices of their columns."""
    groups: dict[tuple[str, str], list[tuple[str, int]]] = {}
    for i, (_, _, x) in enumerate(p.columns["shown"]):
        groups.setdefault((x.topic, x.unit), []).append((x.name, i))
    return groups


def channels(method: Stepping) -> list[SampleSlice]:
    """Return the recorded channels of a scene, in the order of the columns that `published` returns."""
    out, at = [], 0
    for topic, columns, unit, _ in _topics(method.program):
        out.append(SampleSlice(topic, tuple(columns), unit, at, at + len(columns)))
        at += len(columns)
    return out


def published(method: Stepping, rows: np.ndarray) -> np.ndarray:
    """Return recorded samples (n, columns) from sample rows of the native code (n, method.columns)."""
    raw, (places, computed) = RawRows(method, rows), _columns(method.program)
    out = rows.take(places, axis=1)
    for at, where in computed:
        out[:, at] = raw.read(where)
    return out


@_kept
def _columns(p: Program) -> tuple[np.ndarray, list[tuple[slice, Where]]]:
    """Return the place in a raw row of each published column, and what computes those that are no part of it."""
    places, computed = list[int](), list[tuple[slice, Where]]()
    for _, columns, _, where in _topics(p):
        if callable(where):
            computed.append((slice(len(places), len(places) + len(columns)), where))
        places += [0] * len(columns) if callable(where) else where
    return np.array(places, dtype=int), computed


class _Derivatives(RawRows):
    """Derivatives (n, columns) of the channels at the raw row `at`; all channels but poses are linear in a raw row."""

    def __init__(self, method: Stepping, rows: np.ndarray, at: RawRows) -> None:
        super().__init__(method, rows)
        self._of = at

    @cached_property
    def poses(self) -> np.ndarray:
        n, frames = len(self._rows), self["poses"].reshape(len(self._rows), -1, 12)
        R = self._of["poses"].reshape(-1, 12)[:, 3:].reshape(-1, 3, 3)
        turns = self._of.poses.reshape(-1, 7)[:, 3:]
        spin = frames[:, :, 3:].reshape(n, -1, 3, 3) @ R.transpose(0, 2, 1)
        w = np.stack([spin[..., 2, 1], spin[..., 0, 2], spin[..., 1, 0]], axis=-1)
        u, s = turns[:, :3], turns[:, 3:]
        rates = np.concatenate([s * w + np.cross(w, u), -(w * u).cumsum(axis=-1)[..., -1:]], axis=-1)
        return np.concatenate([frames[:, :, :3], 0.5 * rates], axis=2).reshape(n, -1)


def differentiated(method: Stepping, row: np.ndarray, change: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return recorded samples (columns,) for the sample row `row` (m,), and their derivatives (k, columns).

    For the changes `change` (m, k) of `row`; NaN where they are not known.
    """
    beyond = method.columns - len(row)
    at = RawRows(method, np.pad(row, (0, beyond), constant_values=np.nan)[None])
    moved = _Derivatives(method, np.pad(change.T, ((0, 0), (0, beyond))), at)
    values, slopes = ([x.read(where) for *_, where in _topics(method.program)] for x in (at, moved))
    return np.concatenate(values, axis=1)[0], np.concatenate(slopes, axis=1)


Reader: TypeAlias = Callable[[Sequence[float]], float]  # of a raw row (columns,)


def reader(program: Program, signal: ScalarSignal) -> Reader:
    """Return the function that reads a scalar signal from a sample row; raises KernelError for an unknown signal."""
    system = program.system
    check_signal(signal, system, f"signal '{signal.quantity}'")
    places = [_placed(program, point) for point in points(signal, system)]
    columns = [_column(program, signal, name) for name in names(signal, system)]
    given, each = numbers(signal, system), lines(signal, system)
    return lambda row: float(scalar(signal, [place(row) for place in places], given, [row[i] for i in columns], each))


def _column(program: Program, signal: ScalarSignal, name: str) -> int:
    """Return the column of a signal's source."""
    at, s, kind = row_layout(program).at, program.system, signal.quantity
    if kind in ("joint", "speed"):
        i, k = program.graph.coordinate(f"signal '{kind}'", name, signal.coordinate)
        return int(at["q"].start + i if kind == "joint" else at["v"].start + k)
    if kind == "angle":
        label = ("body", name, signal.axis)
        if label not in program.angles:
            raise KernelError(f"signal 'angle': the angle of '{name}' is not measured in this scene")
        return int(at["turned"].start) + program.angles.index(label)
    elastic, rigid = [r.name for r in s.ropes], [r.name for r in s.rigid_ropes]
    shown = [x for (_, x), _, _ in program.columns["shown"]]
    if kind == "length" and name in elastic:
        return int(at["length"].start) + elastic.index(name)
    if kind != "length" and name in elastic:
        return int(at["tension"].start) + [x for (_, x), _, _ in program.columns["tension"]].index(name)
    if name in rigid:
        return int(at["span" if kind == "length" else "pull"].start) + rigid.index(name)
    if kind != "length" and name in shown:
        return int(at["shown"].start) + shown.index(name)
    raise KernelError(f"signal '{kind}': there is no rope '{name}'")


def _placed(program: Program, point: Point) -> Callable[[Sequence[float]], tuple[float, float, float]]:
    """Return a function that computes the position of a body's point in the world from a row [m]."""
    number, (x, y, z) = program.graph.number(point.body), point.p
    if number < 0:
        return lambda row: (x, y, z)
    o = row_layout(program).at["poses"].start + 12 * number

    def place(row: Sequence[float]) -> tuple[float, float, float]:
        r = row[o : o + 12]
        return (
            r[0] + (r[3] * x + r[4] * y + r[5] * z),
            r[1] + (r[6] * x + r[7] * y + r[8] * z),
            r[2] + (r[9] * x + r[10] * y + r[11] * z),
        )

    return place
