"""Durations and wind limits of a yard's lifts from mechanics: from statics, from a table of runs, or from a simulation
when the lift begins.

A table has the durations of all stages, and the wind up to which a run is green, at all combinations of its axes'
values; between them both are interpolated linearly along each axis. The error of the table is twice its largest
difference from runs in the middle of its cells; the error of statics is found from runs of three lifts. All results are
cached.
"""

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import cache, lru_cache
from itertools import product
from math import inf, isfinite
from pathlib import Path
from typing import Any

import numpy as np
from heavylift.coordinator.supervision.pool import Pool, cores
from heavylift.coordinator.sweeps.axes import Variant
from heavylift.coordinator.sweeps.limiting import NEAR, limits_of, reason
from heavylift.coordinator.sweeps.variant import Task, played
from heavylift.kernel.cache import contents
from heavylift.kernel.errors import HeavyliftError
from heavylift.nodes.scene import load
from heavylift.nodes.scene.text.spelling import number_and_unit
from heavylift.nodes.yard.lifts import Lift, LiftOrder, at_rest, first_line, kept

LIMIT_s = 600.0  # wall time of a run
ACCURATE = 1e-4  # of a duration, to which a run is right: its events, found at the tolerance of the integration
SPOTS = 4  # cells of a table that are checked, at most
FEW = 8  # lifts at rest that need no pool
LEAST_WIND = "1"  # m/s, from which limits are looked for


def lifter(orders: Sequence[LiftOrder]) -> list[Lift]:
    """Return duration, wind limits and verdict of all lifts of a yard, from the cache if possible."""
    return kept(orders, code(), lambda: found(orders))


@cache
def code() -> bytes:
    """Return a hash of the code that simulates and checks lifts."""
    return contents(Path(__file__).parent.parent, ".py")


def found(orders: Sequence[LiftOrder]) -> list[Lift]:
    """Compute duration, wind limits and verdict of all lifts of a yard; equal lifts are computed only once."""
    alone = [*dict.fromkeys(orders)]
    lifts = dict(zip(alone, called(at_rest, alone), strict=True))
    for way in dict.fromkeys((order.scene, order.way, order.grid, order.over, order.windy) for order in alone):
        own = [x for x in alone if (x.scene, x.way, x.grid, x.over, x.windy) == way and lifts[x].state != "wrong"]
        if way[1] == "table":
            lifts |= tabled(own, lifts)
        elif way[1] == "rest":
            lifts |= compared(own, lifts)
    return [lifts[order] for order in orders]


def compared(orders: Sequence[LiftOrder], lifts: dict[LiftOrder, Lift]) -> dict[LiftOrder, Lift]:
    """Return statically computed lifts with the error of their durations, estimated by simulating three of them."""
    able = sorted((x for x in orders if lifts[x].stages), key=lambda x: (lifts[x].seconds, x.settings))
    spots = [*dict.fromkeys(able[n] for n in (0, len(able) // 2, -1))] if able else []
    errors = [_apart(run.seconds, lifts[x].seconds) for x, run in zip(spots, called(ran, spots), strict=True)]
    return {x: replace(lifts[x], error=stated(errors)) for x in able}


def tabled(orders: Sequence[LiftOrder], lifts: dict[LiftOrder, Lift]) -> dict[LiftOrder, Lift]:
    """Return lifts with verdicts from statics, and with durations and wind limits interpolated between simulated
    runs."""
    if not orders:
        return {}
    one = orders[0]
    axes = [np.array([float(number_and_unit(text)[0]) for text in texts]) for _, texts in one.over]
    nodes = [*product(*(texts for _, texts in one.over))]
    cells = [*product(*(range(len(axis) - 1) for axis in axes))]
    cells = [cells[round(n * (len(cells) - 1) / max(1, SPOTS - 1))] for n in range(min(SPOTS, len(cells)))]
    units = [number_and_unit(texts[0])[1] for _, texts in one.over]
    spots = [tuple(float(axis[n] + axis[n + 1]) / 2 for axis, n in zip(axes, cell, strict=True)) for cell in cells]
    texts = [tuple(f"{x!r} {unit}" for x, unit in zip(spot, units, strict=True)) for spot in spots]
    made = called(ran, [_at(one, node) for node in [*nodes, *texts]])
    known, checked = made[: len(nodes)], made[len(nodes) :]
    names = next((tuple(name for name, _ in lift.stages) for lift in known if lift.stages), ())
    shape = (*(len(axis) for axis in axes), -1)
    rows = [[s for _, s in x.stages] if len(x.stages) == len(names) else [np.nan] * len(names) for x in known]
    grid = np.array([[*row, x.wind] for row, x in zip(rows, known, strict=True)]).reshape(shape)
    errors, wind_errors = list[float](), list[float]()
    for spot, lift in zip(spots, checked, strict=True):
        at = interpolated(axes, grid, spot)
        if lift.stages and isfinite(sum(at[:-1])):
            errors.append(_apart(lift.seconds, sum(at[:-1])))
            wind_errors.append(_apart(lift.wind, at[-1]) if isfinite(lift.wind) else 0.0)
    result = dict[LiftOrder, Lift]()
    for order in orders:
        at, own = interpolated(axes, grid, order.at), lifts[order]
        if own.state == "red" or not names or not isfinite(sum(at[:-1])):
            why = own.why or next((x.why for x in known if x.state == "red"), "")
            result[order] = replace(own, stages=(), state="red", why=why)
            continue
        stages, most = tuple(zip(names, at[:-1], strict=True)), at[-1] if one.windy else inf
        begin, stop, resume = (min(x, most) for x in (own.wind, own.stop, own.resume))
        within = replace(own, error=stated(errors), wind_error=stated(wind_errors) + NEAR if one.windy else 0.0)
        result[order] = replace(within, stages=stages, wind=begin, stop=stop, resume=resume)
    return result


def stated(differences: Sequence[float]) -> float:
    """Return the stated relative error of computed durations: twice their largest difference to simulations, plus that
    of simulations (`ACCURATE`)."""
    return 2.0 * max(differences, default=0.0) + ACCURATE


def interpolated(axes: Sequence[Any], grid: Any, at: Sequence[float]) -> list[float]:
    """Interpolate a table (n1, n2, ..., m) linearly along each axis; return the m values at a point."""
    for axis, x in zip(axes, at, strict=True):
        n = min(max(int(np.searchsorted(axis, x)) - 1, 0), len(axis) - 2)
        part = (x - float(axis[n])) / float(axis[n + 1] - axis[n])
        grid = grid[n] if part == 0.0 else grid[n + 1] if part == 1.0 else grid[n] + part * (grid[n + 1] - grid[n])
    return [float(x) for x in grid]


def _at(order: LiftOrder, node: Sequence[str]) -> LiftOrder:
    """Return the order of the lift at a node of its table."""
    settings = tuple(order.grid)
    for (axis, _), text in zip(order.over, node, strict=True):
        settings = tuple(setting.replace(f"\0{axis}\0", text) for setting in settings)
    return LiftOrder(order.scene, settings, windy=order.windy)


def ran(order: LiftOrder, wind: float = -1.0) -> Lift:
    """Simulate a lift and return it with duration, verdict and wind limit.

    `wind`: wind speed [m/s]; -1 for the wind that the scene states.
    """
    at = at_rest(order)
    settings = (*order.settings, *([f"wind.speed={wind!r} m/s"] if wind >= 0 else []))
    try:
        scene = load(order.scene, settings)
        row = played(Task.of(scene, LIMIT_s, "none", True), Variant(0, (), ()))
        stages = tuple((key[6:-4], float(x)) for key, x in row.items() if key.startswith("stage/"))
        if row["status"] in ("refused", "failed", "cut"):
            return replace(at, stages=(), state="red", why=first_line(row["sentence"]))
        state, why = ("red", reason(row)) if row["status"] == "red" else ("green", "")
        limit = at.wind
        if order.windy and state == "green":
            search = limits_of(scene, f"wind.speed={LEAST_WIND}..{order.windy!r} m/s", LIMIT_s)
            limit = min(limit, search.green or 0.0)
        return replace(at, stages=stages, wind=limit, state=state, why=why)
    except HeavyliftError as error:
        return replace(at, stages=(), state="red", why=first_line(error))


@lru_cache(4096)
def _simulated(order: LiftOrder, wind: float) -> Lift:
    return kept([order], repr(wind).encode() + code(), lambda: [ran(order, wind)])[0]


def in_place(order: LiftOrder, wind: float) -> Lift:
    """Simulate a lift that begins now in this wind [m/s]; if the run fails, return the statically computed duration."""
    found = _simulated(replace(order, windy=0.0), wind if windy(order.scene) else -1.0)
    return found if found.stages else replace(at_rest(order), state="red", why=found.why)


@lru_cache
def windy(scene: str) -> bool:
    """Return whether a scene has wind."""
    return bool(load(scene).scene.wind)


def called(call: Callable[[LiftOrder], Lift], orders: Sequence[LiftOrder]) -> list[Lift]:
    """Call a function for each lift order, in a process pool if there are many, and return the results in order."""
    if len(orders) <= (FEW if call is at_rest else 1) or cores() == 1:
        return [call(order) for order in orders]
    with Pool(min(cores(), len(orders))) as pool:
        return [*pool.map(call, orders, chunksize=4 if call is at_rest else 1)]


def _apart(x: float, y: float) -> float:
    """Return the difference of y from x, relative to x."""
    return abs(y - x) / x if x else 0.0
