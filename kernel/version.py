"""Which heavylift this is, and what to do with what another one has made.

The version comes from the repository's last tag and the commit: `0.3.0`, or `0.3.1.dev12+g1a2b3c4d` twelve commits
later, with the date behind it where files were changed.  It is read when heavylift is installed: an installation in
place (`pip install -e`) keeps that of its day.
"""

from importlib import metadata

__version__ = metadata.version("heavylift")


def install(version: str) -> str:
    """How to install another version: "install heavylift 0.3.0", and its commit."""
    commit = version.partition("+g")[2].partition(".")[0]
    return f"install heavylift {version}" + (f" (git checkout {commit})" if commit else "")


def again(version: str) -> str:
    """What to do with a recording of this version that cannot be used here."""
    if version == __version__:
        return "this version made it, so a file was changed, or a model is not deterministic; run the scene again"
    return f"run the scene again, or {install(version)}, which made it"
