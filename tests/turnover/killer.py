"""The command `heavylift` with one node killed as the first stage begins, and each of its successors.

python killer.py NODE ARGUMENTS...    prints the ids of all node processes, then what the command prints
"""

from __future__ import annotations

import os
import signal
import sys
import threading
import time
from contextlib import suppress
from typing import Any

from heavylift.coordinator import cli
from heavylift.coordinator.run import progress
from heavylift.coordinator.supervision import processes

victim = sys.argv.pop(1)
crews: list[Any] = []
make, hear = processes.Processes.__init__, progress.Progress.event


def started(crew: Any, *arguments: Any, **settings: Any) -> None:
    make(crew, *arguments, **settings)
    crews.append(crew)


def first(watch: Any, event: Any) -> None:
    hear(watch, event)
    if not hunting.is_alive() and not hunting.ident:
        print(*crews[0].pids.values(), flush=True)
        hunting.start()


def hunt() -> None:
    while True:
        pid = crews[0].pids.get(victim)
        if pid is not None:
            with suppress(ProcessLookupError):
                os.kill(pid, signal.SIGKILL)
        time.sleep(0.001)


hunting = threading.Thread(target=hunt, daemon=True)

if __name__ == "__main__":
    processes.Processes.__init__ = started
    progress.Progress.event = first
    cli.main()
