"""What the operating system says about the processes and sockets of a run."""

import os
import time
from collections.abc import Callable
from contextlib import suppress

from heavylift.coordinator.supervision import Processes
from heavylift.coordinator.transport import Hub

PATIENCE_s = 60.0  # tells hanging from working, on a loaded machine too
Start = Callable[..., tuple[Hub, Processes]]


def running(pid: int) -> bool:
    """Whether this process exists and is no zombie."""
    try:
        with open(f"/proc/{pid}/stat") as stat:
            return stat.read().rpartition(")")[2].split()[0] != "Z"
    except OSError:
        return False


def gone(*pids: int) -> bool:
    """Whether all these processes end."""
    deadline = time.monotonic() + PATIENCE_s
    while any(running(pid) for pid in pids):
        if time.monotonic() > deadline:
            return False
        time.sleep(0.01)
    return True


def sockets(pid: int) -> set[str]:
    """The inodes of all open sockets of a process."""
    found = set()
    for fd in os.listdir(f"/proc/{pid}/fd"):
        with suppress(FileNotFoundError):
            target = os.readlink(f"/proc/{pid}/fd/{fd}")
            if target.startswith("socket:["):
                found.add(target[8:-1])
    return found


def network_sockets(pid: int) -> list[str]:
    """The TCP, UDP and raw sockets of a process, as lines of /proc/net."""
    inodes, found = sockets(pid), []
    for kind in ("tcp", "tcp6", "udp", "udp6", "raw", "raw6"):
        with open(f"/proc/{pid}/net/{kind}") as table:
            found += [f"{kind} {line}" for line in table.readlines()[1:] if line.split()[9] in inodes]
    return found
