"""Settings applied to a scene, also to one number of a list that the scene leaves to its default."""

from copy import deepcopy

from heavylift.kernel.errors import SceneError
from heavylift.nodes.scene.text import overlay
from heavylift.nodes.scene.text.extending import alike
from heavylift.nodes.scene.text.machine_types import gather
from heavylift.nodes.scene.text.source import Data, Path, Source
from heavylift.nodes.scene.text.tables import tabled

from .gear import geared
from .quantities import found_at, quantity
from .validate import validate


def override(source: Source, setting: str) -> None:
    """Apply one setting `dotted.path=text` to the scene; its marks point into the setting."""
    overlay.override(source, setting, default_list)


def default_list(source: Source, path: Path) -> list[Data] | None:
    """Return the default of a path that the scene does not set, if it is a list of numbers or words; else None."""
    trial = deepcopy(source)
    try:
        alike(trial)
        tabled(trial)
        geared(trial)
        gather(trial)
        scene = validate(trial)
    except SceneError:  # which is reported when the scene is built
        return None
    at, kind = found_at(scene, path) or (None, None)
    return listed(at, kind) if isinstance(at, tuple | list) else None


def listed(at: tuple[object, ...] | list[object], kind: object) -> list[Data] | None:
    """Return a list as written in a scene; None unless it contains numbers or words."""
    found = quantity(kind)
    si = next((unit for unit, factor in found.dimension.units.items() if factor == 1), "") if found else ""
    written: list[Data] = []
    for x in at:
        if not isinstance(x, int | float | str):
            return None
        written.append(x if found is None or isinstance(x, str | bool) else f"{x!r} {si}".strip())
    return written
