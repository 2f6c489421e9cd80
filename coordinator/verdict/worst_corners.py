"""Clearances at the worst corner of a scene's uncertain inputs, along the static path: each pair of things that is
closer there gets a limit of its own, by which a run reduces the clearance of the pair by the same amount."""

import hashlib
from dataclasses import replace
from functools import cache
from pathlib import Path

import msgspec
from heavylift.kernel.cache import contents, remembered, sources
from heavylift.nodes.plan.limit import RatedLimit, RestLoad
from heavylift.nodes.plan.plan import encode, functions
from heavylift.nodes.scene import LoadedScene, parse

EVERY = 10_000  # pairs
NEAR = 1.0  # [m] beyond its limit: what stays farther apart at the worst has no row
ROOM = Path(__file__).parents[2]  # of the product


def with_worst_clearances(scene: LoadedScene) -> LoadedScene:
    """Return the scene with a clearance limit added for each pair of parts that extreme input values bring closer."""
    limits = [x for x in scene.plan.limits if x.quantity == "clearance"]
    if not scene.facts.uncertain or not limits or any(x.inputs for x in limits) or not scene.lifts:
        return scene
    if scene.passing or functions(scene.plan):  # whose code may change
        rows = _rows(scene, limits[0])
    else:
        rows = remembered(_name(scene), tuple[RatedLimit, ...], lambda: _rows(scene, limits[0]))
    return replace(scene, plan=msgspec.structs.replace(scene.plan, limits=(*scene.plan.limits, *rows)))


def _rows(scene: LoadedScene, limit: RatedLimit) -> tuple[RatedLimit, ...]:
    """Return the limits of clearances that are smaller at a corner."""
    from heavylift.nodes.scene.corners import Corners, Ends, Key, Values  # with what reads scenes
    from heavylift.nodes.scene.inputs import settings, uncertain_inputs

    from .ground import TOUCH
    from .judging import at_rest

    inputs = {x.path: x for x in uncertain_inputs(scene)}
    ends = []
    for x in inputs.values():
        low, high = (f"{value / x.factor!r} {x.unit}" for value in (x.value - x.half, x.value + x.half))
        ends.append(Ends(x.path, str(x), (low, high)))

    def build(values: Values) -> LoadedScene:
        given = settings([inputs[path] for path in values], [str(text) for text in values.values()])
        return parse(scene.merged or scene.text, str(scene.path), [*scene.settings, *given], followed=False)

    def sizes(other: LoadedScene) -> dict[Key, float]:
        known = [x for lift in at_rest(other.plan, other.statics, EVERY) for x in lift.clearances]
        return {(f"{x.a} and {x.b}", f"{x.limit if x.limit > 0.0 else x.limit - TOUCH!r}"): -x.distance for x in known}

    corners = Corners(scene, sizes)
    corners.search(ends, build)
    return tuple(
        msgspec.structs.replace(
            limit, subject=key[0], value=float(key[1]), spread=most - corners.usual[key],
            inputs=", ".join(moved), rest=RestLoad(value=-corners.usual[key], bound=float(key[1])),
        )
        for key, moved in corners.moved.items()
        if (most := corners.most[key]) > max(corners.usual[key], -float(key[1]) - NEAR)
    )  # fmt: skip


def _name(scene: LoadedScene) -> str:
    """Return the name of the cache file of these limits: a hash of scene, plan and code."""
    text = repr((scene.merged or scene.text, scene.settings, str(scene.path))).encode()
    return f"{hashlib.sha256(_code() + text + encode(scene.plan)).hexdigest()}.clearances"


@cache
def _code() -> bytes:
    return sources() + contents(ROOM / "nodes", ".py", ".yaml") + contents(ROOM / "coordinator" / "verdict", ".py")
