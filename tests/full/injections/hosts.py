"""Faults of processes on other hosts: cut, silent or slow connections, kills, and replacements."""

from __future__ import annotations

import atexit
import shutil
import signal
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Callable
from functools import cache
from importlib.util import find_spec
from pathlib import Path

from .trial import RESUMED, SAME, SENTENCE, Ended, Kind, NotAsPromised, Trial
from .workloads import HEAVYLIFT, processes_of

sys.path.append(str(Path(__file__).parents[2] / "coordinator" / "hosts"))

from line import Line
from of_a_yard import free_port

MOST_bytes = {"start": 6_000, "run": 60_000}  # that a line carries before it ends
ONE = threading.Lock()
LOST = 86  # exit code of a process that has lost its coordinator


def keys() -> Path:
    """Certificates of a yard, one for all cases."""
    with ONE:
        return _made()


@cache
def _made() -> Path:
    folder = Path(tempfile.mkdtemp(prefix="yard-", dir="/tmp"))
    atexit.register(shutil.rmtree, folder, ignore_errors=True)
    subprocess.run([HEAVYLIFT, "certificates", folder / "keys", *processes_of("lift")], check=True, capture_output=True)
    return folder / "keys"


class Yard:
    """A run that waits for one process of another host."""

    def __init__(self, trial: Trial) -> None:
        self.trial, self.who, self.port = trial, trial.random.choice(processes_of("lift")), free_port()
        listen = ["--remote", self.who, "--listen", f"tls/127.0.0.1:{self.port}", "--certificates", keys()]
        self.run = trial.start([*trial.command, *listen])
        trial.until(self.run, f"waiting for process {self.who}")

    def node(self, port: int = 0, to: str = "node") -> subprocess.Popen[bytes]:
        """The process, over a line or directly."""
        at = f"tls/127.0.0.1:{port or self.port}"
        return self.trial.start([HEAVYLIFT, "node", self.who, "--connect", at, "--certificates", keys()], to)

    def end(self) -> Ended:
        """The end of the run, with successors as long as they are needed."""
        while self.run.poll() is None:
            successor = self.node(to="successor")
            while self.run.poll() is None and successor.poll() is None:
                time.sleep(0.02)
            if self.run.poll() is None:
                time.sleep(0.5)  # it was refused as long as its predecessor is thought to be there
            else:
                self.trial.end(successor, "successor")
        return self.trial.end(self.run)


def slow(trial: Trial) -> None:
    builder = Yard(trial)
    line = Line(builder.port, late_s=trial.random.choice([0.001, 0.003, 0.01]))
    node = builder.node(line.port)
    if (ended := trial.end(node, "node")).code:
        raise NotAsPromised(f"the process did not play: {ended.said[-600:]}")
    trial.same(trial.end(builder.run))
    line.listener.close()


def _ends(silent: bool) -> Callable[[Trial], None]:
    def ends(trial: Trial) -> None:
        builder = Yard(trial)
        line = Line(builder.port, trial.random.randrange(MOST_bytes[trial.case.moment]), silent)
        node = builder.node(line.port)
        while not line.ended.wait(0.02) and builder.run.poll() is None and node.poll() is None:
            pass
        trial.struck = line.ended.is_set()
        trial.same(builder.end())
        if silent:
            node.kill()
        line.listener.close()
        trial.end(node, "node")

    return ends


def _struck(number: int, gone: bool) -> Callable[[Trial], None]:
    """The process gets a signal; unless it is `gone`, it goes on or is continued."""

    def struck(trial: Trial) -> None:
        builder = Yard(trial)
        node = builder.node()
        if trial.case.moment == "run":
            trial.until(builder.run, "take up slack")
        time.sleep(trial.random.uniform(0.0, 0.6))
        trial.struck = node.poll() is None and builder.run.poll() is None
        if trial.struck:
            node.send_signal(number)
        if not gone:
            time.sleep(trial.random.choice([0.1, 1.0, 4.0]))
            node.send_signal(signal.SIGCONT)
        trial.same(builder.end() if gone else trial.end(builder.run))
        trial.end(node, "node")

    return struck


def no_coordinator(trial: Trial) -> None:
    builder = Yard(trial)
    node = builder.node()
    if trial.case.moment == "run":
        trial.until(builder.run, "take up slack")
    time.sleep(trial.random.uniform(0.0, 0.6))
    trial.struck = builder.run.poll() is None
    builder.run.kill()
    trial.end(builder.run)
    ended = trial.end(node, "node")
    if ended.code != 0 or trial.struck:
        trial.sentence(ended, "", (1, LOST, 0))
    trial.resumed()


def port_taken(trial: Trial) -> None:
    port = free_port()
    command = [
        *trial.command,
        "--remote",
        processes_of("lift")[0],
        "--listen",
        f"tls/127.0.0.1:{port}",
        "--certificates",
        keys(),
    ]
    first = trial.start([*command[:-1], keys()], to="first")
    trial.until(first, "waiting for process", "first")
    ended = trial.run([*command, "-o", trial.folder / "second.mcap"])
    first.send_signal(signal.SIGINT)
    message = trial.end(first, "first")
    if message.code != 128 + signal.SIGINT:
        raise NotAsPromised(f"exit code {message.code}: {message.said[-600:]}")
    trial.sentence(ended, str(port))


AGAIN = f"another one joins, {SAME}"
BOTH = ("start", "run")
KINDS = [
    Kind("line: slow", SAME, slow, ("run",), ("lift",)),
    Kind("line: cut", AGAIN, _ends(False), BOTH, ("lift",)),
    Kind("line: silent", AGAIN, _ends(True), ("run",), ("lift",)),
    *(
        Kind(f"remote process: {name}", AGAIN, _struck(number, True), BOTH, ("paced",))
        for name, number in [
            ("KILL", signal.SIGKILL),
            ("SEGV", signal.SIGSEGV),
            ("SIGINT", signal.SIGINT),
            ("SIGTERM", signal.SIGTERM),
            ("SIGHUP", signal.SIGHUP),
        ]
    ),
    Kind("remote process: STOP, CONT", SAME, _struck(signal.SIGSTOP, False), BOTH, ("paced",)),
    Kind("remote process: its coordinator is killed", f"{SENTENCE}; {RESUMED}", no_coordinator, BOTH, ("paced",)),
    Kind("remote process: the port is taken", SENTENCE, port_taken, ("start",), ("paced",)),
]
KINDS = KINDS if find_spec("cryptography") else []
