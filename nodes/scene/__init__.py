"""Scene files: YAML with units is read, checked and turned into a plan.

    load("turnover")            -> LoadedScene: plan, text, path; raises SceneError with all errors
    load("lift.yaml", ["seed=7", "cranes.west.at=41 m"])              with settings applied to the file
    parse(text)                 the same for a text without a file
    restored(plan, ...)         a recorded scene, to be run again
    check(scene)                -> SceneReport: sizes, static loads, utilisations, safety factors; str(report) is a page
    bundled()                   the scenes that come with heavylift, by name
    new_scene(name, like)       the text of a new scene; new_scene_with(name, crane, blocks): for blocks of a table
    json_schema()               the JSON Schema of all scene files, for editors

text                        reading of the text, with the place of every key; error messages; units
language                    the language of orders and conditions in the action list
keys                        every key of a scene file, as frozen pydantic models
construction                construction of the plan from the keys
checks                      checks that find impossible scenes and orders before anything runs
model_files                 the parts of a machine from a robot model in URDF or MJCF
templates                   texts of new scenes
loading, building           loading a scene by path or name, from the cache or by building it from its text
instances                   several scenes side by side in one scene
corners                     utilisations at the worst combination of uncertain inputs
loaded_scene                a scene that is ready to run, with its static results
report, factor_sheet        the report that `heavylift check` prints
inputs                      quantities of a scene by name, their uncertainties, and the scene with other values
operator_command            an order that an operator gives during a run

Node processes import only `heavylift.nodes.plan.plan`; the modules that read YAML are imported on first use.
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
