"""The process manager: a small process that starts the nodes of a run, watches them, and leaves none of them behind.

It has imported what the nodes need, has one thread and no session, and forks one node per order: 12 nodes start in a
quarter of the time of 12 fresh interpreters. Where forking without exec is not safe (macOS, or an import that has
started threads) it executes a fresh interpreter; everything else stays the same.

    orders on standard input     {"do": "start", ...}   {"do": "signal", ...}     JSON lines
                                 a signal goes to all nodes, or to the one that is named
    reports on standard output   {"name", "pid"} of a started node; {"obeyed"} after each order;
                                 {"name", "ended"}: exit code, -N: signal N, or why it could not be started

The coordinator kills the process manager when everything is over. If the orders end earlier, the coordinator is gone:
the process manager kills its nodes and removes the run's directory. If it is stopped or dead itself, the first node
that notices does so: only the coordinator holds the other end of the life line, a pipe that all nodes read. So that a
node can notice, the system continues a stopped process when its parent dies.
"""

import contextlib
import ctypes
import faulthandler
import gc
import importlib
import json
import os
import select
import shutil
import signal
import sys
import tempfile
import threading
import time
import traceback
from collections.abc import Sequence
from typing import Any, NoReturn

STACKS = signal.SIGUSR1
PR_SET_PDEATHSIG = 1
REMOVE_s = 1.0  # in which a directory that somebody still writes to can be deleted


def keep(preload: Sequence[str], fresh: bool, life_line: int, directory: str) -> None:
    """Run the process manager, which starts and kills node processes by order of the coordinator, until the orders end.

    `fresh`: start a new interpreter for each node.
    """
    wake_as_an_orphan()
    reports = os.dup(1)
    os.dup2(2, 1)  # for what modules print while they are imported
    gc.set_threshold(50_000)  # as in the command itself
    for module in () if fresh else preload:
        importlib.import_module(module)
    gc.freeze()
    _Keeper(fresh or threads() != 1, reports, life_line, directory).serve()


def wake_as_an_orphan() -> None:
    """Ask Linux to continue this process when its parent dies, since a stopped process could not end by itself."""
    if sys.platform == "linux":
        ctypes.CDLL(None).prctl(PR_SET_PDEATHSIG, int(signal.SIGCONT))


def threads() -> int:
    """Return the number of threads of this process."""
    try:
        return len(os.listdir("/proc/self/task"))
    except FileNotFoundError:
        return threading.active_count()


class _Keeper:
    def __init__(self, fresh: bool, reports: int, life_line: int, directory: str) -> None:
        self.fresh, self.reports, self.life_line, self.directory = fresh, reports, life_line, directory
        self.names: dict[int, str] = {}
        self.child_ended, self.child_ended_end = os.pipe()
        os.set_blocking(self.child_ended_end, False)
        signal.signal(signal.SIGCHLD, lambda *_: None)
        signal.set_wakeup_fd(self.child_ended_end, warn_on_full_buffer=False)

    def serve(self) -> None:
        """Handle the coordinator's orders and the ends of nodes in a loop."""
        rest, orders = b"", sys.stdin.fileno()
        while True:
            readable, _, _ = select.select([orders, self.child_ended], [], [])
            if self.child_ended in readable:
                os.read(self.child_ended, 4096)
                self.reap()
            if orders in readable:
                data = os.read(orders, 65536)
                if not data:
                    self.kill_all()
                    return remove(self.directory)
                *lines, rest = (rest + data).split(b"\n")
                for line in lines:
                    order = json.loads(line)
                    self.execute(order)
                    self.report({"obeyed": order["do"]})

    def execute(self, order: dict[str, Any]) -> None:
        if order["do"] == "start":
            try:
                pid = os.fork()
            except OSError as error:
                return self.report({"name": order["name"], "ended": error.strerror})
            if pid == 0:
                self.become(order)
            self.names[pid] = order["name"]
            self.report({"name": order["name"], "pid": pid})
        else:
            for pid, name in self.names.items():
                if order.get("name") in (None, name):
                    os.kill(pid, order["signal"])

    def reap(self) -> None:
        while self.names:
            pid, status = os.waitpid(-1, os.WNOHANG)
            if pid == 0:
                return
            if pid in self.names:
                self.report({"name": self.names.pop(pid), "ended": os.waitstatus_to_exitcode(status)})

    def kill_all(self) -> None:
        for pid in self.names:
            os.kill(pid, signal.SIGKILL)
        for pid in self.names:
            os.waitpid(pid, 0)

    def report(self, what: dict[str, object]) -> None:
        """Send a report to the coordinator; errors are ignored, since a lost coordinator also sends no further
        orders."""
        with contextlib.suppress(BrokenPipeError):
            os.write(self.reports, json.dumps(what).encode() + b"\n")

    def become(self, order: dict[str, Any]) -> NoReturn:
        """Turn the forked child process into a node process, with output files of its own and the ticket as input."""
        try:
            wake_as_an_orphan()
            signal.set_wakeup_fd(-1)
            signal.signal(signal.SIGCHLD, signal.SIG_DFL)
            signal.signal(signal.SIGINT, signal.SIG_DFL)
            for fd in (self.reports, self.child_ended, self.child_ended_end):
                os.close(fd)
            log = os.open(order["log"], os.O_WRONLY | os.O_CREAT | os.O_APPEND, 0o600)
            for to in (1, 2):
                os.dup2(log, to)
            with tempfile.TemporaryFile(dir=self.directory) as ticket:  # it has no name
                ticket.write(order["ticket"].encode())
                ticket.seek(0)
                os.dup2(ticket.fileno(), 0)
            at = self.life_line, self.directory, order["module"], order["arguments"]
            if self.fresh:
                os.set_inheritable(self.life_line, True)
                command = python("enter", *at)
                os.execv(command[0], command)
            name_process(order["name"])
            enter(*at)
        except BaseException:
            traceback.print_exc()
        os._exit(1)


def remove(directory: str) -> None:
    """Delete the directory of a run, even while other processes write or delete files in it."""
    until = time.monotonic() + REMOVE_s
    while os.path.exists(directory) and time.monotonic() < until:
        shutil.rmtree(directory, ignore_errors=True)


def name_process(node: str) -> None:
    """Show the name of the node in `top` and `ps -c`, if the system allows it."""
    with contextlib.suppress(OSError), open("/proc/self/comm", "w", encoding="utf-8") as comm:
        comm.write(f"hl {node}")


def python(function: str, *arguments: object) -> list[str]:
    """Return the command line of a new interpreter, with this one's module path, that calls a function of this file."""
    call = f"from {__name__} import {function}; {function}{arguments!r}"
    return [sys.executable, "-c", f"import sys; sys.path[:] = {sys.path!r}; {call}"]


def enter(life_line: int, directory: str, module: str, arguments: Sequence[str]) -> NoReturn:
    """Run `main(arguments)` of a module in a new node process, with its return value (None: 0) as exit code.

    On the signal STACKS the process writes the stacks of all threads to its log, even if it hangs in foreign code.
    """
    threading.Thread(target=_guard, args=(life_line, directory), name="life line", daemon=True).start()
    faulthandler.register(STACKS)
    code = 1
    try:
        result = importlib.import_module(module).main(list(arguments))
        code = 0 if result is None else int(result)
    except SystemExit as exit_:
        code = exit_.code if isinstance(exit_.code, int) else int(exit_.code is not None)
    except BaseException:
        traceback.print_exc()
    for stream in (sys.stdout, sys.stderr):
        stream.flush()
    os._exit(code)


def _guard(life_line: int, directory: str) -> None:
    """Wait for the coordinator's end; if it disappears, remove the run's directory and kill all processes."""
    os.read(life_line, 1)
    remove(directory)
    os.killpg(0, signal.SIGKILL)
