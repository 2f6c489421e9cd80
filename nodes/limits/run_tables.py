"""What is collected from the samples in addition to the limits: reactions, loads on lugs, slings, stages, the path of
the block, and the radii of hooks with the utilisation of their charts.

The load of a crane is the sum of its hook tensions. The dynamic factor of a stage is the maximum of this load divided
by the larger of its static values before and at the end of the stage.
"""

from collections.abc import Callable, Iterator, Sequence
from itertools import pairwise, product
from math import degrees

import msgspec
import numpy as np
from heavylift.kernel.description.mechanics import Point, merge
from heavylift.nodes.plan.connections import lug_places
from heavylift.nodes.plan.limit import STANDING, RatedLimit, Reach, Use
from heavylift.nodes.plan.plan import Plan
from heavylift.nodes.statics.state import StaticState
from heavylift.recordings.format.viewer_messages import RopeLine
from heavylift.recordings.sheets.sheet import Cell, Marked, Table, columns, trimmed

from .named import measured, rated
from .reading import axis_of, force_on_base, read
from .sharing import dynamics_required
from .signals import Column, SignalColumns, place, signals_of

EMPTY = 1.1  # times what always hangs on its hooks: with less a crane carries nothing
SETTLED = 0.05  # last part of a stage over which its resting load is taken
TONNE = 9806.65  # [N] its weight
FORCE = columns("largest load [kN] .1", "as a mass [t] .1", "at [h:min:s]")
PLACE = columns("x [m] .2", "y [m] .2", "z [m] .2")
At = Callable[[float], tuple[SignalColumns, Sequence[RopeLine]]]  # columns of one sample, and the ropes that hang then
Cells = tuple[Cell, ...]


class RunTables:
    """Collects the tables of a run from successive parts of its samples. `stages`: (begin [s], name) of each stage."""

    def __init__(self, plan: Plan, stages: Sequence[tuple[float, str]], end: float) -> None:
        self._plan, self._rated = plan, rated(plan)
        self._spans = [(name, a, b) for (a, name), (b, _) in pairwise([*stages, (end, "")])]
        self._cranes = [machine for machine in plan.machines if machine.hooks]
        self._pads = [support for machine in plan.machines for support in machine.system.supports]
        self._cargo = [cargo for machine in plan.machines for cargo in machine.cargo]
        boxes = [x for machine in plan.machines for x in machine.shapes]
        self._points = {
            cargo.body: [
                [c + sign * side / 2.0 for c, sign, side in zip(x.centre, signs, x.size, strict=True)]
                for x in boxes if x.body == cargo.body
                for signs in product((-1.0, 1.0), repeat=3)
            ]
            or [[*cargo.com]]
            for cargo in self._cargo
        }  # fmt: skip
        self._t, self._loads = list[Column](), list[list[Column]]()
        self._paths: dict[str, list[Column]] = {}
        self._reactions: dict[str, tuple[float, float, Cells]] = {}
        self._most: list[dict[str, float]] = [{} for _ in self._spans]

    def see(self, signals: SignalColumns) -> SignalColumns:
        """Collect data for the tables from the samples of the next part of the run; return these samples unchanged."""
        t, zero = signals.t, np.zeros(len(signals.t))
        if not len(t):
            return signals
        self._t.append(t)
        pulls = [[signals.tensions.get(hook.rope, zero) for hook in crane.hooks] for crane in self._cranes]
        self._loads.append([np.asarray(np.sum(pull, axis=0)) for pull in pulls])
        for cargo in (x for x in self._cargo if x.body in signals.poses):
            p, R = signals.poses[cargo.body]
            low = np.min([p[:, 2] + R[:, 2] @ np.array(x) for x in self._points[cargo.body]], axis=0)
            path = np.column_stack([low, np.arccos(np.clip(R[:, 2, 2], -1.0, 1.0)), p + R @ np.array(cargo.com)])
            self._paths.setdefault(cargo.body, []).append(path)
        for (_, a, b), most in zip(self._spans, self._most, strict=True):
            inside = (t >= a) & (t <= b)
            for rope in self._rated.keys() & signals.tensions.keys() if inside.any() else ():
                most[rope] = max(most.get(rope, 0.0), float(signals.tensions[rope][inside].max()))
        forces = [signals.tensions[pad.name] for pad in self._pads if pad.name in signals.tensions]
        for pad in (pad for pad in self._pads if pad.name in signals.tensions):
            self._react(pad.name, t, signals.tensions[pad.name], place(signals, pad.point))
        if forces:
            self._react("all together", t, np.sum(forces, axis=0), None)
        return signals

    def _react(self, name: str, t: Column, force: Column, at: Column | None) -> None:
        k = int(np.argmax(force))
        if force[k] > self._reactions.get(name, (0.0,))[0]:
            found: Cells = (None, None, None) if at is None else tuple(at[k].tolist())
            self._reactions[name] = float(force[k]), float(t[k]), found

    def tables(self, uses: Sequence[Use], peaks: dict[str, tuple[float, float]], at: At) -> Iterator[Table]:
        """Yield all tables of the run.

        `uses`: limits with their highest utilisation; `peaks`: (tension [N], time [s]) by rope; `at`: function that
        returns columns and rope lines at a time."""
        yield Table("Loads on lugs", LUGS, tuple(self._lugs(uses, at)), ("u, v, w are the axes of the block.",))
        yield Table("Slings", SLINGS, tuple(self._slings(uses, peaks, at)))
        rows = tuple((name, *p, F / 1e3, F / TONNE, t) for name, (F, t, p) in self._reactions.items())
        yield Table("Reactions of supports", (*columns("support"), *PLACE, *FORCE), rows, ("At samples.",))
        note = "Along and across from the middle of the base; without inertia of the machine and wind on it."
        yield trimmed(Table("Loads on bases", BASES_OF, tuple(self._bases(uses, at)), (note,)))
        yield self._stages()
        for body in self._paths:
            title = f"Path of {'the ' * (body == 'block')}{body}"
            yield Table(title, (*PATH, *PLACE), tuple(self._path(body)), (TILT,))

    def _lugs(self, uses: Sequence[Use], at: At) -> Iterator[Cells]:
        known = lug_places(self._plan.machines)
        for use in (x for x in uses if x.limit.quantity == "lug load" and x.value and x.t is not None):
            lug = known.get(use.limit.subject)
            cargo = next((x for x in self._cargo if lug and x.body == lug.body), None)
            if lug is None or cargo is None or use.t is None or use.value is None:
                continue
            signals, lines = at(use.t)
            mine = [x for x in lines if (x.b_body, tuple(x.b)) == (lug.body, tuple(lug.p))]
            pulls = [(signals.tensions[x.rope][0], _up(signals, x)) for x in mine if x.rope in signals.tensions]
            F = np.sum([T * d for T, d in pulls], axis=0) if pulls else np.zeros(3)
            size, force = float(np.linalg.norm(F)), use.value * self._plan.gravity
            along = signals.poses[lug.body][1][0].T @ F * (force / size / 1e3 if size else 0.0)
            yield use.limit.subject, *lug.p, force / 1e3, force / TONNE, use.t, *along.tolist()

    def _slings(self, uses: Sequence[Use], peaks: dict[str, tuple[float, float]], at: At) -> Iterator[Cells]:
        widest = {x.limit.subject: x.value for x in uses if x.limit.quantity == "bridle angle"}
        lugs = {(x.body, tuple(x.p)): name for name, x in lug_places(self._plan.machines).items()}
        ropes = [tie.rope for machine in self._plan.machines for tie in machine.ties]
        for rope, (_, t) in ((x, peaks[x]) for x in ropes if peaks.get(x, (0.0,))[0] > 0.0):
            signals, lines = at(t)
            for line in (x for x in lines if x.rope == rope):
                angle = degrees(float(np.arccos(np.clip(abs(_up(signals, line)[2]), 0.0, 1.0))))
                most = widest.get(rope)
                lug = lugs.get((line.b_body, tuple(line.b)), "")
                yield rope, lug, angle, None if most is None else max(angle, degrees(most))

    def _bases(self, uses: Sequence[Use], at: At) -> Iterator[Cells]:
        machines = self._plan.machines
        system = merge((machine.system for machine in machines), self._plan.gravity)
        for use in (x for x in uses if x.limit.quantity in STANDING and x.limit.elements and x.value):
            x = next((m.footing for m in machines if m.name == use.limit.elements[0]), None)
            ((signal, *_),) = measured(use.limit, machines, self._plan.gravity)
            force = None if use.t is None else force_on_base(signal, system, at(use.t)[0])
            if x is not None and force is not None:
                V, along, across = (float(column[0]) for column in force)
                each = (x.each if x.kind == kind else None for kind in ("tracks", "outriggers", "wheels"))
                area, mass = x.mat or (None, 0.0)
                yield (use.limit.quantity, use.limit.subject, use.t, V / 1e3, along, across, x.length, x.width, *each,
                       area, mass / 1e3 if area else None)  # fmt: skip

    def _stages(self) -> Table:
        """Return the table of stages, with the governing rope and the dynamic factors of the cranes."""
        t = np.concatenate([np.zeros(0), *self._t])
        loads = [np.concatenate([np.zeros(0), *each]) for each in zip(*self._loads, strict=True)]
        required, rows = dynamics_required(self._plan), list[Cells]()
        for (name, a, b), most in zip(self._spans, self._most, strict=True):
            rope = max(sorted(most), key=lambda x: most[x] / self._rated[x], default="")
            inside = (t >= a) & (t <= b)
            factors = [self._factor(crane, load[inside], t[inside]) for crane, load in enumerate(loads)]
            marked = (Marked(x) if x is not None and required and x > required[0] else x for x in factors)
            rows.append((name, a, b - a, rope, 100.0 * most[rope] / self._rated[rope] if rope else None, *marked))
        heads = columns("stage", "from [h:min:s]", "lasts [s] .1", "governing rope", "use [%] .1",
                        *(f"dynamic factor of {crane.name} .3" for crane in self._cranes))  # fmt: skip
        note = f"Dynamic factor required: {required[0]:g} ({required[1]}); more is marked." if required else ""
        return Table("Stages", heads, tuple(rows), (note,) if note and self._cranes else ())

    def _factor(self, crane: int, load: Column, t: Column) -> float | None:
        """Return the dynamic factor of a crane in a stage; None if its hooks are empty."""
        dead = sum(hook.below or hook.block_mass for hook in self._cranes[crane].hooks) * self._plan.gravity
        late = load[t >= t[-1] - SETTLED * (t[-1] - t[0])] if len(t) else load
        rest = max(float(load[0]), float(late.mean())) if len(late) else 0.0
        return float(load.max()) / rest if rest > EMPTY * dead else None

    def _path(self, body: str) -> Iterator[Cells]:
        t, path = np.concatenate(self._t), np.concatenate(self._paths[body])
        for name, a, b in self._spans:
            inside = path[(t >= a) & (t <= b)] if len(path) == len(t) else path[:0]
            if len(inside):
                low, least, most = inside[:, 0].min(), inside[:, 1].min(), inside[:, 1].max()
                yield name, a, float(low), degrees(float(least)), degrees(float(most)), *inside[-1, 2:].tolist()


def _up(signals: SignalColumns, line: RopeLine) -> Column:
    """Return the direction (3,) of a rope line from its lower to its upper end at the first sample."""
    a, b = (place(signals, Point(body, p)) for body, p in ((line.a_body, line.a), (line.b_body, line.b)))
    d = (a - b)[0] if a is not None and b is not None else np.zeros(3)
    return np.asarray(d / max(float(np.linalg.norm(d)), 1e-12))


LUGS = (*columns("lug", "u [m] .2", "v [m] .2", "w [m] .2"), *FORCE, *columns(*(f"along {x} [kN] .1" for x in "uvw")))
SLINGS = columns("sling", "lug", "angle to vertical at its peak [deg] .1", "at most [deg] .1")
BASES_OF = columns("check", "item", "at [h:min:s]", "resultant [kN] .1", "along [m] .3", "across [m] .3",
                   "base length [m] .2", "base width [m] .2", "track breadth [m] .2", "pad area [m2] .2",
                   "wheels at a corner .0", "mat area [m2] .2", "mat mass [t] .2")  # fmt: skip
PATH = columns("stage", "from [h:min:s]", "lowest point [m] .2", "least tilt [deg] .1", "largest tilt [deg] .1")
TILT = "Tilt: angle of the block's w axis to the vertical; x, y, z: centre of gravity at the end of the stage."


WHEN = ("begins", "most", "ends")


class HookReach:
    """Collects, over an equilibrium path or a run, the radii of all hooks that have a radius chart."""

    def __init__(self, plan: Plan) -> None:
        self._plan = plan
        self._limits = [x for x in plan.limits if x.quantity == "hook load" and x.over == "radius"]
        self._found: dict[tuple[str, str], list[Reach]] = {}

    def see(self, signals: SignalColumns) -> SignalColumns:
        """Collect hook radii from the samples of the next part of the path or run; return these samples unchanged."""
        for limit in self._limits:
            reading, radii = read(self._plan, limit, signals), axis_of(self._plan, limit, signals)
            if reading is None or radii is None:
                continue
            for k in np.flatnonzero(np.isfinite(reading.values + radii)).tolist():
                self._add(limit, signals, float(signals.t[k]), float(radii[k]), float(reading.values[k]), k)
            if reading.exact and signals.t[0] <= reading.exact[1] <= signals.t[-1]:
                load, t = reading.exact
                self._add(limit, signals, t, float(np.interp(t, signals.t, radii)), load, None)
        return signals

    def see_path(self, states: Sequence[StaticState]) -> tuple[Reach, ...]:
        """Return the hook radii found on an equilibrium path."""
        self.see(signals_of(states))
        return self.found

    def _add(
        self, limit: RatedLimit, signals: SignalColumns, t: float, radius: float, load: float, k: int | None
    ) -> None:
        stage = signals.stage_at(t, k)
        one = Reach(hook=limit.subject, stage=stage, t=t, radius=radius, load=load, capacity=limit.at(radius))
        first, most, last = self._found.setdefault((limit.subject, stage), [one] * 3)
        self._found[limit.subject, stage] = [
            one if t < first.t else first, one if one.use > most.use else most, one if t >= last.t else last
        ]  # fmt: skip

    @property
    def found(self) -> tuple[Reach, ...]:
        """The radii of each hook in each stage: at the beginning, at the end, and at the highest utilisation."""
        each = sorted(self._found.values(), key=lambda three: three[0].t)
        return tuple(
            msgspec.structs.replace(x, when=when) for three in each for when, x in zip(WHEN, three, strict=True)
        )
