"""What `heavylift doctor` looks at: what is installed, where one may write, and whether a short run works.

The run is the real thing: processes, Zenoh sessions over a private socket, equations compiled to machine code, a
recording that is read again.  What is only needed by some commands is `missing`, never `broken`.
"""

from __future__ import annotations

import json
import os
import platform
import shutil
import tempfile
from collections.abc import Iterator
from importlib.metadata import PackageNotFoundError, requires, version
from importlib.util import find_spec
from pathlib import Path
from typing import Literal, NamedTuple

import typer
from heavylift.coordinator.commands.common import options as o
from heavylift.coordinator.commands.common.app import app
from heavylift.kernel.errors import HeavyliftError

EXTRAS = {  # what some commands need, and what for
    "cryptography": "certificates of runs over several hosts: pip install 'heavylift[hosts]'",
    "pandas": "Signal.to_pandas(): pip install 'heavylift[pandas]'",
    "pyarrow": "export to .parquet: pip install 'heavylift[parquet]'",
}


class Finding(NamedTuple):
    """One line of the answer."""

    what: str
    state: Literal["ok", "missing", "broken"]
    told: str

    def __str__(self) -> str:
        return f"{self.state:<8} {self.what:<26} {self.told}"


@app.command()
def doctor(as_json: o.Json = False) -> None:
    """Check the installation: versions, rights, a short run in processes.    heavylift doctor"""
    found = []
    for finding in findings():
        found.append(finding)
        if not as_json:
            typer.echo(str(finding))
    if as_json:
        typer.echo(json.dumps([finding._asdict() for finding in found]))
    if any(finding.state == "broken" for finding in found):
        raise typer.Exit(1)


def findings() -> Iterator[Finding]:
    """What is found, one after the other."""
    yield Finding(
        "heavylift", "ok", f"{version('heavylift')}, Python {platform.python_version()}, {platform.platform()}"
    )
    yield from map(_package, _needed())
    yield from (_extra(name, purpose) for name, purpose in EXTRAS.items())
    yield _browser()
    yield _folder("this folder", Path())
    yield _cache()
    yield _run()


def _needed() -> list[str]:
    """Packages that heavylift cannot do without, from its own metadata."""
    lines = [line for line in requires("heavylift") or [] if "extra ==" not in line]
    return ["".join(c if c.isalnum() or c in "-_." else " " for c in line).split()[0] for line in lines]


def _package(name: str) -> Finding:
    try:
        return Finding(name, "ok", version(name))
    except PackageNotFoundError:
        return Finding(name, "broken", "is not installed; install heavylift again")


def _extra(name: str, purpose: str) -> Finding:
    there = find_spec(name) is not None
    return Finding(name, "ok", version(name)) if there else Finding(name, "missing", f"needed for {purpose}")


def _browser() -> Finding:
    from heavylift.recordings.documents.browser import BROWSERS

    found = next((path for name in BROWSERS if (path := shutil.which(name))), "")
    told = found or "no Chromium or Chrome; needed for reports as .pdf, pages open in any browser"
    return Finding("browser", "ok" if found else "missing", told)


def _folder(what: str, folder: Path) -> Finding:
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder):
            pass
    except OSError as error:
        return Finding(what, "broken", f"{folder.absolute()} cannot be written to ({error.strerror})")
    return Finding(what, "ok", f"{folder.absolute()}, {shutil.disk_usage(folder).free / 1e9:.0f} GB free")


def _cache() -> Finding:
    from heavylift.kernel.cache import cache_folder, unsafe_cache

    if why := unsafe_cache():
        told = f"{cache_folder().absolute()} is not used, so every start compiles anew: it {why}"
        return Finding("cache", "broken", f"{told}; or name another by HEAVYLIFT_CACHE")
    found = _folder("cache", cache_folder())
    return found if found.state == "ok" else found._replace(told=f"{found.told}; name another by HEAVYLIFT_CACHE")


def _run() -> Finding:
    """The pendulum for a second, in processes, and its recording."""
    from heavylift.coordinator.run import run
    from heavylift.nodes.scene import load
    from heavylift.recordings import Recording

    with tempfile.TemporaryDirectory(prefix="heavylift-", ignore_cleanup_errors=True) as folder:
        output = Path(folder) / "pendulum.mcap"
        try:
            result = run(load("pendulum", ["end=1 s"]), output)
            swing = Recording(output).signal("joint/position")
        except HeavyliftError as error:
            return Finding("a short run", "broken", str(error))
    told = f"{len(swing.t)} samples of a pendulum in {result.wall_s:.1f} s, {os.cpu_count()} cores"
    return Finding("a short run", "ok", told)
