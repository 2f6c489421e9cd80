"""What the numbers were measured on: machine, cores, load, versions."""

from __future__ import annotations

import os
import platform
from dataclasses import dataclass
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

__all__ = ["Machine", "machine"]


@dataclass(frozen=True)
class Machine:
    """Processor, cores that a process may use, load of the last minute (other work on it), versions."""

    processor: str
    cores: int
    load: float
    python: str
    heavylift: str


def machine() -> Machine:
    """This one, now."""
    try:
        ours = version("heavylift")
    except PackageNotFoundError:
        ours = "?"
    cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    return Machine(_processor(), cores, os.getloadavg()[0], platform.python_version(), ours)


def _processor() -> str:
    listed = Path("/proc/cpuinfo")
    lines = listed.read_text().splitlines() if listed.exists() else []
    named = (line.partition(":")[2].strip() for line in lines if line.startswith("model name"))
    return next(named, platform.processor() or platform.machine())
