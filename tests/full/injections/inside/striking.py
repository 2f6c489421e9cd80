"""Injects one fault into one process of a run; processes.py chooses process, kind and moment."""

from __future__ import annotations

import json
import os
import resource
import signal
import subprocess
import threading
import time
from pathlib import Path
from typing import Any

PLAN: dict[str, Any] = json.loads(os.environ.get("HEAVYLIFT_INJECT", "{}"))
WHO, PHASE, ACT = (PLAN.get(word, "") for word in ("who", "phase", "act"))
SIGNALS = ("SIGINT", "SIGTERM", "SIGHUP", "SIGQUIT")
FATAL = {"KILL": signal.SIGKILL, "STOP": signal.SIGSTOP, "SEGV": signal.SIGSEGV}
NUMBERS = FATAL | {name: signal.Signals[name] for name in SIGNALS} | {"STOP, CONT": signal.SIGSTOP}
TWICE = "Ctrl-C twice"
ROOM_bytes = 1 << 20  # that a process without memory still gets


def once(what: str) -> bool:
    """Whether this has not happened in any process yet."""
    try:
        os.close(os.open(f"{PLAN['folder']}/{what}", os.O_CREAT | os.O_EXCL))
    except FileExistsError:
        return False
    return True


def hit(number: int) -> None:
    """Send this process a signal, and note when."""
    note()
    os.kill(os.getpid(), number)


def note() -> None:
    """Keep the moment of a blow for those who measure how long it takes to see it."""
    Path(PLAN["folder"], "blow").write_text(str(time.monotonic()))


def strike() -> None:
    """Do what is planned to this process, now or, if the system does it, a random moment later."""
    if not once("struck"):
        return
    if ACT == "STOP, CONT":
        waked = f"sleep {PLAN['stopped']}; kill -CONT {os.getpid()}"
        subprocess.Popen(["sh", "-c", waked], start_new_session=True)
    if ACT == TWICE:
        threading.Timer(PLAN["stopped"], os.kill, [os.getpid(), signal.SIGINT]).start()
    number = signal.SIGINT if ACT == TWICE else NUMBERS.get(ACT)
    if number is not None:
        late = threading.Timer(PLAN["delay"], hit, [number])
        late.start() if PLAN["delay"] and WHO != "keeper" else hit(number)
        return
    note()
    if ACT == "exit(0)":
        os._exit(0)
    if ACT == "memory":
        pages = int(open("/proc/self/statm").read().split()[0])  # noqa: SIM115
        room = pages * resource.getpagesize() + ROOM_bytes
        resource.setrlimit(resource.RLIMIT_AS, (room, room))
        bytearray(64 << 20)
    raise RuntimeError("injected")


def lose(node: str) -> None:
    """Kill this process, so that there is something to recover from."""
    if once(f"lost {node}"):
        hit(signal.SIGKILL)


class Imports:
    """Strikes when so many more modules have been looked for: a finder that finds none."""

    def __init__(self, left: int) -> None:
        self._left = left

    def find_spec(self, *_: object) -> None:
        self._left -= 1
        if self._left == 0:
            strike()
