"""One trial: a run in its own folder, one injected fault, and whether the run ends as promised.

A kind names what goes wrong, says in one line what is promised, and has a function that does it to a trial and raises
`NotAsPromised` otherwise.  What holds for all kinds is asked here: the run ends, in no traceback and no internal error,
and leaves no process and no private directory behind.
"""

from __future__ import annotations

import os
import random
import re
import shutil
import signal
import subprocess
import tempfile
import time
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from heavylift.recordings import Recording

from . import leftovers
from .workloads import COMMANDS, DOOMED, HEAVYLIFT, RINGS, undisturbed

HANGS_s = 180.0  # a run that takes longer, even where others load the machine
SAME, SENTENCE = "the digest of the undisturbed run", "one sentence, exit code not 0"
RESUMED = "resumed to the digest of the undisturbed run (recovered, if only its end is damaged)"


class NotAsPromised(Exception):
    """What happened instead."""


@dataclass(frozen=True)
class Kind:
    """One row of the table."""

    name: str
    promise: str
    do: Callable[[Trial], None]
    moments: tuple[str, ...] = ("",)
    workloads: tuple[str, ...] = ("lift",)


@dataclass(frozen=True)
class Case:
    """One injection of a kind; `seed` draws what is left open."""

    kind: Kind
    moment: str
    workload: str
    seed: int

    def __str__(self) -> str:
        return ", ".join(filter(None, (self.kind.name, self.moment, self.workload)))


@dataclass(frozen=True)
class Ended:
    """A command, after its end."""

    code: int
    said: str  # on standard error


@dataclass
class Trial:
    """Carries one case out."""

    case: Case
    folder: Path = field(default_factory=lambda: Path(tempfile.mkdtemp(prefix="fault-", dir="/tmp")))
    failure: str = ""
    struck: bool = True
    times: list[tuple[float, ...]] = field(default_factory=list)  # detection, recovery, replay of each successor [s]

    def __post_init__(self) -> None:
        self.random = random.Random(f"{self.case.seed} {self.case}")
        self.temporary = self.folder / "tmp"
        self.temporary.mkdir()
        self.output = self.folder / "run.mcap"
        own = {"TMPDIR": str(self.temporary), leftovers.MARK: str(self.folder), "COLUMNS": "1000"}
        self.environment = {**os.environ, **own, "PYTHONPATH": str(DOOMED)}
        self.environment.pop("PYTHONDONTWRITEBYTECODE", None)  # as who has installed heavylift

    def carry_out(self) -> Trial:
        """Do it, and say what is not as promised."""
        try:
            self.case.kind.do(self)
            if left := leftovers.left(self.folder, self.temporary):
                raise NotAsPromised(f"left behind: {', '.join(left)}")
        except NotAsPromised as error:
            self.failure = str(error)
        except subprocess.TimeoutExpired:
            self.failure = f"no end within {HANGS_s:g} s"
        except Exception as error:
            self.failure = f"{type(error).__name__}: {error}"
        for pid in leftovers.processes(self.folder):
            with suppress(ProcessLookupError):
                os.kill(pid, signal.SIGKILL)
        shutil.rmtree(self.folder, ignore_errors=True)
        return self

    # ---- what a kind does ---------------------------------------------------------------------------------------

    @property
    def command(self) -> list[str]:
        """The run that is disturbed."""
        return [HEAVYLIFT, *COMMANDS[self.case.workload], "-o", str(self.output)]

    def start(self, command: Sequence[object] = (), to: str = "run", **how: Any) -> subprocess.Popen[bytes]:
        """Begin a command, by default the run; `to`: names the files of what it prints; `how`: arguments of Popen."""
        with (self.temporary / f"{to}.said").open("wb") as text:
            usual = {"env": self.environment, "cwd": self.folder, "stderr": text, "start_new_session": True}
            usual |= {"stdin": subprocess.DEVNULL, "stdout": subprocess.DEVNULL}
            return subprocess.Popen(list(map(str, command or self.command)), **(usual | how))

    def end(self, process: subprocess.Popen[bytes], to: str = "run") -> Ended:
        """Wait for it."""
        try:
            code = process.wait(HANGS_s)
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()
            raise
        return Ended(code, (self.temporary / f"{to}.said").read_text(errors="replace"))

    def run(self, command: Sequence[object] = (), to: str = "run", **how: Any) -> Ended:
        """Start, and wait."""
        return self.end(self.start(command, to, **how), to)

    def until(self, process: subprocess.Popen[bytes], words: str, to: str = "run") -> None:
        """Wait until it has said something."""
        until = time.monotonic() + HANGS_s
        while words not in (message := (self.temporary / f"{to}.said").read_text(errors="replace")):
            if process.poll() is not None or time.monotonic() > until:
                raise NotAsPromised(f"it never said '{words}': {message[-600:]}")
            time.sleep(0.01)

    def begun(self, seconds: float, process: subprocess.Popen[bytes]) -> Path | None:
        """Where the run records, as soon as it does and some time has gone; None if it has ended before."""
        part = self.output.with_name(f"{self.output.name}.part")
        while not part.exists():
            if process.poll() is not None:
                return None
            time.sleep(0.002)
        time.sleep(seconds)
        return part if process.poll() is None and part.exists() else None

    # ---- what is promised ---------------------------------------------------------------------------------------

    def same(self, ended: Ended, output: Path | None = None) -> None:
        """It has ended in order, with the digest of the undisturbed run."""
        if ended.code != 0:
            raise NotAsPromised(f"exit code {ended.code}: {ended.said[-600:]}")
        clean(ended)
        self.compare(output or self.output)

    def compare(self, output: Path) -> None:
        """The recording has the digest of the undisturbed run."""
        digest = Recording(output).result["digest"]
        if digest != undisturbed(self.case.workload)[0]:
            raise NotAsPromised(f"another digest, {digest}")

    def sentence(self, ended: Ended, pattern: str = "", codes: Sequence[int] = (1, 2)) -> None:
        """It has ended in one sentence."""
        clean(ended)
        if ended.code not in codes:
            raise NotAsPromised(f"exit code {ended.code}: {ended.said[-600:]}")
        if not any(re.search(pattern, line) for line in ended.said.splitlines() if line.startswith("heavylift: ")):
            raise NotAsPromised(f"no sentence with '{pattern}': {ended.said[-600:]!r}")

    def same_or_sentence(self, ended: Ended) -> None:
        """Either."""
        self.same(ended) if ended.code == 0 else self.sentence(ended)

    def resumed(self, output: Path | None = None, least_bytes: int = 0) -> None:
        """What was recorded, if more than so much was, leads to the digest; a network's is resumed by running again."""
        output = output or self.output
        part = output.with_name(f"{output.name}.part")
        rest = part if part.exists() else output
        if not rest.exists():
            if found := [entry.name for entry in output.parent.glob("*.mcap*")]:
                raise NotAsPromised(f"left behind: {found}")
            return
        if rest != part and Recording(rest).result["status"] == "finished":
            return self.compare(rest)
        if self.case.workload in RINGS or rest.stat().st_size < least_bytes:
            return
        again = self.run([HEAVYLIFT, "resume", rest, "-o", self.folder / "new.mcap"])
        if again.code and "the run in this file is complete; `heavylift recover" in again.said:
            again = self.run([HEAVYLIFT, "recover", rest, "-o", self.folder / "new.mcap"])
        if again.code:
            raise NotAsPromised(f"resume, recover: {again.said[-600:]}")
        self.compare(self.folder / "new.mcap")


def clean(ended: Ended) -> None:
    """What is printed is for its reader."""
    if found := re.search(r"Traceback|internal error|Fatal Python error|Exception ignored", ended.said):
        raise NotAsPromised(f"{found[0]}: {ended.said[-1000:]}")
