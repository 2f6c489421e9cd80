"""The command `heavylift` as users run it, in which one node process is killed as the first stage begins.

python killer.py NODE ARGUMENTS...    prints the ids of all node processes, then what the command prints
"""

from __future__ import annotations

import os
import signal
import sys
from typing import Any

from heavylift.coordinator import cli, processes, progress

victim = sys.argv.pop(1)
crews: list[Any] = []
dead: list[str] = []
make, hear = processes.Processes.__init__, progress.Progress.event


def started(crew: Any, *arguments: Any, **settings: Any) -> None:
    make(crew, *arguments, **settings)
    crews.append(crew)


def first(watch: Any, event: Any) -> None:
    hear(watch, event)
    pids = crews[0].pids
    if not dead:
        print(*pids.values(), flush=True)
        os.kill(pids[victim], signal.SIGKILL)
        dead.append(victim)


if __name__ == "__main__":
    processes.Processes.__init__ = started
    progress.Progress.event = first
    cli.main()
