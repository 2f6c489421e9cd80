"""The signals on which limits are checked, from an equilibrium path or a run: tensions, poses and rope lengths as
columns over n instants."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Protocol, TypeAlias, TypeVar

import numpy as np
from heavylift.kernel.description import forces
from heavylift.kernel.description.mechanics import WORLD, Point
from heavylift.nodes.plan.connections import lug_places, ties_on
from heavylift.nodes.plan.plan import Hoist, Plan, Tie
from heavylift.nodes.statics.state import StaticState
from numpy.typing import NDArray

Column: TypeAlias = NDArray[np.float64]
T = TypeVar("T")
CARRIES = 0.02  # of the capacity of its hook: with less below it a hook is empty
EMPTY = 0.1  # of its hook block, where no capacity is known
Hooked: TypeAlias = tuple[float, Mapping[str, str]]  # from when [s], sling -> lug


@dataclass(frozen=True)
class SignalColumns:
    """Mechanical signals at n instants, each as a column (n,), by the kernel's names.

    t (n,) [s]; tensions: rope or support -> (n,) [N]; poses: body -> position p_WB (n, 3) [m] and rotation R_WB (n, 3,
    3); lengths: hook rope -> unstretched length (n,) [m], where it is known. `peaks`: rope -> (tension [N], time [s]),
    exact for an integrated run; `crossings`: load cell -> (tension [N], time [s]) when the rated tension was exceeded.
    `stages`: (start [s], name); `actions`: number of the action at each instant of an equilibrium path.
    """

    t: Column
    tensions: Mapping[str, Column]
    poses: Mapping[str, tuple[Column, Column]] = field(default_factory=dict)
    lengths: Mapping[str, Column] = field(default_factory=dict)
    hooked: Sequence[Hooked] = ()
    stages: Sequence[tuple[float, str]] = ()
    peaks: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    crossings: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    named: Sequence[str] = ()  # stage of each instant, of a path; of a run they follow from the times
    actions: Sequence[int] = ()
    dynamic: bool = False  # of a run, not of a path at rest
    known: dict[object, Any] = field(default_factory=dict, compare=False, repr=False)  # what was read before
    carried: dict[object, Any] = field(default_factory=dict, compare=False, repr=False)  # from one part to the next

    def once(self, key: object, make: Callable[[], T]) -> T:
        """Return the cached value of a key; on first use, compute it by calling `make`."""
        found: T | None = self.known.get(key)
        if found is None:
            found = self.known[key] = make()
        return found

    def stage_at(self, t: float, k: int | None = None) -> str:
        """Return the name of the stage at instant k or, between instants, at time t [s]."""
        if k is not None and self.named:
            return self.named[k]
        return next((name for start, name in reversed(self.stages) if start <= t), "")

    def within(self, stage: str) -> NDArray[np.bool_]:
        """Return a mask (n,) that is true for the samples within a stage."""
        if self.named:
            return np.array([name == stage for name in self.named], dtype=bool)
        at = np.searchsorted([start for start, _ in self.stages], self.t, side="right")
        return np.array([not stage, *(name == stage for _, name in self.stages)], dtype=bool)[at]

    def lugs(self, sling: str) -> list[tuple[str, NDArray[np.bool_]]]:
        """Return the lugs to which a sling is hooked, each with a mask (n,) of the samples when it is in use."""
        return self.once(("lugs", sling), lambda: self._lugs(sling))

    def _lugs(self, sling: str) -> list[tuple[str, NDArray[np.bool_]]]:
        found: dict[str, NDArray[np.bool_]] = {}
        if self.named:
            on = np.array([lugs.get(sling, "") for _, lugs in self.hooked])
            return [(lug, on == lug) for lug in sorted({*on.tolist()} - {""})]
        for i, (start, lugs) in enumerate(self.hooked):
            if lugs.get(sling):
                end = self.hooked[i + 1][0] if i + 1 < len(self.hooked) else np.inf
                inside = (self.t >= start) & (self.t < end)
                found[lugs[sling]] = found.get(lugs[sling], np.zeros(len(self.t), dtype=bool)) | inside
        return sorted(found.items())


def signals_of(states: Sequence[StaticState]) -> SignalColumns:
    """Return the columns of an equilibrium path; missing tensions are 0, other missing values nan."""
    forces = [{**state.tensions, **state.supports} for state in states]
    ropes = sorted({name for each in forces for name in each})
    bodies = sorted({name for state in states for name in state.poses})
    winches = sorted({name for state in states for name in state.references})  # and drives, which nobody asks for
    lost = (np.full(3, np.nan), np.full((3, 3), np.nan))
    return SignalColumns(
        t=np.array([state.t for state in states]),
        tensions={name: np.array([each.get(name, 0.0) for each in forces]) for name in ropes},
        poses={
            name: (
                np.array([state.poses[name][0] if name in state.poses else lost[0] for state in states]),
                np.array([state.poses[name][1] if name in state.poses else lost[1] for state in states]),
            )
            for name in bodies
        },
        lengths={name: np.array([state.references.get(name, np.nan) for state in states]) for name in winches},
        hooked=[(state.t, state.hooked) for state in states],
        named=[state.stage for state in states],
        actions=[state.action for state in states],
    )


class _Line(Protocol):
    """A rope line as it is recorded: names of the rope and of the body at its lower end, and the point on that body."""

    @property
    def rope(self) -> str: ...
    @property
    def b_body(self) -> str: ...
    @property
    def b(self) -> tuple[float, float, float]: ...


def hooked_in(plan: Plan, rigs: Sequence[tuple[float, Sequence[_Line]]]) -> list[Hooked]:
    """Return the times [s] at which the rigging changes, each with the lugs of the slings hooked from then on."""
    known = plan.machines
    slings = {tie.rope for machine in known for tie in machine.ties}
    lugs = {(point.body, *point.p): name for name, point in lug_places(known).items()}
    found: list[Hooked] = []
    for start, lines in rigs:
        ends = ((line.rope, lugs.get((line.b_body, *line.b))) for line in lines if line.rope in slings)
        found.append((start, {rope: lug for rope, lug in ends if lug}))
    return found


def tie_of(plan: Plan, name: str) -> Tie | None:
    """Return the sling with this name; None if there is none."""
    return next((tie for machine in plan.machines for tie in machine.ties if tie.rope == name), None)


def carries(plan: Plan, hook: Hoist, signals: SignalColumns) -> Column:
    """Return whether a load hangs on a hook, for each sample (n,)."""
    slings = [tie.rope for tie in ties_on(plan.machines, hook) if tie.rope in signals.tensions]
    if not slings:
        return np.ones(len(signals.t), dtype=bool)
    least = CARRIES * hook.capacity if hook.capacity else EMPTY * hook.block_mass
    return np.asarray(np.sum([signals.tensions[s] for s in slings], axis=0) > least * plan.gravity)


def place(signals: SignalColumns, point: Point) -> Column | None:
    """Return the positions (n, 3) [m] of a point on a body; None if the body is not recorded."""
    return _placed(signals, point) if point.body in signals.poses or point.body == WORLD else None


def _placed(signals: SignalColumns, point: Point) -> Column:
    if point.body == WORLD:
        return np.tile(np.array(point.p, dtype=float), (len(signals.t), 1))
    p, R = signals.poses[point.body]

    def make() -> Column:
        found = p  # column by column: what lies one after the other in memory is summed in one go
        for i, x in enumerate(point.p):
            if x:
                found = found + x * R[:, :, i]
        return found

    return signals.once((point.body, point.p), make)


def wind(plan: Plan, name: str) -> forces.InputSignal:
    """Return the input signal that gives the speed of the wind with this name."""
    each = (f for m in plan.machines for f in m.system.forces if isinstance(f, forces.Wind))
    return next(f.signal for f in each if f.name == name)


def wind_speed(s: forces.InputSignal, t: Column) -> Column:
    """Return the speed (n,) [m/s] of a wind at the times t; at a jump the larger of both values."""
    if not s.times:
        return np.full(len(t), abs(s.value))
    values, last = np.abs(np.array(s.values)), len(s.times) - 1
    before, behind = (np.searchsorted(s.times, t, side) for side in ("left", "right"))
    jump = np.maximum(values[np.minimum(before, last)], values[behind - 1])
    return np.maximum(np.abs(np.interp(t, s.times, s.values)), np.where(behind > before, jump, 0.0))
