"""What the system says of processes, and what it must allow for a run in processes."""

from __future__ import annotations

import os
import resource
import signal
import subprocess

from heavylift.kernel.errors import ProtocolError

GONE = ("", "Z")  # what the system says of a process that has ended
TAIL_chars = 300
MB = 1 << 20
LIMITS = (  # of the system, below which libraries end even a small run in words of their own
    (resource.RLIMIT_NOFILE, 32, 1, "files may be open at once", "-n 256"),
    (resource.RLIMIT_AS, 800, MB, "MB of memory may be addressed by a process", "-v unlimited"),
)


def check_room() -> None:
    """Refuse limits of this user below which libraries end a run; raises ProtocolError."""
    for kind, needed, unit, what, command in LIMITS:
        given = resource.getrlimit(kind)[0]
        if given != resource.RLIM_INFINITY and given < needed * unit:
            raise ProtocolError(
                f"only {given // unit} {what}, and a run in processes needs at least {needed}; raise the limit "
                f"(`ulimit {command}`) or run --in-process"
            )


def state(pid: int) -> str:
    """The system's letter for what a process does; "" if there is none or it cannot be seen."""
    try:
        with open(f"/proc/{pid}/stat", encoding="utf-8", errors="replace") as stat:
            return stat.read().rpartition(")")[2].split()[0]
    except OSError:
        return ""


def ended(child: subprocess.Popen[bytes]) -> int | None:
    """How a child has ended, as an exit code, -N: signal N; None if it has not. It stays a zombie where that can be."""
    if not hasattr(os, "waitid"):
        return child.poll()
    try:
        found = os.waitid(os.P_PID, child.pid, os.WEXITED | os.WNOHANG | os.WNOWAIT)
    except ChildProcessError:
        return child.wait()
    if found is None:
        return None
    return found.si_status if found.si_code == os.CLD_EXITED else -found.si_status


def exit_told(how: int | str, said: str) -> str:
    """How a process has ended, with its last line."""
    if isinstance(how, str):
        return f"could not be started ({how})"
    if how >= 0:
        told = f"ended with exit code {how}"
    else:
        known = {int(number): f" ({number.name})" for number in signal.Signals}
        told = f"was ended by signal {-how}{known.get(-how, '')}"
    lines = said[-TAIL_chars:].strip().splitlines()
    return f'{told} and last wrote "{lines[-1].strip()}"' if lines else told
