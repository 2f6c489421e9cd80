"""States of processes, and limits of the system for a run in processes.

An overdue process is probed before it is replaced: it may be in a long step, or held by a debugger.

after NOTICE_s      a process in state T (stopped by a user) is reported, so that it can be continued
after each deadline its progress is queried; a thread of its own answers with its number of steps (alive.py)
    no answer, or it cannot answer because it is stopped      lost
    no step since the last query                              lost, with the place where it hangs
    a debugger holds it, or it has made steps                 it may go on until the next deadline
"""

import os
import resource
import signal
import subprocess
from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

from heavylift.coordinator.protocol.messages import Alive
from heavylift.kernel.errors import ProtocolError

GONE = ("", "Z")  # what the system says of a process that has ended
TAIL_chars = 300
MB = 1 << 20
LIMITS = (  # of the system, below which libraries end even a small run in words of their own
    (resource.RLIMIT_NOFILE, 32, 1, "files may be open at once", "-n 256"),
    (resource.RLIMIT_AS, 800, MB, "MB of memory may be addressed by a process", "-v unlimited"),
)


def check_room() -> None:
    """Check the user's system limits; raises ProtocolError for a limit that is too low for a run in processes."""
    for kind, needed, unit, what, command in LIMITS:
        given = resource.getrlimit(kind)[0]
        if given != resource.RLIM_INFINITY and given < needed * unit:
            raise ProtocolError(
                f"only {given // unit} {what}, and a run in processes needs at least {needed}; raise the limit "
                f"(`ulimit {command}`) or run --in-process"
            )


def state(pid: int) -> str:
    """Return the state letter of a process from the system; "" if it is not visible."""
    try:
        with open(f"/proc/{pid}/stat", encoding="utf-8", errors="replace") as stat:
            return stat.read().rpartition(")")[2].split()[0]
    except OSError:
        return ""


def ended(child: subprocess.Popen[bytes]) -> int | None:
    """Return the exit code of a child process, -N after signal N, if possible without reaping it; None while it
    runs."""
    if not hasattr(os, "waitid"):
        return child.poll()
    try:
        found = os.waitid(os.P_PID, child.pid, os.WEXITED | os.WNOHANG | os.WNOWAIT)
    except ChildProcessError:
        return child.wait()
    if found is None:
        return None
    return found.si_status if found.si_code == os.CLD_EXITED else -found.si_status


def exit_message(how: int | str, text: str) -> str:
    """Return a sentence on how a process ended, with its last line of output."""
    if isinstance(how, str):
        return f"could not be started ({how})"
    if how >= 0:
        message = f"ended with exit code {how}"
    else:
        known = {int(number): f" ({number.name})" for number in signal.Signals}
        message = f"was ended by signal {-how}{known.get(-how, '')}"
    lines = text[-TAIL_chars:].strip().splitlines()
    return f'{message} and last wrote "{lines[-1].strip()}"' if lines else message


NOTICE_s = 2.0


class Crew(Protocol):
    """Interface by which the supervisor examines the node processes on this machine."""

    def pid(self, process: str) -> int | None:
        """Return the process id of the process with this name."""

    def state(self, process: str) -> str:
        """Return the state letter of a process: T for stopped, t for held by a debugger; "" if it is not visible."""

    def place(self, process: str) -> str:
        """Return the line of code at which a process is, as text; "" if unknown."""


@dataclass
class _Debt:
    since: float  # when it was told what it has not answered
    asked: float
    steps: int | None = None
    noticed: bool = False


class StallDetector:
    """Detects processes that have stopped making progress while they owe an answer.

    `ask` asks a process for its progress, `tell` receives notices for the user.
    """

    def __init__(
        self, deadline: float, crew: Crew, ask: Callable[[str], Alive | None], tell: Callable[[str], None]
    ) -> None:
        self.deadline, self._crew, self._ask, self._tell = deadline, crew, ask, tell
        self._debts: dict[str, _Debt] = {}

    def lost(self, process: str, since: float, now: float) -> str | None:
        """Return why a process counts as lost; "" if it does not, None if undecided.

        `since`: time [monotonic s] since which it owes an answer."""
        debt = self._debts.get(process)
        if debt is None or debt.since != since:
            debt = self._debts[process] = _Debt(since, since)
        if now - since > NOTICE_s and not debt.noticed and self._crew.state(process) == "T":
            debt.noticed = True
            left = self.deadline - (now - since)
            pid = self._crew.pid(process)
            self._tell(f"process {pid} of {process} is stopped; `kill -CONT {pid}`, or it is replaced in {left:.0f} s")
        if now - debt.asked < self.deadline:
            return None
        debt.asked = now
        state = self._crew.state(process)
        if state == "T":
            pid = self._crew.pid(process)
            return f"its process {pid} is stopped (SIGSTOP) and was not continued within {self.deadline:g} s"
        answer = self._ask(process)
        if answer is None:
            return f"its process has not said for {self.deadline:g} s that it is alive{self._where(process)}"
        held = state == "t" or answer.traced
        if held:
            self._tell(f"a debugger holds process {process}; the run waits for it")
        elif answer.steps == debt.steps:
            return f"its process has done no step for {self.deadline:g} s{self._where(process)}"
        debt.steps = None if held else answer.steps
        return ""

    def _where(self, process: str) -> str:
        place = self._crew.place(process)
        return f", at {place}" if place else ""
