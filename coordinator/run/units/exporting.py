"""A scene written as an FMU.

heavylift export-fmu lift -o lift.fmu
heavylift export-fmu hall --input hall.traversing --input wind --fmi 3
"""

import re
import tempfile
import zipfile
from collections.abc import Sequence
from pathlib import Path
from typing import Literal

import msgspec
from heavylift.kernel.errors import SceneError, path_text
from heavylift.nodes.models.user_models import OUTSIDE
from heavylift.nodes.plan.plan import encode
from heavylift.nodes.plan.user_models import UserModel
from heavylift.nodes.scene import LoadedScene, load
from heavylift.recordings.format.text import GENERATOR
from heavylift.recordings.write.partfile import PartFile

from .scene_unit import KEPT, UnitScene

STATE = {"2": ("canGetAndSetFMUstate", "canSerializeFMUstate"), "3": ("canGetAndSetFMUState", "canSerializeFMUState")}
CODE = """import ctypes

from heavylift.coordinator.run.units.{of} import {base}
from {library} import {slave}

ctypes.pythonapi.Py_IncRef(ctypes.py_object(globals()))  # pythonfmu gives back one that it has not taken, each time


class {name}({base}, {slave}):
    pass
"""
CODES = {
    "2": {"of": "fmi2", "base": "SceneUnit", "library": "pythonfmu", "slave": "Fmi2Slave"},
    "3": {"of": "fmi3", "base": "SceneUnit3", "library": "pythonfmu3", "slave": "Fmi3Slave"},
}


def masters_of(scene: LoadedScene, inputs: Sequence[str]) -> tuple[tuple[UserModel, ...], bool]:
    """Return the models through which an importing program orders speeds, and whether it also sets the wind speed."""
    wind = "wind" in inputs
    if wind and not any(machine.name == "wind" for machine in scene.plan.machines):
        raise SceneError("--input wind: the scene has no 'wind'; give it one, such as 'wind: {speed: 0 m/s}'")
    moved = [name for name in inputs if name != "wind"]
    return load(scene.typed or scene.path, [*scene.settings, masters(moved)]).plan.models[-1:] if moved else (), wind


def masters(inputs: Sequence[str]) -> str:
    """Return the scene setting for a model through which an importing program orders speeds of these drives and
    winches."""
    ports = [f"speed-{i + 1}" for i in range(len(inputs))]
    orders = ", ".join(f"{port}: '{name}'" for port, name in zip(ports, inputs, strict=True))
    keys = f"period: 1 h, orders: {{{orders}}}, parameters: {{ports: {' '.join(ports)}}}"
    return f"models.outside={{model: '{OUTSIDE}', {keys}}}"


def export(
    scene: LoadedScene, output: Path, force: bool = False, inputs: Sequence[str] = (), fmi: Literal["2", "3"] = "2"
) -> Path:
    """Write the FMU of a scene and return its path. `inputs`: drives, winches, and `wind`, whose speeds are real
    inputs."""
    own, wind = masters_of(scene, inputs)
    name = "".join(word.capitalize() for word in re.findall(r"[A-Za-z0-9]+", scene.plan.name))
    name = name if name[:1].isalpha() else f"Scene{name}"
    kept = UnitScene(encode(scene.plan), scene.text, scene.merged, path_text(scene.path.name), own, wind)
    with PartFile(output, "a unit", (".fmu",), force) as file, tempfile.TemporaryDirectory() as folder:
        code, data, made = (Path(folder) / x for x in (f"heavylift_{name.lower()}_{fmi}.py", KEPT, f"{name}.fmu"))
        code.write_text(CODE.format(name=name, **CODES[fmi]), encoding="utf-8")
        data.write_bytes(msgspec.msgpack.encode(kept))
        options = dict.fromkeys(STATE[fmi], True)
        if fmi == "3":
            from .fmi3 import build

            build(code, made, data, options)
        else:
            from pythonfmu import FmuBuilder

            FmuBuilder.build_FMU(code, dest=made, project_files=[data], **options)
        with zipfile.ZipFile(made, "a") as archive:
            archive.comment = GENERATOR.encode()
        with file.writing():
            file.stream.write(made.read_bytes())
    return file.path
