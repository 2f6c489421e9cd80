"""Where the text of a scene comes from: its file or a bundled one, laid over those that it extends."""

from __future__ import annotations

from pathlib import Path

from heavylift.kernel.errors import SceneError
from heavylift.nodes.scene.text.faults import closest
from heavylift.nodes.scene.text.files import content, within
from heavylift.nodes.scene.text.overlay import merged
from heavylift.nodes.scene.text.source import Source, read
from heavylift.nodes.scenes import bundled

__all__ = ["extended", "scene_file", "scene_text"]

ENDINGS = (".yaml", ".yml", ".json")
LONGEST_CHAIN = 20  # of files that extend one another
MCAP = b"\x89MCAP0\r\n"  # how a recording begins


def extended(path: Path, name: str, text: str, root: Path, above: tuple[Path, ...] = ()) -> Source:
    """The data of a file laid over that of the file which it extends, in the folder `root` of the scene or bundled."""
    source = read(text, name, root)
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


def scene_file(scene: str) -> Path:
    """The file at a path, or that of a bundled scene; raises SceneError where a name is neither."""
    path = Path(scene)
    known = bundled()
    if path.is_file() or scene not in known:
        if not path.is_file() and not path.suffix and "/" not in scene and "\\" not in scene:
            message = f"there is no scene '{scene}', neither a file nor a bundled one: {closest(scene, known)}"
            raise SceneError(message)
        return path
    return known[scene]


def scene_text(path: Path, name: str) -> str:
    """What stands in a scene file; raises SceneError if it cannot be read, a recording for one."""
    try:
        return content(path).decode("utf-8")
    except FileNotFoundError:
        raise SceneError(f"there is no scene file '{name}'") from None
    except (OSError, ValueError) as error:
        reason = error.strerror if isinstance(error, OSError) else "it is not UTF-8 text"
        if _is_recording(path):
            reason = (
                f"it is a recording, no scene; `heavylift info {name}` tells what is in it, `heavylift view` shows it"
            )
        raise SceneError(f"the scene file '{name}' cannot be read: {reason}") from None


def _is_recording(path: Path) -> bool:
    try:
        return path.is_file() and path.open("rb").read(len(MCAP)) == MCAP
    except OSError:
        return False
