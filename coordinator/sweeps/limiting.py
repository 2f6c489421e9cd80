"""Search for the largest or smallest value of a number before the verdict turns red.

Starts at a green value and doubles the distance at each step until a value is red or refused; then searches between the
last green and the first red value, where the utilisation is interpolated to 100 %, or by bisection if it is not known.
The limit lies between the two; values beyond it are checked at a few places, as a scene that is green again there has
no single limit.
"""

import logging
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from itertools import count
from math import hypot, inf, isfinite, nan

from heavylift.coordinator.ladder.choosing import level_of
from heavylift.coordinator.ladder.looking import as_it_is
from heavylift.coordinator.ladder.measuring import Measuring
from heavylift.coordinator.supervision.pool import Pool, cores
from heavylift.kernel.description.findings import STATES, State, clock
from heavylift.kernel.errors import HeavyliftError, SceneError
from heavylift.nodes.plan.fidelity import USUAL
from heavylift.nodes.scene import LoadedScene
from heavylift.nodes.scene.inputs import inputs, uncertain_inputs, unstated
from heavylift.nodes.scene.loading import parse
from heavylift.nodes.scene.text.spelling import range_of

from .axes import Axis, Variant, axes_of
from .motions import motion_of, motions
from .seeds import SeaRuns, check_seeds
from .variant import Row, Task, first_sentence, played

LOG = logging.getLogger("heavylift.sweeps")
NEAR = 0.005  # of the way from the start: how near the last green and the first red value shall be
OVERSHOOT = 0.4  # of that, by which a guess lies on one side of where the use is 100 %, so that the other one follows
STEPS, BEYOND = 8, 3  # doublings without an end of the range; values that are looked at beyond the limit
REPORTED = ("status", "use", "limit", "limit stage", "limit at [s]", "sentence")  # of a run
FAR = 10.0  # times as fast, or so many scales away, where no range is given


@dataclass(frozen=True)
class FoundLimit:
    """Result of a search for the value of a number beyond which the verdict turns red.

    `path`, `unit`: of the number; `runs`: all values with the rows of their runs; `green`: the last value with a green
    verdict; `red`: the first with a red one, or with the state in `fails`; `wrong`: what went wrong ("" if nothing).

    `bar`: error estimate of the utilisation at the last green value, from tighter steps and the next finer model level,
    at 95 %; None if no utilisation turns the verdict red, or if there is no limit.
    """

    path: str
    unit: str
    runs: dict[float, Row] = field(default_factory=dict)
    green: float | None = None
    red: float | None = None
    wrong: str = ""
    bar: float | None = None
    fails: State = "red"

    @property
    def most(self) -> Row:
        """Results of the run with the last value of the varied number at which the verdict is green."""
        return {} if self.green is None else self.runs.get(self.green, {})

    @property
    def half(self) -> float | None:
        """Half-width of the found limit's uncertainty, in the unit of the varied number; None if unknown."""
        if self.bar is None or self.green is None or self.red is None:
            return None
        name = f"use/{self.runs[self.red]['limit']}"
        more = self.runs[self.red][name] - self.most[name]
        return self.bar * abs(self.red - self.green) / more if more > 0.0 else None

    @property
    def why(self) -> str:
        """The reason for the red verdict at the first red value of the varied number."""
        if self.red is None:
            return ""
        row = self.runs[self.red]
        return reason(row) + ("; let the run last longer, --set 'end=...'" if row.get("unfinished") else "")

    @property
    def limit(self) -> str:
        """The last value of the varied number at which the verdict is green, with its uncertainty, as text."""
        return self.shown(self.green, "" if self.half is None else f" +- {self.half:.2g}")

    @property
    def used(self) -> str:
        """The largest utilisation in the run with the found limit value, with its uncertainty, as text."""
        return f"{self.most['use']:.1%}" + ("" if self.bar is None else f" +- {self.bar:.2%}")

    def shown(self, value: float | None, bar: str = "") -> str:
        """Return a value of the varied number with its unit as text; "" for None."""
        return "" if value is None else f"{value:.5g}{bar} {self.unit}".strip()

    def __str__(self) -> str:
        if self.wrong:
            return f"{self.path}: {self.wrong}"
        most, message = self.most, ""
        if isfinite(most.get("use", nan)):
            t = most["limit at [s]"]  # none of a design load
            when = f"in stage '{most['limit stage']}'{'' if t is None else f' at {clock(t, 1)}'}"
            message = f", governed by {most['limit']} ({self.used}) {when}"
        passes = "green" if self.fails == "red" else f"better than {self.fails}"
        return f"{self.path}: {passes} up to {self.limit}{message}; {self.fails} at {self.shown(self.red)}: {self.why}"

    def data(self) -> dict[str, object]:
        """Return the result of the search as plain data, with numbers in the unit of the varied number."""
        keys = ("path", "unit", "green", "red", "half", "bar", "why", "wrong")
        return {key: getattr(self, key) for key in keys} | {
            "runs": [{"value": x} | {key: row.get(key) for key in REPORTED} for x, row in sorted(self.runs.items())]
        }


def reason(row: Row) -> str:
    """Return why a run is red or refused: the first sentence of its message, or else its status."""
    text = str(row.get("verdict") or row["sentence"])
    first = next((line for line in text.splitlines() if line), str(row["status"]))
    return first_sentence(first.partition("; worst: ")[2] or first)


def askable(scene: LoadedScene) -> list[str]:
    """Return the names of all numbers that `--all` varies: speeds and accelerations of moves, and inputs of the
    scene."""
    names = [*(one.name for one in uncertain_inputs(scene)), *unstated(scene, uncertain_inputs(scene))]
    return [*motions(scene), *dict.fromkeys(x for name in names for x in _numbers(scene, name))]


def _numbers(scene: LoadedScene, name: str) -> list[str]:
    """Return the inputs with this name, or with its axes x, y, z, that have a value."""
    found = []
    for each in (name, *(f"{name}.{axis}" for axis in "xyz")):
        try:
            found += [one.name for one in inputs(scene, [each])]
        except SceneError:
            continue
    return found


def limits_of_all(
    scene: LoadedScene,
    asked: Sequence[str],
    limit_s: float = 60.0,
    workers: int = 0,
    say: Callable[[str], None] = LOG.info,
    fails: State = "red",
    replications: int = 0,
) -> list[FoundLimit]:
    """Find the limits of several numbers of a scene, each varied alone, in parallel processes.

    `say` reports the runs; `fails`: the mildest state that ends a search; `replications`: number of seeds with which
    each value is run.
    """

    def message(name: str, value: str, row: Row) -> None:
        status = str(row["state"] if row["status"] == "done" else row["status"])
        if status not in STATES or STATES.index(status) <= STATES.index(fails):
            status += f": {reason(row)}"
        say(f"  {name.partition('=')[0]} {value}: {status}")

    scene = level_of(scene, say)
    if replications:
        check_seeds(scene, replications)
        with Pool(workers or cores()) as pool:
            runs = SeaRuns(scene, range(1, replications + 1), limit_s, pool)
            return [limits_of(scene, name, limit_s, partial(message, name), fails, runs) for name in asked]
    if len(asked) == 1:
        return [limits_of(scene, asked[0], limit_s, partial(message, asked[0]), fails)]
    found = []
    with Pool(min(workers or cores(), len(asked))) as pool:
        task = Task.of(scene, limit_s, "none", True)
        for name, future in [(name, pool.submit(_apart, task, name, fails)) for name in asked]:
            found.append(future.result())
            say(f"  {name.partition('=')[0]}: {len(found[-1].runs)} runs")
    return found


def _apart(task: Task, asked: str, fails: State) -> FoundLimit:
    return limits_of(parse(task.text, task.name, task.settings), asked, task.limit_s, fails=fails)


def limits_of(
    scene: LoadedScene,
    asked: str,
    limit_s: float = 60.0,
    watch: Callable[[str, Row], None] = lambda value, row: None,
    fails: State = "red",
    seas: SeaRuns | None = None,
) -> FoundLimit:
    """Find the limit of a number in a scene; raises SceneError if the path does not lead to a number.

    `asked`: `PATH`, or within a range `PATH=FROM..TO UNIT`.

    `seas`: runs over several seeds, in place of a single run for each value.
    """
    axis, start, end = _range(scene, asked)
    task, runs = Task.of(scene, limit_s, "none", True), dict[float, Row]()

    def settings(x: float) -> tuple[str, ...]:
        return tuple(axis.setting(f"{x!r} {axis.unit}".strip()))

    def green(x: float) -> bool:
        if x not in runs:
            runs[x] = seas.row(settings(x)) if seas else played(task, Variant(len(runs), settings(x), (x,)))
            watch(found.shown(x), runs[x])
        if runs[x]["status"] in ("cut", "lost"):
            raise SceneError(f"--of '{asked}': at {x:g} {axis.unit}: {runs[x]['sentence']}")
        return runs[x]["status"] == "done" and STATES.index(runs[x]["state"]) > STATES.index(fails)

    found = FoundLimit(axis.path, axis.unit, runs, fails=fails)
    if not green(start):
        red = replace(found, red=start)
        return replace(red, wrong=f"{fails} at the start, {found.shown(start)}: {red.why}")
    distance = end - start
    low, high, step = 0.0, 0.0, 1.0 / 2**STEPS  # parts of the way
    while high < 1.0 and green(start + high * distance):
        low, high, step = high, min(1.0, high + step), 2.0 * step
    if green(start + high * distance):
        message = f"no value up to {found.shown(end)} is {fails}; give a larger range"
        return replace(found, green=end, wrong=message)
    near = NEAR * high
    for turn in count():
        if high - low <= near:
            break
        middle = _guess(runs[start + low * distance], runs[start + high * distance], low, high, near, turn)
        low, high = (middle, high) if green(start + middle * distance) else (low, middle)
    at, red_at = start + low * distance, start + high * distance
    beyond = [start + (high + (1.0 - high) * (i + 1) / BEYOND) * distance for i in range(BEYOND)] if high < 1.0 else []
    again = next((x for x in beyond if green(x)), None)
    message = (
        "" if again is None else f"{fails} at {found.shown(red_at)}, but green again at {again:.5g}: no single limit"
    )
    bar = None if seas else _bar(task, settings(at), runs[at], runs[red_at])
    return replace(found, green=at, red=red_at, wrong=message, bar=bar)


def _guess(good: Row, bad: Row, low: float, high: float, near: float, turn: int) -> float:
    """Estimate the limit by interpolation to 100 % utilisation, a little beyond; every third time by the midpoint."""
    name = f"use/{bad.get('limit')}"
    a, b = float(good.get(name, nan)), float(bad.get(name, nan))
    if turn % 3 == 2 or not a < 1.0 < b:
        return 0.5 * (low + high)
    found = low + (1.0 - a) / (b - a) * (high - low) + (OVERSHOOT if turn % 3 else -OVERSHOOT) * near
    return min(max(found, low + 0.1 * near), high - 0.1 * near)


def _bar(task: Task, settings: tuple[str, ...], good: Row, bad: Row) -> float | None:
    """Return the error estimate of the governing utilisation: twice the change by tighter steps, plus the change by the
    full model level; None if it has none."""
    name = bad.get("limit")
    if not name or not bad["use"] > 1.0 or f"use/{name}" not in good:
        return None
    plan = parse(task.text, task.name, (*task.settings, *settings), passing=True).plan
    measuring = Measuring(["limits", "clearance"], lambda: task.limit_s)
    try:
        look = as_it_is(plan, USUAL, measuring)
        figure = measuring.figures(look.candidate)[f"use of {name}"]
    except (HeavyliftError, KeyError):
        return None
    return figure.scale * hypot(*(errors.get(figure.name, inf) for errors in (look.steps, look.model) if errors))


def _range(scene: LoadedScene, asked: str) -> tuple[Axis, float, float]:
    """Return the axis, the start of the search and its bound, in the unit."""
    path, equals, values = (part.strip() for part in asked.partition("="))
    if equals:
        ends = range_of(values)
        if ends is None:
            raise SceneError(f"--of '{asked}': write PATH, or PATH=FROM..TO UNIT such as 'block.mass=300..900 t'")
        first, last, unit = ends.low, ends.high, ends.unit
        down = float(first) > float(last)
        try:
            (axis,) = axes_of(scene, [f"{path}={last}..{first} {unit}" if down else asked], sampling=True)[:1]
        except SceneError as error:
            message = str(error).replace("; give a higher end and a positive step", "")  # here it may lead downwards
            raise SceneError(message.replace("--vary '", "--of '")) from None
        return (axis, axis.high, axis.low) if down else (axis, axis.low, axis.high)
    if (motion := motion_of(scene, path)) is not None:
        return Axis(path, unit=motion.unit, motion=motion), motion.value, FAR * motion.value
    try:
        one = inputs(scene, [path])[0]
    except SceneError as error:
        moves = f"; of moves: {', '.join(names)}" if (names := motions(scene)) else ""
        message = f"{error}; for a number within an order give its range, 'stage up/all hooks/hoist=1..20 m/min'{moves}"
        raise SceneError(f"--of '{asked}': {message}") from None
    start, far = one.value / one.factor, one.scale / one.factor
    end = min(start + FAR * far, one.bounds[1] / one.factor)
    return Axis(path, unit=one.unit, first=one.whole), start, end
