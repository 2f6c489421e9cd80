"""`heavylift doctor`: checks what is installed, which folders can be written, and whether a short run works.

The run is a complete one: processes, Zenoh sessions over a private socket, equations compiled to machine code, a
recording that is read again. What only some commands need can be `missing`, but never `broken`.
"""

import json
import os
import platform
import shutil
import tempfile
from collections.abc import Iterator
from importlib.metadata import PackageNotFoundError, requires, version
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal, NamedTuple

import typer
from heavylift.coordinator.commands.common import options as o
from heavylift.coordinator.commands.common.app import app
from heavylift.kernel.errors import HeavyliftError
from heavylift.kernel.version import __version__

if TYPE_CHECKING:
    from packaging.requirements import Requirement

EXTRAS = {  # what some commands need, and what for
    "cryptography": "certificates of runs over several hosts: pip install 'heavylift[hosts]'",
    "pandas": "Signal.to_pandas(): pip install 'heavylift[pandas]'",
    "pyarrow": "export to .parquet: pip install 'heavylift[parquet]'",
}


class HealthFinding(NamedTuple):
    """One line of the diagnosis: what was checked, its state, and a message."""

    what: str
    state: Literal["ok", "missing", "broken"]
    message: str

    def __str__(self) -> str:
        return f"{self.state:<8} {self.what:<26} {self.message}"


@app.command()
def doctor(
    as_json: o.Json = False,
    clear_cache: Annotated[bool, typer.Option("--clear-cache", help="empty the cache first")] = False,
) -> None:
    """Check the installation: versions, rights, cache, a short run in processes.    heavylift doctor"""
    found = []
    if clear_cache:
        from heavylift.kernel.cache import prune_cache

        prune_cache(0)
    for finding in findings():
        found.append(finding)
        if not as_json:
            typer.echo(str(finding))
    if as_json:
        typer.echo(
            json.dumps([{"told" if key == "message" else key: x for key, x in f._asdict().items()} for f in found])
        )
    if any(finding.state == "broken" for finding in found):
        raise typer.Exit(1)


def findings() -> Iterator[HealthFinding]:
    """Run all checks of the installation, and yield the finding of each."""
    from packaging.requirements import Requirement

    yield HealthFinding("heavylift", "ok", f"{__version__}, Python {platform.python_version()}, {platform.platform()}")
    needed = [Requirement(line) for line in requires("heavylift") or []]
    yield from (_package(x) for x in needed if x.marker is None)
    optional = {x.name: x for x in needed if x.name in EXTRAS}
    yield from (_package(optional[name], f"needed for {purpose}") for name, purpose in EXTRAS.items())
    yield _browser()
    yield _folder("this folder", Path())
    yield _cache()
    yield _run()


def _package(needed: "Requirement", purpose: str = "") -> HealthFinding:
    """Compare an installed package with the requirement in heavylift's metadata."""
    try:
        found = version(needed.name)
    except PackageNotFoundError:
        message = purpose or "is not installed; install heavylift again"
        return HealthFinding(needed.name, "missing" if purpose else "broken", message)
    if needed.specifier.contains(found, prereleases=True):
        return HealthFinding(needed.name, "ok", found)
    message = f"{found} is too old; pip install '{needed.name}{needed.specifier}'"
    return HealthFinding(needed.name, "broken", message)


def _browser() -> HealthFinding:
    from heavylift.recordings.sheets.workbook import BROWSERS

    found = next((path for name in BROWSERS if (path := shutil.which(name))), "")
    message = found or "no Chromium or Chrome; needed for reports as .pdf, pages open in any browser"
    return HealthFinding("browser", "ok" if found else "missing", message)


def _folder(what: str, folder: Path) -> HealthFinding:
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder):
            pass
    except OSError as error:
        return HealthFinding(what, "broken", f"{folder.absolute()} cannot be written to ({error.strerror})")
    return HealthFinding(what, "ok", f"{folder.absolute()}, {shutil.disk_usage(folder).free / 1e9:.0f} GB free")


def _cache() -> HealthFinding:
    from heavylift.kernel.cache import cache_bound, cache_folder, kept, unsafe_cache

    if why := unsafe_cache():
        message = f"{cache_folder().absolute()} is not used, so every start compiles anew: it {why}"
        return HealthFinding("cache", "broken", f"{message}; or name another by HEAVYLIFT_CACHE")
    found = _folder("cache", cache_folder())
    if found.state != "ok":
        return found._replace(message=f"{found.message}; name another by HEAVYLIFT_CACHE")
    there = kept()
    used = f"{len(there)} files, {sum(x.size for x in there) / 1e6:.1f} MB of at most {cache_bound() / 1e6:g} MB"
    return found._replace(message=f"{found.message}; {used} (HEAVYLIFT_CACHE_MB)")


def _run() -> HealthFinding:
    """Simulate a pendulum for a second in several processes, and read its recording."""
    from heavylift.coordinator.run import run
    from heavylift.nodes.scene import load
    from heavylift.recordings import Recording

    with tempfile.TemporaryDirectory(prefix="heavylift-", ignore_cleanup_errors=True) as folder:
        output = Path(folder) / "pendulum.mcap"
        try:
            result = run(load("pendulum", ["end=1 s"]), output)
            swing = Recording(output).signal("joint/position")
        except HeavyliftError as error:
            return HealthFinding("a short run", "broken", str(error))
        except Exception as error:  # of a package that is older or newer than what is tested
            return HealthFinding("a short run", "broken", f"{type(error).__name__}: {error}; install heavylift again")
    message = f"{len(swing.t)} samples of a pendulum in {result.wall_s:.1f} s, {os.cpu_count()} cores"
    return HealthFinding("a short run", "ok", message)
