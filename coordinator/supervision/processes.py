"""Starts the node processes of a run, tells how they end, and ends them all.

`Processes` starts its keeper (keeper.py) at once and in the background: make it first, do the slow imports
and the scene meanwhile, then `start`. No node outlives the coordinator: when this process is gone, however it
ended, the keeper kills the nodes within milliseconds, and nodes that have lost their keeper exit themselves.
A process can be replaced: `kill` it, let the hub `renew` it, `begin` it; with a lost keeper all are replaced.
Nodes stand in a session of their own, so that Ctrl-C reaches the coordinator only, which ends them in order.
"""

from __future__ import annotations

import contextlib
import json
import os
import resource
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Mapping, Sequence
from types import TracebackType
from typing import Self

from heavylift.coordinator.supervision.keeper import STACKS, python
from heavylift.coordinator.transport.hub import Hub
from heavylift.kernel.errors import ProtocolError

__all__ = ["Processes", "state"]

TERMINATE_s = 0.4  # from SIGTERM to SIGKILL
KILL_s = 0.5  # from SIGKILL to giving up
REAP_s = 10.0  # the same for a process that must not live beside its successor
STACKS_s = 0.5  # in which a process writes where it is
TAIL_chars = 300
FILES = 32  # that the coordinator of a small run opens


class Processes:
    """The node processes of one run."""

    def __init__(self, preload: Sequence[str] = (), fork: bool = sys.platform == "linux") -> None:
        """`preload`: modules for every node that start no thread; without `fork`, fresh interpreters."""
        if (files := resource.getrlimit(resource.RLIMIT_NOFILE)[0]) < FILES:
            raise ProtocolError(
                f"only {files} files may be open at once, and a run in processes needs at least {FILES}; raise the "
                "limit (`ulimit -n 256`) or run --in-process"
            )
        self._command = python("keep", ["heavylift.coordinator.transport.link", *preload], not fork)
        self.pids: dict[str, int] = {}
        """Process id of each process that has been started."""
        self._exits: dict[str, int] = {}
        self._hub: Hub | None = None
        self._commands: dict[str, Sequence[str]] = {}
        self._change = threading.Condition()
        self._launch()

    def _launch(self) -> None:
        self._keeper = subprocess.Popen(
            self._command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, start_new_session=True
        )
        self._keeper_gone = False
        self._reader = threading.Thread(target=self._read_reports, name="keeper reports", daemon=True)
        self._reader.start()

    def start(self, hub: Hub, commands: Mapping[str, Sequence[str]]) -> None:
        """Start every process: name -> (module, arguments...); the module's `main(arguments)` makes its Link."""
        self._hub, self._commands = hub, dict(commands)
        hub.supervise(self.deaths)
        for process in commands:
            self.begin(process)

    def begin(self, process: str) -> None:
        """Start the present incarnation of a process."""
        assert self._hub is not None, "there is a run"
        module, *arguments = self._commands[process]
        self._order(
            do="start",
            name=process,
            module=module,
            arguments=arguments,
            environment=self._hub.ticket(process).to_environment(),
            log=str(self._hub.directory.log(process)),
            directory=str(self._hub.directory.path),
        )

    def kill(self, process: str) -> None:
        """Kill a process if it is there, and return when the system has forgotten it."""
        if not self._keeper_gone:
            self._order(do="signal", signal=int(signal.SIGKILL), name=process)
            with self._change:
                self._change.wait_for(lambda: process in self._exits or self._keeper_gone, timeout=REAP_s)
        if self._keeper_gone:
            self._replace_keeper()
        with self._change:
            if self._exits.pop(process, None) is None and process in self.pids:
                raise ProtocolError(
                    f"process {self.pids[process]} of {process} cannot be killed, it hangs in the system; "
                    "end what it waits for and start the run again"
                )
            self.pids.pop(process, None)

    def _replace_keeper(self) -> None:
        """A new keeper, after all that the old one has started is gone."""
        self._reader.join()
        self._end_group()
        until = time.monotonic() + REAP_s
        while (left := [pid for pid in self.pids.values() if state(pid) not in ("", "Z")]) and time.monotonic() < until:
            time.sleep(0.005)
        with self._change:
            self._exits = {name: -signal.SIGKILL for name, pid in self.pids.items() if pid not in left}
        self._launch()

    def pid(self, process: str) -> int | None:
        """The process id of its present incarnation."""
        return self.pids.get(process)

    def state(self, process: str) -> str:
        """The system's letter for what it does, T if it is stopped; "" if that cannot be seen."""
        return state(self.pids.get(process, 0))

    def place(self, process: str) -> str:
        """Where its main thread is; the stacks of all its threads are in its log then."""
        if process not in self.pids:
            return ""
        before = len(self.output(process))
        self._order(do="signal", signal=int(STACKS), name=process)
        until, stacks = time.monotonic() + STACKS_s, ""
        while not stacks.endswith("\n") and time.monotonic() < until:
            time.sleep(0.02)
            stacks = self.output(process)[before:]
        _, _, main = stacks.partition("Current thread")
        return next((line.strip() for line in main.splitlines() if line.strip().startswith("File")), "")

    def deaths(self) -> dict[str, str]:
        """How each process that has ended did so, with the last line that it wrote."""
        with self._change:
            exits = dict(self._exits)
        if self._keeper_gone and self._hub is not None:
            return dict.fromkeys(self._hub.placement.processes, "the process that starts and keeps all nodes has ended")
        return {node: self._obituary(node, code) for node, code in exits.items()}

    def output(self, node: str) -> str:
        """All that a node has written to its standard output and error."""
        assert self._hub is not None
        log = self._hub.directory.log(node)
        return log.read_text(errors="replace") if log.exists() else ""

    def end(self, grace: float = 0.8) -> None:
        """End all: wait `grace` [s] for nodes to leave, then SIGTERM, then SIGKILL; nothing is left."""
        if self._keeper.returncode is not None:
            return
        for number, patience in (
            (None, grace),
            (signal.SIGTERM, TERMINATE_s),
            (signal.SIGKILL, KILL_s),
        ):
            if self._keeper_gone:
                break
            if number is not None and self._alive():
                self._order(do="signal", signal=int(number))
            with self._change:
                if self._change.wait_for(lambda: not self._alive(), timeout=patience):
                    break
        self._order(do="leave")
        assert self._keeper.stdin is not None
        with contextlib.suppress(BrokenPipeError):
            self._keeper.stdin.close()
        self._reader.join(timeout=KILL_s)  # the reports end with the keeper
        self._end_group()
        self._reader.join()

    def _end_group(self) -> None:
        """Kill what a keeper that is gone has left behind."""
        with contextlib.suppress(ProcessLookupError, PermissionError):
            os.killpg(self._keeper.pid, signal.SIGKILL)
        self._keeper.wait()

    def _alive(self) -> list[str]:
        return [node for node in self.pids if node not in self._exits]

    def _order(self, **order: object) -> None:
        assert self._keeper.stdin is not None
        try:
            self._keeper.stdin.write(json.dumps(order).encode() + b"\n")
            self._keeper.stdin.flush()
        except (BrokenPipeError, ValueError):  # the keeper has ended: deaths() says so
            return

    def _read_reports(self) -> None:
        assert self._keeper.stdout is not None
        for line in self._keeper.stdout:
            report = json.loads(line)
            with self._change:
                if "pid" in report:
                    self.pids[report["name"]] = report["pid"]
                else:
                    self._exits[report["name"]] = report["ended"]
                self._change.notify_all()
            if "ended" in report and self._hub is not None:
                self._hub.notice()
        with self._change:
            self._keeper_gone = True
            self._change.notify_all()
        if self._hub is not None:
            self._hub.notice()

    def _obituary(self, node: str, code: int) -> str:
        if code >= 0:
            how = f"its process ended with exit code {code}"
        else:
            try:
                how = f"its process was ended by signal {-code} ({signal.Signals(-code).name})"
            except ValueError:
                how = f"its process was ended by signal {-code}"
        lines = self.output(node)[-TAIL_chars:].strip().splitlines()
        return f'{how} and last wrote "{lines[-1].strip()}"' if lines else how

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.end(grace=0.8 if error is None else 0.0)


def state(pid: int) -> str:
    """The system's letter for what a process does; "" if there is none or it cannot be seen."""
    try:
        with open(f"/proc/{pid}/stat") as stat:
            return stat.read().rpartition(")")[2].split()[0]
    except OSError:
        return ""
