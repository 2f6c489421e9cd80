"""Where the text of a scene comes from: its file or a bundled one, laid over those that it extends."""

from __future__ import annotations

from pathlib import Path

from heavylift.kernel.errors import SceneError
from heavylift.nodes.scene.text.faults import closest
from heavylift.nodes.scene.text.files import within
from heavylift.nodes.scene.text.opening import scene_text
from heavylift.nodes.scene.text.overlay import merged
from heavylift.nodes.scene.text.source import Source, read
from heavylift.nodes.scenes import bundled

ENDINGS = (".yaml", ".yml", ".json")
LONGEST_CHAIN = 20  # of files that extend one another


def extended(path: Path, name: str, text: str, root: Path, above: tuple[Path, ...] = ()) -> Source:
    """The data of a file laid over that of the file which it extends, in the folder `root` of the scene or bundled."""
    return over(read(text, name, root), path, root, above)


def over(source: Source, path: Path, root: Path, above: tuple[Path, ...] = ()) -> Source:
    """The same of data that stand in a file already."""
    base = source.data.pop("extends", None)
    if base is None:
        return source
    at = ("extends",)
    here = (*above, path.resolve())
    if not isinstance(base, str):
        source.fault(at, "write the path of a scene, such as 'extends: lift.yaml'")
        return source
    below = path.parent / base
    try:
        if base in bundled() and not (below.suffix in ENDINGS and below.is_file()):
            below, root = bundled()[base], bundled()[base].parent
        elif below.suffix not in ENDINGS:
            message = f"'{base}' is neither a file .yaml nor the name of a bundled scene: {closest(base, bundled())}"
            raise SceneError(message)
        real = within(root, below)
        if real in here:
            raise SceneError(f"'{base}' extends itself in a circle")
        if len(above) > LONGEST_CHAIN:
            raise SceneError(f"more than {LONGEST_CHAIN} files extend one another")
        name_below = below.name if below in bundled().values() else str(below)  # however the path above is written
        under = extended(below, name_below, scene_text(real, base), root, here)
    except (SceneError, ValueError) as error:
        source.fault(at, str(error))
        return source
    return merged(under, source)
