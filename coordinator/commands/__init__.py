"""The commands of `heavylift`, a file per subject; a file that is imported here adds its commands to `app`."""

from . import (
    devs,
    files,
    hosts,
    operating,
    replaying,
    resuming,
    running,
    scenes,
    starting,
    tracing,
    trading,
    trusting,
    watching,
)
from .app import app

__all__ = [
    "app",
    "devs",
    "files",
    "hosts",
    "operating",
    "replaying",
    "resuming",
    "running",
    "scenes",
    "starting",
    "tracing",
    "trading",
    "trusting",
    "watching",
]
