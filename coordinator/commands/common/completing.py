"""What a shell may complete: names of bundled scenes, files that a command can read, runs in progress.

`heavylift --install-completion` puts it into the user's shell.  Nothing here may fail or print: what cannot be looked
up is not offered.
"""

from pathlib import Path


def scenes(incomplete: str) -> list[str]:
    """Bundled scenes by name, scene files by path."""
    from heavylift.nodes.scenes import bundled

    return [name for name in bundled() if name.startswith(incomplete)] + _files(incomplete, (".yaml", ".yml"))


def recordings(incomplete: str) -> list[str]:
    """Recordings, complete or cut off."""
    return _files(incomplete, (".mcap", ".mcap.part"))


def runs(incomplete: str) -> list[str]:
    """Recordings of this user's runs in progress, relative to the current folder."""
    from heavylift.coordinator.live import running

    here = Path.cwd()
    written = [Path(found.notice.recording) for found in running() if found.notice.recording]
    shown = [str(path.relative_to(here)) if path.is_relative_to(here) else str(path) for path in written]
    return [path for path in shown if path.startswith(incomplete)]


def _files(incomplete: str, suffixes: tuple[str, ...]) -> list[str]:
    """Files with these suffixes, and folders that may contain them."""
    folder, _, begun = incomplete.rpartition("/")
    where = f"{folder}/" if "/" in incomplete else ""
    try:
        found = sorted(Path(where or ".").iterdir())
    except OSError:
        return []
    fits = [path for path in found if path.name.startswith(begun) and (begun or not path.name.startswith("."))]
    return [f"{where}{p.name}{'/' if p.is_dir() else ''}" for p in fits if p.is_dir() or p.name.endswith(suffixes)]
