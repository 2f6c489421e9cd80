"""The figures of a run that a planner asks for: one number each, with its unit, comparable between runs of a scene.

rope tension    peak of each rope that carries                                                          [N]
lift-off time   end of each stage that lifts the block off                                              [s]
swing           amplitude [m or rad] and period [s] of the sinusoid that fits best, in each stage that only waits
position        of the block, or of each joint that moves, at the end                                   [m or rad]
"""

from __future__ import annotations

from collections import Counter
from typing import NamedTuple

import numpy as np
from heavylift.coordinator.tradeoff.playing import Shown, spans
from heavylift.coordinator.tradeoff.quantities import LOADED, STILL, swing
from heavylift.nodes.fidelity.lifts import lift_of
from heavylift.nodes.models import COMMANDER
from heavylift.nodes.plan.fidelity import Asked
from heavylift.nodes.plan.plan import Plan
from heavylift.recordings import Recording


class Figure(NamedTuple):
    """What it is, of which quantity, its unit and value; `scale`: what its errors are relative to."""

    name: str
    quantity: Asked
    unit: str
    value: float
    scale: float


def figures(shown: Shown, unit: str) -> list[Figure]:
    """All that a run shows; `unit`: of places."""
    found = [
        Figure(f"peak tension {rope}", "rope tension", "N", float(peak), float(peak))
        for rope, peak in zip(shown.ropes, shown.peaks, strict=True)
        if peak > LOADED
    ]
    for span in shown.spans:
        if span.lifts:
            found.append(
                Figure(f"lift-off, end of '{span.name}'", "lift-off time", "s", span.end, span.end - span.start)
            )
    for span in shown.spans:
        fitted = swing(shown, span, span.end - span.start) if span.free else None
        if fitted is not None:
            frequency, amplitude = fitted
            found.append(Figure(f"swing in '{span.name}', amplitude", "swing", unit, amplitude, amplitude))
            found.append(Figure(f"swing in '{span.name}', period", "swing", "s", 1.0 / frequency, 1.0 / frequency))
    ways = np.abs(shown.places - shown.places[0]).max(axis=0, initial=0.0) if len(shown.places) else []
    way = float(np.linalg.norm(ways)) if len(ways) else 0.0
    for column, own, value in zip(shown.columns, ways, shown.places[-1] if len(ways) else (), strict=True):
        if own > STILL:
            found.append(Figure(f"{column} at the end", "position", unit, float(value), way))
    return _told_apart(found)


def recorded(plan: Plan, rec: Recording) -> Shown:
    """What a recorded run of a plan shows, as `play` tells it of one that is not recorded."""
    stages = [(e.t_ns * 1e-9, e.value["action"], e.value["name"]) for e in rec.events(COMMANDER, "stage")]
    names = rec.columns("rope/tension") if "rope/tension" in rec.signals() else []
    place = f"pose/{lift_of(plan).block.name}" if lift_of(plan).block else "joint/position"
    ropes = [rope.name for rope in lift_of(plan).rig.hook_ropes] if lift_of(plan).lift else names
    columns = rec.columns(place)[:3] if lift_of(plan).block else rec.columns(place) if place in rec.signals() else []
    tension = rec.signal("rope/tension") if names else None
    at = rec.signal(place) if columns else None
    one = tension or at
    t = one.t if one else np.zeros(0)
    peaks = rec.fact("peaks", {})
    return Shown(
        spans(plan, stages, rec.fact("sim_s", 0.0)),
        t,
        ropes,
        tension.values[:, [names.index(rope) for rope in ropes]] if tension else np.zeros((len(t), 0)),
        np.array([peaks[rope]["tension"] for rope in ropes]),
        at.values[:, : len(columns)] if at else np.zeros((len(t), 0)),
        columns,
    )


def _told_apart(found: list[Figure]) -> list[Figure]:
    """With a number behind names that come again, such as those of stages of one name."""
    seen = Counter[str]()
    out = []
    for figure in found:
        seen[figure.name] += 1
        n = seen[figure.name]
        out.append(figure._replace(name=f"{figure.name} ({n})") if n > 1 else figure)
    return out
