"""The scenes that come with heavylift, to be run and to be copied: one file each, whose first comment describes it.

`heavylift run lift` finds them by name; GALLERY.md shows pictures of all of them. The folder `types` contains the
machines to which scenes refer by `type: overhead-100` (`heavylift types` lists them), `frames` the frames on hooks of
cranes on rails, and `vessels` hulls with their hydrodynamics.
"""

from functools import cache
from pathlib import Path

__all__ = ["bundled", "frames_folder", "types_folder", "vessels_folder"]


def bundled() -> dict[str, Path]:
    """Return the bundled scenes by name."""
    return dict(_bundled())


@cache
def _bundled() -> tuple[tuple[str, Path], ...]:
    return tuple((path.stem, path) for path in sorted(Path(__file__).parent.glob("*.yaml")))


def types_folder() -> Path:
    """Return the folder of the bundled machine types."""
    return Path(__file__).parent / "types"


def frames_folder() -> Path:
    """Return the folder of the bundled frame types."""
    return Path(__file__).parent / "frames"


def vessels_folder() -> Path:
    """Return the folder of the bundled hulls of vessels."""
    return Path(__file__).parent / "vessels"
