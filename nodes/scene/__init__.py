"""Scene files: YAML with units in, a checked plan out.

    load("turnover")            -> LoadedScene: plan, text, path; raises SceneError with all errors
    load("lift.yaml", ["seed=7", "cranes.west.at=41 m"])              with settings applied to the file
    parse(text)                 the same for a text without a file
    restored(plan, ...)         a recorded scene, to be run again
    check(scene)                -> SceneReport: sizes, static loads, utilisations, safety factors; str(report) is a page
    bundled()                   the scenes that come with heavylift, by name
    new_scene(name, like)       the text of a new scene; new_scene_with(name, crane, blocks): for blocks of a table
    json_schema()               the JSON Schema of all scene files, for editors

text                        the text with the place of every key; faults; units
language                    phrases of the action list
keys                        every key of a scene file, as frozen pydantic models
construction                from keys to the plan
checks                      impossible scenes and orders, found before anything runs
templates                   texts to start from
loading, building           from a path or name to a plan, built from the text or loaded from the cache
instances                   several scenes side by side in one
corners                     utilisations at the worst combination of uncertain inputs
loaded_scene                a scene that can be run, with its static results
report, factor_sheet        what `heavylift check` prints
inputs                      quantities by name, their uncertainties, the scene with other values
operator_command            an order of an operator while a scene runs

Node processes import `heavylift.nodes.plan.plan` only; what reads YAML is imported when it is first used.
"""

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
__getattr__ = on_demand(__name__)

face(__name__)
