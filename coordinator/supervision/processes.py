"""Start the node processes of a run, report how they end, and end all of them.

`Processes` starts its process manager (process_manager.py) at once and in the background: create it first, do the slow
imports and the scene meanwhile, then `start`. No node outlives the coordinator: when this process is gone, however it
ended, the process manager kills the nodes within milliseconds, or the first node that notices does so. A process can be
replaced: `kill` it, let the hub `renew` it, `begin` it; if the process manager is lost, all are replaced. Nodes run in
a session of their own, so that Ctrl-C reaches the coordinator only, which ends them in order.
"""

import contextlib
import json
import os
import secrets
import signal
import subprocess
import sys
import tempfile
import threading
import time
from collections import deque
from collections.abc import Callable, Mapping, Sequence
from contextlib import AbstractContextManager
from io import FileIO
from queue import SimpleQueue
from typing import IO, TYPE_CHECKING

from heavylift.coordinator.stopping import open_streams, whole
from heavylift.coordinator.transport.frame import RunDirectory
from heavylift.kernel.errors import ProtocolError

from .hash_seed import SEED
from .os_limits import GONE, check_room, ended, exit_message, state
from .process_manager import STACKS, python

if TYPE_CHECKING:
    from heavylift.coordinator.transport.hub import Hub

KEEPER = "the keeper"  # in place of a process's name, and no name that one can have
GRACE_s = 0.8  # in which nodes leave a run that is over
REPORT_s = 0.3  # in which a keeper that is not stopped tells how a process has ended; between two looks at them all
KILL_s = 0.5  # from SIGKILL to giving up
REAP_s = 10.0  # the same for a process that must not live beside its successor
POLL_s = 0.05  # between two looks at a keeper that owes an answer
ONE_THREAD = {"OPENBLAS_NUM_THREADS": "1"}  # NumPy would start more when it is imported, and forks want none
STACKS_s = 0.5  # in which a process writes where it is


class Processes(AbstractContextManager["Processes"]):
    """The node processes of one run, and its private directory."""

    def __init__(self, preload: Sequence[str] = (), fork: bool = sys.platform == "linux") -> None:
        """`preload`: modules of every node, which start no threads; without `fork` each has a fresh interpreter."""
        check_room()
        open_streams()
        self.directory = RunDirectory.chosen()
        self.pids: dict[str, int] = {}
        """Process id of each process that has been started."""
        self._exits: dict[str, int | str] = {}  # exit code, or why it could not be started
        self._orphans: dict[str, str] = {}  # processes that a lost keeper has taken along, and how it was lost
        self._unreported: dict[str, float] = {}  # processes that have ended without a report, and since when
        self._next_check = 0.0
        self._hub: Hub | None = None
        self._commands: dict[str, Sequence[str]] = {}
        self._aside: list[str] = []  # processes that are no nodes
        self._change = threading.Condition()
        self._threads: list[threading.Thread] = []
        life_line, life = os.pipe()
        self._life_line, self._life = FileIO(life_line), FileIO(life, "w")
        modules = ["heavylift.coordinator.transport.link", *preload]
        self._command = python("keep", modules, not fork, life_line, str(self.directory.path))
        try:
            self._launch()
            self.directory.make()  # the keeper knows of it already, and so nobody leaves it behind
        except BaseException:  # Ctrl-C, too
            if self._threads:
                self.end()
            raise

    def _launch(self) -> None:
        """Start a process manager; signals are deferred until it is registered."""
        pipe = subprocess.PIPE
        with whole():
            try:
                errors = tempfile.TemporaryFile()  # noqa: SIM115 - until the keeper has ended
                keeper = subprocess.Popen(
                    self._command, stdin=pipe, stdout=pipe, stderr=errors, pass_fds=(self._life_line.fileno(),),
                    start_new_session=True, env={**ONE_THREAD, **os.environ, **SEED},
                )  # fmt: skip
            except OSError as error:
                why = error.strerror
                raise ProtocolError(
                    f"no process can be started ({why}); end other processes or raise the limits of this user (ulimit)"
                ) from None
            self._know(keeper, errors)

    def _know(self, keeper: subprocess.Popen[bytes], errors: IO[bytes]) -> None:
        with self._change:  # another thread asks for deaths: it sees the old keeper as lost, or the new one
            self._errors, self._keeper = errors, keeper
            self._orders: SimpleQueue[bytes] = SimpleQueue()
            self._owed: deque[float] = deque()  # when it got the orders that it has not obeyed
            self._lost = ""  # how, in a sentence about the processes that it kept
        orders, reports = keeper.stdin, keeper.stdout
        assert orders is not None
        assert reports is not None
        self._threads = [
            threading.Thread(target=_write, args=(self._orders, orders), name="keeper orders", daemon=True),
            threading.Thread(target=self._read, args=(self._owed, reports), name="keeper reports", daemon=True),
        ]
        for thread in self._threads:
            thread.start()

    def start(self, hub: "Hub", commands: Mapping[str, Sequence[str]]) -> None:
        """Start every process, given as name -> (module, arguments...); the module's `main(arguments)` connects to the
        hub."""
        self._hub, self._commands = hub, dict(commands)
        hub.supervise(self.deaths)
        for name in self._aside:  # nobody waits for them any more
            self._order(do="signal", signal=int(signal.SIGKILL), name=name)
        for process in commands:
            self.begin(process)

    def begin(self, process: str) -> None:
        """Start the process that a node needs now: its first process or a replacement."""
        assert self._hub is not None, "there is a run"
        module, *arguments = self._commands[process]
        self._order(
            do="start", name=process, module=module, arguments=arguments, ticket=self._hub.ticket(process).to_text(),
            log=str(self.directory.log(process)),
        )  # fmt: skip

    def aside(self, module: str, given: str) -> Callable[[], str]:
        """Start a process that is no node: `main([])` of a module with the text `given` on standard input; return a
        function that waits until it has ended, however it did, and returns its output."""
        name = f"aside-{secrets.token_hex(4)}"
        self._aside.append(name)
        log = str(self.directory.log(name))
        self._order(do="start", name=name, module=module, arguments=[], ticket=given, log=log)

        def wait() -> str:
            while name not in self._exits and not self._loss():
                with self._change:
                    self._change.wait(POLL_s)
            return self.output(name)

        return wait

    @property
    def owed_since(self) -> float | None:
        """Time [monotonic s] of the oldest order that the process manager has not yet confirmed; None if there is
        none."""
        with self._change:
            return self._owed[0] if self._owed and not self._lost else None

    def give_up(self, how: str) -> None:
        """Mark the process manager and all its processes as lost."""
        with self._change:
            self._lost = self._lost or f"its process is gone, since the process manager was lost: {how}"
            self._change.notify_all()

    def _loss(self) -> str:
        """Return how the process manager was lost, or "" if it runs; a lost one stays a zombie, so that its process
        group is not reused."""
        with self._change:
            if not self._lost and (how := ended(self._keeper)) is not None:
                self._errors.seek(0)
                self.give_up("it " + exit_message(how, self._errors.read().decode(errors="replace")))
            return self._lost

    def kill(self, process: str, look: Callable[[], None] = lambda: None) -> None:
        """Kill a process and wait until it is gone.

        `look` is called while waiting for the process manager, and may call `give_up`."""
        self._order(do="signal", signal=int(signal.SIGKILL), name=process)
        while not self._loss() and self.owed_since is not None:
            look()
            with self._change:
                self._change.wait(POLL_s)
        until = time.monotonic() + REAP_s
        while not self._loss() and process in self._alive() and time.monotonic() < until:
            with self._change:
                self._change.wait(POLL_s)
        if self._lost:
            self._replace_keeper()
        with self._change:
            self._orphans.pop(process, None)
            ended, pid = self._exits.pop(process, None), self.pids.pop(process, None)
            self._unreported.pop(process, None)  # that was the one before
        if ended is None and pid is not None:
            raise ProtocolError(
                f"process {pid} of {process} cannot be killed, since it hangs in a system "
                "call; end what it waits for and start the run again"
            )

    def _replace_keeper(self) -> None:
        """Start a new process manager after all processes of the old one have gone."""
        self._end_group()
        until = time.monotonic() + REAP_s
        while (left := [pid for pid in self.pids.values() if state(pid) not in GONE]) and time.monotonic() < until:
            time.sleep(0.005)
        with self._change:
            self._exits = {name: -signal.SIGKILL for name, pid in self.pids.items() if pid not in left}
            self._orphans = dict.fromkeys(self._commands, self._lost)
        self._launch()

    def pid(self, process: str) -> int | None:
        """Return the process id of the process that now has this name."""
        return self._keeper.pid if process == KEEPER else self.pids.get(process)

    def state(self, process: str) -> str:
        """Return the state letter of a process, T if it is stopped; "" if it is not visible."""
        return state(self.pid(process) or 0)

    def place(self, process: str) -> str:
        """Return the place in the code where a process is; it also writes the stacks of all its threads to its log."""
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
        """Return for each ended process how it ended, with its last line of output."""
        if lost := self._loss():  # who is there may go on as long as nobody needs a keeper
            return {name: lost for name in self._commands if self.state(name) in GONE}
        with self._change:
            exits = {name: how for name, how in self._exits.items() if name not in self._aside}
            orphans, alive = dict(self._orphans), self._alive()
        found = {name: f"its process {exit_message(how, self.output(name))}" for name, how in exits.items()} | orphans
        now = time.monotonic()
        if now >= self._next_check:
            self._next_check = now + REPORT_s
            self._unreported = {n: self._unreported.get(n, now) for n in alive if self.state(n) == "Z"}
        silent = [name for name in alive if now - self._unreported.get(name, now) > REPORT_s]
        return found | dict.fromkeys(silent, "its process has ended, and the process manager does not report how")

    def output(self, node: str) -> str:
        """Return all standard output and error of a node."""
        log = self.directory.log(node)
        return log.read_text(encoding="utf-8", errors="replace") if log.exists() else ""

    def stop(self, grace: float = GRACE_s) -> None:
        """Wait `grace` [s] for nodes to end, then kill the remaining ones; the process manager stays."""
        with self._change:
            self._change.wait_for(lambda: not self._alive() or self._lost, timeout=grace)
        if self._alive():
            self._order(do="signal", signal=int(signal.SIGKILL))
            with self._change:
                self._change.wait_for(lambda: not self._alive() or self._lost, timeout=KILL_s)

    def end(self, grace: float = GRACE_s) -> None:
        """End all processes and remove the directory of the run."""
        if self._life.closed:
            return
        self.stop(grace)
        self.directory.remove()
        self.give_up("the run is over")
        self._end_group()
        self._life_line.close()
        self._life.close()

    def _end_group(self) -> None:
        """Kill the process manager and all its processes."""
        with contextlib.suppress(ProcessLookupError, PermissionError):
            os.killpg(self._keeper.pid, signal.SIGKILL)
        self._keeper.wait()
        self._orders.put(b"")
        for thread in self._threads:
            thread.join()
        for stream in (self._keeper.stdin, self._keeper.stdout, self._errors):
            assert stream is not None
            with contextlib.suppress(BrokenPipeError):
                stream.close()

    def _alive(self) -> list[str]:
        return [node for node in self.pids if node not in (*self._exits, *self._aside)]

    def _order(self, **order: object) -> None:
        with self._change:
            self._owed.append(time.monotonic())
        self._orders.put(json.dumps(order).encode() + b"\n")

    def _read(self, owed: deque[float], reports: IO[bytes]) -> None:
        """Read the reports of the process manager until it ends."""
        for line in reports:
            report = json.loads(line)
            with self._change:
                if "obeyed" in report:
                    owed.popleft()
                elif "pid" in report:
                    self.pids[report["name"]] = report["pid"]
                else:
                    self._exits[report["name"]] = report["ended"]
                self._change.notify_all()
            if "ended" in report and self._hub is not None:
                self._hub.notice()
        if self._hub is not None:
            self._hub.notice()

    def __exit__(self, _: object, error: BaseException | None, *__: object) -> None:
        self.end(grace=GRACE_s if error is None else 0.0)


def _write(orders: SimpleQueue[bytes], to: IO[bytes]) -> None:
    """Write orders in a separate thread, as a stopped process manager does not read them."""
    with contextlib.suppress(OSError):  # it has ended
        while order := orders.get():
            to.write(order)
            to.flush()
