"""The version of heavylift, and advice for files of other versions.

The version comes from the repository's last tag and the commit: `0.3.0`, or `0.3.1.dev12+g1a2b3c4d` twelve commits
later, followed by the date if files were changed. It is determined at installation: an editable installation (`pip
install -e`) keeps the version of that day.
"""

from importlib import metadata

__version__ = metadata.version("heavylift")


def install(version: str) -> str:
    """Return how to install a version as text: "install heavylift 0.3.0", with its commit if it has one."""
    commit = version.partition("+g")[2].partition(".")[0]
    return f"install heavylift {version}" + (f" (git checkout {commit})" if commit else "")


def again(version: str) -> str:
    """Return advice on how to repeat a recording that this installed version of heavylift cannot use."""
    if version == __version__:
        return "this version made it, so a file was changed, or a model is not deterministic; run the scene again"
    return f"run the scene again, or {install(version)}, which made it"
