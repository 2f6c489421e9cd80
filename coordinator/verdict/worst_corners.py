"""Clearances at the worst corner of a scene's uncertain inputs, on its path at rest: a limit for each two things that
come nearer there; in a run they come nearer by as much."""

from dataclasses import replace

import msgspec
from heavylift.nodes.plan.limit import RestLoad
from heavylift.nodes.scene import LoadedScene, parse
from heavylift.nodes.scene.corners import Corners, Ends, Key, Values
from heavylift.nodes.scene.inputs import settings, uncertain_inputs

from .ground import TOUCH
from .judging import at_rest

EVERY = 10_000  # pairs
NEAR = 1.0  # [m] beyond its limit: what stays farther apart at the worst has no row


def with_worst_clearances(scene: LoadedScene) -> LoadedScene:
    """The scene with a limit for each clearance that is smaller at a corner of its uncertain inputs."""
    limits = [x for x in scene.plan.limits if x.quantity == "clearance"]
    if not scene.facts.uncertain or not limits or any(x.inputs for x in limits) or not scene.lifts:
        return scene
    limit, inputs = limits[0], {x.path: x for x in uncertain_inputs(scene)}
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

    corners = Corners(scene, build, sizes)
    corners.search(ends)
    rows = [
        msgspec.structs.replace(
            limit, subject=key[0], value=float(key[1]), spread=most - corners.usual[key],
            inputs=", ".join(moved), rest=RestLoad(value=-corners.usual[key], bound=float(key[1])),
        )
        for key, moved in corners.moved.items()
        if (most := corners.most[key]) > max(corners.usual[key], -float(key[1]) - NEAR)
    ]  # fmt: skip
    return replace(scene, plan=msgspec.structs.replace(scene.plan, limits=(*scene.plan.limits, *rows)))
