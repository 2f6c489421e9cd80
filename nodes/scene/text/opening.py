"""Where the text of a scene comes from: its file or a bundled one; no more than that is imported for it."""

from __future__ import annotations

from pathlib import Path

from heavylift.kernel.errors import SceneError
from heavylift.nodes.scenes import bundled

from .files import content

MCAP = b"\x89MCAP0\r\n"  # how a recording begins


def scene_file(scene: str) -> Path:
    """The file at a path, or that of a bundled scene; raises SceneError where a name is neither."""
    path = Path(scene)
    known = bundled()
    if path.is_file() or scene not in known:
        if not path.is_file() and not path.suffix and "/" not in scene and "\\" not in scene:
            from .faults import closest  # with what reads scenes

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
