"""Lifts of a yard: the scene that a step names, with the settings of a block, and the results of the lift.

By default a lift is followed along its equilibrium path, without dynamics. It may begin in winds up to the smallest
limit given by its scene, its machines and its factors; an interlock on the wind stops it and lets it continue.
"""

from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import cache
from hashlib import sha256
from math import inf
from pathlib import Path as FilePath
from typing import Literal, cast

import msgspec
from heavylift.kernel.cache import contents, read_cached, sources, write_cached
from heavylift.kernel.errors import HeavyliftError
from heavylift.nodes.plan.actions import Wait
from heavylift.nodes.plan.plan import Plan
from heavylift.nodes.scene import LoadedScene, load, parse
from heavylift.nodes.scene.text.files import files_read, scene_file, scene_text, state
from heavylift.nodes.scene.text.source import read

Way = Literal["rest", "table", "run"]
WAYS: dict[Way, str] = {
    "rest": "followed at rest", "table": "from a table of runs", "run": "simulated when it begins",
}  # fmt: skip


@dataclass(frozen=True)
class LiftOrder:
    """A lift to be evaluated: scene with settings, and `way`, the method that finds its duration.

    `over`: axes of a table of results, as names and values in text; `at`: position of the block on these axes; `windy`:
    highest wind speed in the search for wind limits [m/s] (0: no search)."""

    scene: str
    settings: tuple[str, ...]
    way: Way = "rest"
    over: tuple[tuple[str, tuple[str, ...]], ...] = ()
    at: tuple[float, ...] = ()
    grid: tuple[str, ...] = ()  # settings with an axis between NULs for its value
    windy: float = 0.0


@dataclass(frozen=True)
class Lift:
    """Results of a lift: durations of its stages [s], its wind limits [m/s], and the state of its verdict.

    Wind speeds up to which the lift may begin, above which it stops, and below which it continues; the state is "wrong"
    if its settings do not fit the scene, with the reason; relative errors of duration and wind."""

    stages: tuple[tuple[str, float], ...]
    wind: float = inf
    stop: float = inf
    resume: float = inf
    state: str = "green"
    why: str = ""
    error: float = 0.0
    wind_error: float = 0.0

    @property
    def seconds(self) -> float:
        """Total duration of all stages [s]."""
        return sum(seconds for _, seconds in self.stages)


Lifter = Callable[[Sequence[LiftOrder]], list[Lift]]


def of_scene(order: LiftOrder) -> LoadedScene:
    """Return the loaded scene of a lift; raises SceneError if the scene is invalid."""
    return load(order.scene, order.settings)


def cranes(scene: str) -> dict[str, str]:
    """Return the types of the cranes in a scene, by crane name; raises SceneError if the scene cannot be read."""
    loaded = load(scene)
    found = read(loaded.merged or loaded.text, loaded.path.name).data
    machines = cast("dict[str, dict[str, object]]", found.get("cranes") or {})
    return {name: str(keys.get("type", "")) for name, keys in machines.items()}


def winds(plan: Plan, factor: float | None) -> tuple[float, float, float]:
    """Return the wind speeds [m/s] up to which a lift may begin, above which it stops, and below which it continues."""
    stated = [x.value for x in plan.limits if x.quantity == "wind" and x.value is not None]
    trips = [x for x in plan.interlocks if x.rising and any(guard.quantity == "wind" for guard in x.guards)]
    allowed = min([*stated, *(x.value for x in trips), *([factor] if factor else [])], default=inf)
    stop = min((x.value for x in trips), default=allowed)
    return allowed, stop, min([*(x.resets for x in trips), stop])


def at_rest(order: LiftOrder) -> Lift:
    """Return the results of a lift computed statically along its equilibrium path; red if the lift is impossible."""
    try:
        scene = of_scene(order)
    except HeavyliftError as error:
        return Lift((), state="wrong" if str(error).startswith("--set") else "red", why=first_line(error))
    limits, path = winds(scene.plan, scene.scene.factors.wind if scene.scene.factors else None), scene.statics
    red = [x.sentence for x in scene.findings if x.state == "red"]
    if path.why or red:
        return Lift((), *limits, "red", path.why or red[0])
    begins = [(scene.plan.actions[n].stage, acted.t) for n, acted in enumerate(path.acted)]
    waits = [x.seconds for x in scene.plan.actions[-1].orders if isinstance(x, Wait)]
    end = max(path.states[-1].t, path.acted[-1].t + max(waits, default=0.0))
    ends = [t for _, t in begins[1:]] + [end]
    stages = tuple((name, after - t) for (name, t), after in zip(begins, ends, strict=True))
    return Lift(stages, *limits)


def first_line(error: Exception) -> str:
    """Return the first line of an error message, without file, line and column."""
    text = str(error).splitlines()[0]
    return text.partition("error: ")[2] or text


def kept(orders: Sequence[LiftOrder], code: bytes, find: Callable[[], list[Lift]]) -> list[Lift]:
    """Return the cached result of `find` for the same lifts, code and input files; if there is none, compute it."""
    scenes = dict.fromkeys(order.scene for order in orders)
    files = [(path, state(path)) for name in scenes for path in files_of(name, orders[0].settings)]
    answer = msgspec.msgpack.encode([list(orders), files])
    name = f"{sha256(programs() + code + answer).hexdigest()}.lifts"
    if data := read_cached(name):
        return msgspec.msgpack.decode(data, type=list[Lift])
    found = find()
    write_cached(name, msgspec.msgpack.encode(found))
    return found


def files_of(scene: str, settings: tuple[str, ...]) -> tuple[str, ...]:
    """Return the paths of all files from which a scene is built."""
    path = scene_file(scene).resolve()
    return (str(path), *_named(str(path), scene_text(path, scene), settings))


@cache
def _named(path: str, text: str, settings: tuple[str, ...]) -> tuple[str, ...]:
    with files_read() as named, suppress(HeavyliftError):
        parse(text, path, settings, passing=True, followed=False)
    return tuple(sorted(named))


@cache
def programs() -> bytes:
    """Return a hash of all code and machine types on which the results of lifts depend."""
    return sources() + contents(FilePath(__file__).parent.parent, ".py", ".yaml")


def all_at_rest(orders: Sequence[LiftOrder]) -> list[Lift]:
    """Return the results of lifts, computed statically along equilibrium paths, only once for equal lifts."""
    found = {order: at_rest(order) for order in dict.fromkeys(orders)}
    return [found[order] for order in orders]


def rested(orders: Sequence[LiftOrder]) -> list[Lift]:
    """Return the results of lifts computed statically along their equilibrium paths, from the cache if possible."""
    return kept(orders, b"", lambda: all_at_rest(orders))
