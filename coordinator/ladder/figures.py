"""Results of a run as figures (single numbers) that can be compared between runs of a scene (`nodes.plan.fidelity`).

Peaks are taken from the integrator's continuous output, and stages begin at events. Figures from samples (swings,
positions, support forces, clearances, utilisations of limits) are also computed from every second sample; the
difference is the reading error. A swing faster than the sampling rate appears slow in the positions; the sampled speeds
reveal it.
"""

from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from math import dist, hypot, inf
from typing import NamedTuple

import numpy as np
from heavylift.coordinator.record.in_memory import Judge, Played
from heavylift.kernel.description.mechanics import JOINTS
from heavylift.nodes.plan.actions import LiftedCondition, Move, Wait
from heavylift.nodes.plan.fidelity import ASKABLE, SHORTEST, Asked
from heavylift.nodes.plan.limit import Use
from heavylift.nodes.plan.plan import Plan
from heavylift.recordings.read.verdict import RecordedVerdict

from .swings import Floats, Span, swing, top, unseen

WHOLE = "the whole run"
LOADED = 1.0  # [N] a peak below it is that of what never carries
SMALL = 0.01  # [m or rad] of ways: errors of smaller ones are relative to it, and of swings, as angles of hook ropes
SWUNG = 0.1  # [m] the same of swings of what no hook lifts
NEAR = 0.1  # [m] the same of clearances
PART = 0.1  # of the largest swing, and of forces a tenth of that: what is smaller is relative to that
THIRD = 3.0  # of what twice the distance of samples changes, they leave open: errors fall with its square, at least


class AskedFigure(NamedTuple):
    """A single result number of a run, such as a peak tension, with its unit and its reading error due to sampling.

    `asked`: whether it is large enough to count; one that does not is compared with runs in which it counts.
    """

    name: str
    quantity: Asked
    unit: str
    value: float
    scale: float
    misread: float = 0.0
    asked: bool = True


@dataclass(frozen=True)
class RunSeries:
    """Results of a run from which its result figures are computed.

    Stages; peak tensions [N]; times (n,) [s]; positions (n, 3) [m] of lifted bodies and coordinates (n, 1) by name,
    with units; support forces (n,) [N]; speeds (n,) of places.
    """

    spans: list[Span]
    peaks: dict[str, float]
    t: Floats = field(default_factory=lambda: np.zeros(0))
    places: dict[str, tuple[Floats, str]] = field(default_factory=dict)
    supports: dict[str, Floats] = field(default_factory=dict)
    speeds: dict[str, Floats] = field(default_factory=dict)

    @classmethod
    def of(cls, run: Played) -> "RunSeries":
        """Return the results of a finished run from which figures are computed."""
        plan, layout = run.plan, run.layout
        # several rows at the instant of an event: the first one counts
        t, first = np.unique(run.t, return_index=True)
        forces = layout.find("support/force")
        channels = [(c.body, layout.find(f"pose/{c.body}")) for m in plan.machines for c in m.cargo]
        places = {name: (run.rows[first, x.start : x.start + 3], "m") for name, x in channels if x}
        if not places and (joints := layout.find("joint/position")):
            units = _units(plan)
            places = {
                name: (run.rows[first, joints.start + i, None], units.get(name.rpartition(".")[0] or name, "m or rad"))
                for i, name in enumerate(joints.names)
            }
        borne = {name: run.rows[first, forces.start + i] for i, name in enumerate(forces.names)} if forces else {}
        # pieces of a rope ("~") are not ropes of the scene
        peaks = {name: peak.tension for name, peak in run.peaks.items() if "~" not in name}
        stages = spans(plan, run.conduct.stages, run.end_ns * 1e-9)
        return cls(stages, peaks, t, places, borne, _speeds(run, run.rows[first]))

    def halved(self) -> "RunSeries":
        """Return the same results with every second sample only."""
        places = {name: (x[::2], unit) for name, (x, unit) in self.places.items()}
        supports, speeds = ({name: x[::2] for name, x in each.items()} for each in (self.supports, self.speeds))
        return RunSeries(self.spans, self.peaks, self.t[::2], places, supports, speeds)


def _speeds(run: Played, rows: Floats) -> dict[str, Floats]:
    """Return the speeds (n,) of free bodies and of coordinates, by name."""
    channel, found = run.layout.find("joint/velocity"), dict[str, Floats]()
    if channel is None:
        return found
    columns = {name: channel.start + i for i, name in enumerate(channel.names)}
    for joint in run.mechanics.joints:
        kind = JOINTS[joint.kind]
        v = [columns[f"{joint.name}.{name}"] for name in kind.velocities if f"{joint.name}.{name}" in columns]
        if len(v) < kind.n_v:  # a joint that closes a loop has no coordinates
            continue
        if kind.quaternion is None:
            found |= {f"{joint.name}.{c}": abs(rows[:, i]) for c, i in zip(kind.coordinates, v, strict=True)}
        elif kind.quaternion:  # behind a displacement, of which the velocity is in axes of the body
            found[joint.child] = np.hypot(np.hypot(rows[:, v[0]], rows[:, v[1]]), rows[:, v[2]])
    return found


def spans(plan: Plan, stages: list[tuple[float, int, str]], last: float) -> list[Span]:
    """Return the time span of each action of a run, or of the whole run if it has no action list or several of them."""
    if not stages or plan.lists:
        # lifts side by side have stages that overlap: figures are those of the whole run
        return [Span(WHOLE, 0.0, last, not plan.lists, False)]
    ends = [t for t, _, _ in stages[1:]] + [last]
    out = []
    for (t, index, name), end in zip(stages, ends, strict=True):
        orders = plan.actions[index].orders
        free = all(isinstance(order, Wait) for order in orders)
        lifts = any(isinstance(order, Move) and isinstance(order.until, LiftedCondition) for order in orders)
        out.append(Span(name or f"action {index + 1}", t, end, free, lifts))
    return out


def figures(run: Played, ask: Sequence[Asked] = ASKABLE) -> list[AskedFigure]:
    """Return the result figures of a run for these quantities."""
    shown = RunSeries.of(run)
    half = shown.halved()
    found = list[AskedFigure]()
    for quantity in ask:
        if quantity in READ:
            found += _misread(READ[quantity](run.plan, shown), READ[quantity](run.plan, half))
        else:
            found += judged(run.judge, [quantity])
    return found


def judged(judge: Judge, ask: Sequence[Asked] = ("limits", "clearance"), values: bool = False) -> list[AskedFigure]:
    """Return the result figures that come from the verdict of a run: utilisations of limits and the smallest clearance.

    If `values`, reading errors are omitted.
    """
    if values:
        return [f for quantity in ask for f in _numbered(_judged(quantity, *judge.fine))]
    return [f for quantity in ask for f in _misread(_judged(quantity, *judge.fine), _judged(quantity, *judge.coarse))]


def _misread(read: Iterator[AskedFigure], again: Iterator[AskedFigure]) -> Iterator[AskedFigure]:
    """Yield figures with their reading errors, which are the differences to the same figures from every second
    sample."""
    coarse = {f.name: f.value for f in _numbered(again)}
    return (f._replace(misread=f.misread + abs(f.value - coarse.get(f.name, inf)) / THIRD) for f in _numbered(read))


def _tensions(slings: bool) -> Callable[[Plan, RunSeries], Iterator[AskedFigure]]:
    def tensions(plan: Plan, shown: RunSeries) -> Iterator[AskedFigure]:
        ties = {tie.rope for machine in plan.machines for tie in machine.ties}
        own = {name: peak for name, peak in shown.peaks.items() if (name in ties) == slings}
        # ropes that carry little are relative to the largest, or their relative error would decide
        least = PART * PART * max(own.values(), default=0.0)
        for name, peak in own.items():
            if peak > LOADED:
                yield AskedFigure(f"peak tension {name}", QUANTITY[slings], "N", peak, max(peak, least))

    return tensions


def _durations(quantity: Asked) -> Callable[[Plan, RunSeries], Iterator[AskedFigure]]:
    def durations(plan: Plan, shown: RunSeries) -> Iterator[AskedFigure]:
        for span in shown.spans:
            lasts = span.end - span.start
            if span.lifts and quantity == "lift-off time":
                yield AskedFigure(
                    f"duration of '{span.name}', which lifts off", quantity, "s", lasts, max(SHORTEST, lasts)
                )
            elif quantity == "stage ends" and span.name != WHOLE:
                yield AskedFigure(f"duration of '{span.name}'", quantity, "s", lasts, max(SHORTEST, lasts))

    return durations


def _swings(plan: Plan, shown: RunSeries) -> Iterator[AskedFigure]:
    hung = [dist(*hook.ends) for machine in plan.machines for hook in machine.hooks if hook.ends]
    small = SMALL * min(hung) if hung else SWUNG
    for name, (x, unit) in shown.places.items():
        found = [(span, swing(shown.t, x, span)) for span in shown.spans if span.free]
        seen = [(span, s) for span, s in found if s is not None]
        scale = max([small if unit == "m" else SMALL, *(PART * s.amplitude for _, s in seen)])
        for span, s in seen:
            message = f"swing of {name} in '{span.name}'"
            hidden, most = unseen(shown.t, x, shown.speeds.get(name), span), max(scale, s.amplitude)
            yield AskedFigure(f"{message}, amplitude", "swing", unit, s.amplitude, most, hidden)
            if s.period:
                misread, asked = hidden / most * s.period, s.amplitude >= scale
                yield AskedFigure(f"{message}, period", "swing", "s", s.period, s.period, misread, asked)


def _positions(plan: Plan, shown: RunSeries) -> Iterator[AskedFigure]:
    ends = [*(span.start for span in shown.spans[1:]), shown.spans[-1].end]
    names = [f"as '{span.name}' begins" for span in shown.spans[1:]] + ["at the end"]
    for name, (x, unit) in shown.places.items():
        at = _at(shown.t, x, [0.0, *ends])
        distance = max(hypot(*(a - b)) for a in at for b in at)
        if distance < SMALL:
            continue
        for message, place in zip(names, at[1:], strict=True):
            for axis, value in zip("xyz" if len(place) == 3 else [""], place, strict=True):
                what = f"{axis} of {name}" if axis else name
                yield AskedFigure(f"{what} {message}", "position", unit, float(value), distance)


def _at(t: Floats, x: Floats, times: Sequence[float]) -> Floats:
    """Return values (m, columns) interpolated at `times`, by cubics through four samples."""
    out = []
    for at in times:
        i = min(max(int(np.searchsorted(t, at)) - 2, 0), max(0, len(t) - 4))
        s = t[i : i + 4]
        weights = [np.prod([(at - b) / (a - b) for b in s if b != a]) for a in s]
        out.append(np.array(weights) @ x[i : i + 4])
    return np.array(out)


def _supports(plan: Plan, shown: RunSeries) -> Iterator[AskedFigure]:
    tops = {name: top(shown.t, force) for name, force in shown.supports.items()}
    least = PART * PART * max(tops.values(), default=0.0)
    for name, force in tops.items():
        if force > LOADED:
            yield AskedFigure(f"largest force on {name}", "support load", "N", force, max(force, least))


def _judged(quantity: Asked, verdict: RecordedVerdict, uses: Sequence[Use]) -> Iterator[AskedFigure]:
    if quantity == "clearance" and verdict.clearances:
        least = min(verdict.clearances, key=lambda x: x.distance)
        yield AskedFigure("smallest clearance", quantity, "m", least.distance, max(NEAR, abs(least.distance)))
    for use in uses if quantity == "limits" else ():
        if use.use is not None:
            yield AskedFigure(
                f"use of {use.limit.subject} {use.limit.quantity}", quantity, "", use.use, max(1.0, use.use)
            )


def _units(plan: Plan) -> dict[str, str]:
    """Return the units of joint coordinates, for joints with one kind of coordinate."""
    found = {}
    for joint in (j for machine in plan.machines for j in machine.system.joints):
        kind = JOINTS[joint.kind]
        turns = {
            kind.turns(i) or i >= (kind.n_q if kind.quaternion is None else kind.quaternion) for i in range(kind.n_q)
        }
        found[joint.name] = "m or rad" if len(turns) > 1 else "rad" if True in turns else "m"
    return found


def _numbered(found: Iterator[AskedFigure]) -> list[AskedFigure]:
    seen = Counter[str]()
    out = []
    for figure in found:
        seen[figure.name] += 1
        n = seen[figure.name]
        out.append(figure._replace(name=f"{figure.name} ({n})") if n > 1 else figure)
    return out


QUANTITY: tuple[Asked, Asked] = ("rope tension", "sling tension")
READ: dict[Asked, Callable[[Plan, RunSeries], Iterator[AskedFigure]]] = {
    "rope tension": _tensions(slings=False),
    "sling tension": _tensions(slings=True),
    "swing": _swings,
    "position": _positions,
    "lift-off time": _durations("lift-off time"),
    "stage ends": _durations("stage ends"),
    "support load": _supports,
}
