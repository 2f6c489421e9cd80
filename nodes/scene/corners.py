"""Utilisations at the worst corner of a scene's uncertain inputs, and at the corners of the centre-of-mass box.

They are computed on the equilibrium path, first for each input alone, then at each corner that is the worst for some
limit. Loads are monotonic in each input, whatever the other inputs are, so the worst corner for a limit combines the
worse ends of all inputs. The factor sheet's contingencies of weight and centre of mass also count in the limits of what
bears the load but has no design load of its own: cranes, frames, assemblies of slings, ropes, ground.
"""

from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache, partial
from itertools import product
from math import isfinite, sqrt

import msgspec
import numpy as np
from heavylift.kernel.description.mechanics import Vector
from heavylift.kernel.errors import HeavyliftError
from heavylift.nodes.limits.factors import BASES, design_limits
from heavylift.nodes.limits.judging import uses_of
from heavylift.nodes.limits.signals import signals_of
from heavylift.nodes.plan.factors import Factors
from heavylift.nodes.plan.limit import STANDING, Quantity, RatedLimit, Use
from heavylift.nodes.scene.keys import schema
from heavylift.nodes.scene.keys.quantities import quantity_at
from heavylift.nodes.scene.text.source import Data, Path, shown
from heavylift.nodes.scene.text.spelling import unit_in
from heavylift.nodes.scene.text.uncertainty import Stated, standard
from heavylift.recordings.format.spellings import BEAM_LOAD

from .loaded_scene import LoadedScene, on_same_path

NOISE = 1e-6  # of a use: less is rounding
AT_REST = {"sling peak": ("sling tension",), "rope peak": ("rope factor", "rope tension", "hook load")}  # alike there
BEARING: tuple[Quantity, ...] = (  # the lifted load, without a design load
    "trolley load", "crane load", "tandem load", "frame load", BEAM_LOAD, "assembly load", "support load",
    "sling tension", "rope tension", "rope factor", "rope peak", "drum pull", "drive moment", "brake moment",
    "interlock", *STANDING,
)  # fmt: skip
FACTORED: tuple[Quantity, ...] = (*BASES.values(), "tandem load")  # whose loads at rest become design loads
Key = tuple[str, str]  # subject and quantity of a limit
Values = Mapping[Path, Data]
Centres = Mapping[Path, Vector]  # of mass, of blocks [m]
Build = Callable[[Values], LoadedScene]  # the scene with other values
Sizes = Callable[[LoadedScene], dict[Key, float]]


@dataclass(frozen=True)
class Ends:
    """Both ends of the range of an uncertain input, as text with units."""

    path: Path
    message: str
    texts: tuple[str, str]


def ends_of(scene: schema.Scene, stated: Mapping[Path, Stated]) -> list[Ends]:
    """Return both ends of each uncertain input's range: its 95 % interval or, if uniform, its bounds."""
    found = []
    for path, each in stated.items():
        at = quantity_at(scene, path)
        if at is None:
            continue
        value, quantity = at
        half = standard(each, quantity) * (sqrt(3.0) if each.kind == "uniform" else 2.0)
        units = quantity.dimension.units
        unit = unit_in(each.value, units)
        texts = (f"{x / float(units[unit])!r} {unit}".strip() for x in (value - half, value + half))
        low, high = texts
        how = "+-" if each.kind == "uniform" else each.how
        found.append(Ends(path, f"{shown(path)} {each.value.strip()} {how} {each.half}", (low, high)))
    return found


def with_centres(scene: schema.Scene, centres: Centres) -> schema.Scene:
    """Return a scene with other centres of mass of its blocks."""
    moved = {path: block.model_copy(update={"com": centres[path]}) for path, block in _blocks(scene).items()}
    blocks = {name: moved["blocks", name] for name in scene.blocks}
    return scene.model_copy(update={"blocks": blocks, "block": moved.get(("block",))})


def _shifted(place: Vector, way: Sequence[float]) -> Vector:
    x, y, z = (a + d for a, d in zip(place, way, strict=True))
    return x, y, z


def _blocks(scene: schema.Scene) -> dict[Path, schema.Block]:
    """Return the blocks of a scene by their paths."""
    blocks: dict[Path, schema.Block] = {("blocks", name): block for name, block in scene.blocks.items()}
    return blocks | ({("block",): scene.block} if scene.block else {})


def rated(
    nominal: LoadedScene,
    scene: schema.Scene,
    ends: Sequence[Ends],
    build: Build,
    shift: Callable[[Centres], LoadedScene],
) -> list[RatedLimit]:
    """Return the limits of a scene and of its design loads, with the increase of utilisation at the worst corner.

    Corners are those of the uncertain inputs and of the contingencies of weight and centre of mass; one that cannot be
    evaluated adds a limit without a value. `build` and `shift` make the scene with other inputs and centres of mass."""
    stated = scene.practice is not None or bool(scene.factors.model_fields_set)
    if not (ends or stated or any(limit.rigging for limit in nominal.plan.limits)):
        return [*nominal.plan.limits]
    usual = nominal if ends else with_limits(nominal, (*FACTORED, *BEARING))  # all that are compared with corners
    given, corners = scene.all_factors, Corners(usual)
    corners.search(ends, build)
    limits = [_spread(limit, corners) for limit in nominal.plan.limits]
    moved, sizes = given.cog or (), partial(_borne, (given.weight or 1.0) * (given.cog_factor or 1.0))
    uses = [use for use in usual.uses if use.limit.quantity in FACTORED]
    centred = Corners(nominal, lambda there: _uses(with_limits(there, FACTORED)), _sizes_of(uses))
    inputs = Corners(nominal, sizes)
    centres = Corners(nominal, sizes, inputs.usual)
    for signs in product(*((-1, 1) if half else (0,) for half in moved)) if moved else ():
        way = [sign * half for sign, half in zip(signs, moved, strict=True)]
        to = {path: _shifted(block.com, way) for path, block in _blocks(scene).items()}
        texts: dict[Path, Data] = {(*path, "com"): [f"{x!r} m" for x in place] for path, place in to.items()}
        there = cache(partial(shift, to))
        centred.uses(texts, there)
        centres.uses(texts, there)
    if inputs.usual != {key: corners.usual.get(key) for key in inputs.usual} or moved:
        inputs.search(ends, build)
        limits = [_contingent(limit, corners, inputs, centres, given) for limit in limits]
    lost = [*_lost(nominal, corners), *_lost(nominal, centred)]
    if not stated:
        return [*limits, *lost]
    used = {key: centred.most[key] / use for key, use in centred.usual.items() if use}
    grown = {key: (corners.most[key] / corners.usual[key], ", ".join(x)) for key, x in corners.moved.items()
             if corners.usual[key] and corners.most[key] > corners.usual[key]}  # fmt: skip
    rows = design_limits(nominal.plan, given, scene.practice or "none", uses, nominal.states, used, grown)
    return [*limits, *rows, *lost]


def _borne(factor: float, scene: LoadedScene) -> dict[Key, float]:
    """Return the utilisation at rest of each limit of what bears the load, if what hangs on the hooks, with the slings
    and shackles that the model leaves out, weighs `factor` times as much."""
    if not scene.states:
        return {}
    plan, g = with_limits(scene, BEARING).plan, scene.plan.gravity
    own = {hook.rope: hook.block_mass * g for machine in plan.machines for hook in machine.hooks}
    hung = {x.subject: x.rigging * g for x in scene.plan.limits if x.quantity == "hook load"}
    signals, stands = signals_of(scene.states), {*scene.states[0].supports}
    loads = {
        name: factor * F if name in stands
        else F + (factor - 1.0) * np.maximum(0.0, F - own.get(name, 0.0)) + factor * hung.get(name, 0.0)
        for name, F in signals.tensions.items()
    }  # fmt: skip
    each = (x if x.quantity == "frame load" else msgspec.structs.replace(x, rigging=0.0) for x in plan.limits)
    return _sizes_of(uses_of(msgspec.structs.replace(plan, limits=tuple(each)), [replace(signals, tensions=loads)]))


def with_limits(scene: LoadedScene, quantities: Collection[Quantity]) -> LoadedScene:
    """Return the scene with only the limits of these quantities, and with the same equilibrium path."""
    limits = tuple(x for x in scene.plan.limits if x.quantity in quantities)
    return on_same_path(scene, msgspec.structs.replace(scene.plan, limits=limits))


def _contingent(
    limit: RatedLimit, corners: "Corners", inputs: "Corners", centres: "Corners", given: Factors
) -> RatedLimit:
    """Return a limit of what bears the load with the increase of utilisation by its contingencies and, together with
    them, at the worst corners of `inputs` and `centres` of mass."""
    key = _key(limit, corners.usual)
    if key is None or not limit.known or key not in inputs.usual:
        return limit
    usual, heavy = corners.usual[key], inputs.usual[key]
    most, aside = (max(x.most[key], heavy) for x in (inputs, centres))
    worst = most * aside / heavy if limit.loads and heavy else most + aside - heavy
    adds = not limit.loads or usual <= NOISE or worst > 2.0 * usual
    named = (("weight", given.weight), ("cog factor", given.cog_factor), ("cog", given.cog))
    texts = [f"{name} {_shortly(value)}" for name, value in named if value and value != 1.0]
    factors = f"the factors {', '.join(texts)}" if texts else "" if inputs.moved.get(key) else "slings and shackles"
    message = ", ".join(x for x in (*inputs.moved.get(key, ()), factors) if x)
    spread = worst - usual if adds else worst / usual - 1.0
    return msgspec.structs.replace(limit, spread=spread, adds=adds, inputs=message) if spread > NOISE else limit


def _shortly(value: float | Sequence[float]) -> str:
    return f"{value:g}" if isinstance(value, float) else "+-" + " x ".join(f"{x:g}" for x in value) + " m"


def _lost(nominal: LoadedScene, corners: "Corners") -> Iterator[RatedLimit]:
    """Yield a limit without a value for each corner that could not be evaluated."""
    where = nominal.plan.limits[0].where if nominal.plan.limits else ""
    for message, why in corners.lost:
        yield RatedLimit(subject=message, quantity="inputs", unit="", note=why, where=where)


class Corners:
    """Search over the corners of the uncertain inputs for the highest utilisation of each limit.

    `sizes`: function that returns other values to be searched. `moved`: the inputs that influence each value."""

    def __init__(self, nominal: LoadedScene, sizes: Sizes | None = None, usual: dict[Key, float] | None = None) -> None:
        self._sizes = sizes or _uses
        self.usual = self._sizes(nominal) if usual is None else usual
        self.most = dict(self.usual)
        self.moved: dict[Key, list[str]] = {}
        self.lost: list[tuple[str, str]] = []  # corners without a path as long as that of the scene, and why
        self._ends = len(nominal.states) and nominal.states[-1].action

    def search(self, ends: Sequence[Ends], build: Build) -> None:
        """Evaluate both ends of each input's range, then the corners of several inputs at their unfavourable ends."""
        worse: dict[Key, dict[Path, str]] = {}
        for one in ends:
            found = [(text, self.uses(at := {one.path: text}, partial(build, at))) for text in one.texts]
            for key, usual in self.usual.items():
                text, use = max(((text, uses.get(key, usual)) for text, uses in found), key=lambda pair: pair[1])
                if any(abs(uses.get(key, usual) - usual) > NOISE * max(1.0, usual) for _, uses in found):
                    self.moved.setdefault(key, []).append(one.message)
                if use > usual:
                    worse.setdefault(key, {})[one.path] = text
        for corner in dict.fromkeys(tuple(x.items()) for x in worse.values() if len(x) > 1):
            self.uses(dict(corner), partial(build, dict(corner)))

    def uses(self, values: Values, build: Callable[[], LoadedScene]) -> dict[Key, float]:
        """Return the utilisation of each limit at one corner; `build` makes the scene at this corner."""
        message, why = ", ".join(f"{shown(path)} {text}".replace("'", "") for path, text in values.items()), ""
        try:
            scene = build()
            found = self._sizes(scene)
            if scene.states and scene.states[-1].action < self._ends:
                why = scene.statics.why or "the path at rest ends early"
        except HeavyliftError as error:
            found, why = {}, str(error).partition("\n")[0]
        if why:
            self.lost.append((message, f"limits are not known there: {why}"))
        for key, use in found.items():
            self.most[key] = max(self.most.get(key, use), use)
        return found


def _uses(scene: LoadedScene) -> dict[Key, float]:
    return _sizes_of(scene.uses)


def _sizes_of(uses: Sequence[Use]) -> dict[Key, float]:
    """Return the utilisation of each limit or, if the limit is unknown, the value itself."""
    each = ((use.limit, use.value if use.use is None else use.use) for use in uses)
    return {(x.subject, x.quantity): use for x, use in each if use is not None and isfinite(use)}


def _key(limit: RatedLimit, usual: Mapping[Key, float]) -> Key | None:
    """Return the key of a limit's utilisation at rest; None if it has none."""
    alike = [(limit.subject, quantity) for quantity in (limit.quantity, *AT_REST.get(limit.quantity, ()))]
    return next((key for key in alike if key in usual), None)


def _spread(limit: RatedLimit, corners: Corners) -> RatedLimit:
    """Return a limit with the increase of utilisation at the worst corner."""
    key = _key(limit, corners.usual)
    if key is None or key not in corners.moved or not limit.known:
        return limit
    usual, most = corners.usual[key], corners.most[key]
    adds = not limit.loads or most > 2.0 * usual  # what was slack, or pulled straight down, grows in no proportion
    spread = most - usual if adds else most / usual - 1.0
    inputs = ", ".join(corners.moved[key])
    return msgspec.structs.replace(limit, spread=spread, adds=adds, inputs=inputs) if spread > NOISE else limit
