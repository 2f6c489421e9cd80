"""The scenes that come with heavylift, to run and to copy: a file each, its first comment says what it shows.

`heavylift run lift` finds them by name; GALLERY.md shows pictures of them all.
"""

from pathlib import Path

__all__ = ["bundled"]


def bundled() -> dict[str, Path]:
    """The scenes that come with heavylift, by name."""
    return {path.stem: path for path in sorted(Path(__file__).parent.glob("*.yaml"))}
