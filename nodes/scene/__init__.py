"""Scene files: YAML with units in, a checked plan out.

    load("turnover")            -> LoadedScene: plan, text, path; raises SceneError with all errors
    load("lift.yaml", ["seed=7", "cranes.west.at=41 m"])              with settings laid over the file
    parse(text)                 the same for a text that stands in no file
    restored(plan, ...)         a scene that was recorded, to be run again
    check(scene)                -> Report: sizes, static loads, use, safety factors; str(report) is a page
    bundled()                   the scenes that come with heavylift, by name
    begun(name, like)           the text of a scene to start from; begun_with(name, crane, blocks): of a table
    json_schema()               of all scene files, for editors

text                        the text with the place of every key; faults; units
language                    phrases of the action list
keys                        every key of a scene file, as frozen pydantic models
construction                from keys to the plan
checks                      whether it fits, and whether its orders can be carried out
templates                   texts to start from
loading, building           from a path or name to a plan, from its text or as it was kept
instances                   several scenes side by side in one
corners                     what limits use at the worst of uncertain inputs
loaded_scene                what can be run, and what follows from it at rest
report, factor_sheet        what `heavylift check` prints
inputs                      quantities by name, how uncertain they are, the scene with other values
operator_command            an order of an operator while a scene runs

Node processes import `heavylift.nodes.plan.plan` only; what reads YAML is imported when it is first used.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from heavylift.kernel.on_demand import face, on_demand

if TYPE_CHECKING:
    from heavylift.nodes.scene.keys.editors import json_schema
    from heavylift.nodes.scenes import bundled

    from .loaded_scene import LoadedScene
    from .loading import check, load, loaded, parse, restored
    from .report import SceneReport
    from .templates import new_scene, new_scene_with

__all__ = [
    "LoadedScene", "SceneReport", "bundled", "check", "json_schema", "load", "loaded", "new_scene", "new_scene_with",
    "parse", "restored",
]  # fmt: skip
__getattr__ = on_demand(
    __name__,
    dict.fromkeys(__all__, ".loading")
    | dict.fromkeys(("new_scene", "new_scene_with"), ".templates")
    | {"LoadedScene": ".loaded_scene", "SceneReport": ".report", "json_schema": ".keys.editors", "bundled": "..scenes"},
)

face(__name__)
