"""The keeper: the small process that starts the nodes of a run, watches them, and outlives none of them.

It has imported what the nodes need, has one thread and no session, and forks one node per order: 12 nodes
stand in a quarter of the time that 12 fresh interpreters take. Where forking without exec is not safe
(macOS, or an import that has started threads) it executes a fresh interpreter; all else stays the same.

    orders on standard input     {"do": "start", ...}   {"do": "signal", ...}   {"do": "leave"}     JSON lines
                                 a signal goes to all nodes, or to the one that is named
    reports on standard output   {"name", "pid"} of a started node; {"name", "ended"}: exit code, -N: signal N

When the orders end without "leave", the coordinator is gone: the keeper kills its nodes and removes the run's
directory. When the keeper is gone, each node sees the end of its life line, a pipe that the keeper holds, and
exits.
"""

from __future__ import annotations

import contextlib
import faulthandler
import gc
import importlib
import json
import os
import select
import shutil
import signal
import sys
import threading
import traceback
from collections.abc import Sequence
from typing import Any, NoReturn

__all__ = ["ORPHANED", "STACKS", "enter", "keep", "python"]

STACKS = signal.SIGUSR1
ORPHANED = 86  # exit code of a node that has lost its keeper


def keep(preload: Sequence[str], fresh: bool) -> None:
    """Serve the coordinator's orders until they end; `fresh` executes a new interpreter for each node."""
    for module in () if fresh else preload:
        importlib.import_module(module)
    gc.freeze()
    _Keeper(fresh or threads() != 1).serve()


def threads() -> int:
    """Number of threads of this process that the system knows."""
    try:
        return len(os.listdir("/proc/self/task"))
    except FileNotFoundError:
        return threading.active_count()


class _Keeper:
    def __init__(self, fresh: bool) -> None:
        self.fresh = fresh
        self.names: dict[int, str] = {}
        self.directory: str | None = None
        self.life_line, self.life_line_end = os.pipe()
        self.child_ended, self.child_ended_end = os.pipe()
        os.set_blocking(self.child_ended_end, False)
        signal.signal(signal.SIGCHLD, lambda *_: None)
        signal.set_wakeup_fd(self.child_ended_end, warn_on_full_buffer=False)

    def serve(self) -> None:
        """The keeper's loop: orders and ended nodes, whichever comes first."""
        rest, orders = b"", sys.stdin.fileno()
        while True:
            readable, _, _ = select.select([orders, self.child_ended], [], [])
            if self.child_ended in readable:
                os.read(self.child_ended, 4096)
                self.reap()
            if orders in readable:
                data = os.read(orders, 65536)
                if not data:
                    return self.kill_all()
                *lines, rest = (rest + data).split(b"\n")
                for line in lines:
                    order = json.loads(line)
                    if order["do"] == "leave":
                        self.directory = None
                        return self.kill_all()
                    self.obey(order)

    def obey(self, order: dict[str, Any]) -> None:
        if order["do"] == "start":
            self.directory = order["directory"]
            pid = os.fork()
            if pid == 0:
                self.become(order)
            self.names[pid] = order["name"]
            report({"name": order["name"], "pid": pid})
        else:
            for pid, name in self.names.items():
                if order.get("name") in (None, name):
                    os.kill(pid, order["signal"])

    def reap(self) -> None:
        while self.names:
            pid, status = os.waitpid(-1, os.WNOHANG)
            if pid == 0:
                return
            report({"name": self.names.pop(pid), "ended": os.waitstatus_to_exitcode(status)})

    def kill_all(self) -> None:
        for pid in self.names:
            os.kill(pid, signal.SIGKILL)
        for pid in self.names:
            os.waitpid(pid, 0)
        if self.directory is not None:
            shutil.rmtree(self.directory, ignore_errors=True)

    def become(self, order: dict[str, Any]) -> NoReturn:
        """In the child: take the node's place, with its own output, environment and life line."""
        try:
            signal.set_wakeup_fd(-1)
            signal.signal(signal.SIGCHLD, signal.SIG_DFL)
            signal.signal(signal.SIGINT, signal.SIG_DFL)
            for fd in (self.life_line_end, self.child_ended, self.child_ended_end):
                os.close(fd)
            nothing = os.open(os.devnull, os.O_RDONLY)
            log = os.open(order["log"], os.O_WRONLY | os.O_CREAT | os.O_APPEND, 0o600)
            for fd, to in ((nothing, 0), (log, 1), (log, 2)):
                os.dup2(fd, to)
            os.environ.update(order["environment"])
            if self.fresh:
                os.set_inheritable(self.life_line, True)
                command = python("enter", self.life_line, order["module"], order["arguments"])
                os.execv(command[0], command)
            name_process(order["name"])
            enter(self.life_line, order["module"], order["arguments"])
        except BaseException:
            traceback.print_exc()
        os._exit(1)


def report(what: dict[str, object]) -> None:
    """Tell the coordinator; a coordinator that is gone shows at the end of its orders."""
    with contextlib.suppress(BrokenPipeError):
        os.write(1, json.dumps(what).encode() + b"\n")


def name_process(node: str) -> None:
    """Show the node's name in `top` and `ps -c`, where the system allows it."""
    with contextlib.suppress(OSError), open("/proc/self/comm", "w") as comm:
        comm.write(f"hl {node}")


def python(function: str, *arguments: object) -> list[str]:
    """The command of a new interpreter with this one's module path that calls a function of this file."""
    call = f"from {__name__} import {function}; {function}{arguments!r}"
    return [sys.executable, "-c", f"import sys; sys.path[:] = {sys.path!r}; {call}"]


def enter(life_line: int, module: str, arguments: Sequence[str]) -> NoReturn:
    """Run `main(arguments)` of the module; its return value (None: 0) is the exit code of this process.

    The signal STACKS makes it write where all its threads are to its log, even if it hangs in foreign code.
    """
    threading.Thread(target=_guard, args=(life_line,), name="life line", daemon=True).start()
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


def _guard(life_line: int) -> None:
    """Leave at once when the keeper is gone, whatever the node is doing."""
    os.read(life_line, 1)
    os._exit(ORPHANED)
