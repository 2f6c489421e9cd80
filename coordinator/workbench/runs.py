"""Runs of the open scene, each a process of `heavylift`: one lift, studies, and the search for a shorter timing."""

from __future__ import annotations

import re
import signal
import subprocess
import sys
import threading
from collections.abc import Callable
from itertools import count
from pathlib import Path
from typing import IO, Any

from heavylift.coordinator.live import RunOrder, find, order
from heavylift.kernel.errors import SceneError

from .editing import present
from .results import ENDING, LIMITS

COMMAND = [sys.executable, "-c", "from heavylift.coordinator.cli import main; main()"]
ADDRESS = re.compile(r"watch it at (http://127\.0\.0\.1:\d+/[\w-]+/)")
LINES = 200  # of what a run prints
PATIENCE_s = 10.0  # for a run to finish its recording

Say = Callable[[str, dict[str, Any]], None]


class SceneRun:
    """Runs one simulation at a time; `say` sends its progress to pages."""

    def __init__(self, say: Say) -> None:
        self._say = say
        self._process: subprocess.Popen[str] | None = None
        self._lock = threading.Lock()
        self._file = Path()
        self.live = ""
        """Address of the live page of the run in progress; empty before the page is served, and for sweeps and
        searches."""

    @property
    def goes_on(self) -> bool:
        """Whether a run is in progress."""
        return self._process is not None and self._process.poll() is None

    def start(self, scene: Path, folder: Path, do: str, text: str) -> None:
        """Start a simulation of a scene with its results in the folder; raises SceneError if one is in progress.

        `run` the scene, `sweep` it over ranges, find the `limits` of numbers (ranges and numbers as lines of `text`),
        or `plan` its shortest timing within a wall time.
        """
        lines = [line for line in map(str.strip, text.splitlines()) if line]
        if do in ("sweep", "limits") and not lines:
            raise SceneError("name what to vary, such as block.mass=200..400 t by 50 t")
        match do:
            case "sweep":
                number = next(n for n in count(1) if not (folder / f"{scene.stem}-study-{n}").exists())
                file = folder / f"{scene.stem}-study-{number}"
                words = [f"--vary={line}" for line in lines]
            case "limits":
                file = folder / f"{scene.stem}{LIMITS}"
                words = ["--force", *(f"--of={line}" for line in lines)]
            case "plan":
                file = folder / f"{scene.stem}-planned.yaml"
                words = ["--force", f"--budget={text}"]
            case _:
                file = folder / f"{scene.stem}{ENDING}"
                words = ["--force", "--view"]
        with self._lock:
            if self.goes_on:
                raise SceneError("a run is in progress; wait for its end, or stop it")
            self._file, self.live = file, ""
            self._process = subprocess.Popen(
                [*COMMAND, do, str(scene), "-o", str(file), *words],
                cwd=folder,
                stdin=subprocess.DEVNULL,
                stdout=subprocess.PIPE,
                stderr=subprocess.PIPE,
                text=True,
            )
        threading.Thread(target=self._hear, args=(self._process, do), daemon=True, name="run of a scene").start()

    def order(self, do: str, text: str = "") -> str:
        """Give an order to the run: pause, continue, command or stop; returns its reply."""
        if not self.goes_on:
            raise SceneError("no run is in progress")
        assert self._process is not None
        if do == "stop":
            self._process.send_signal(signal.SIGINT)
            return "stopping"
        if do not in ("pause", "continue", "command"):
            raise SceneError(f"'{do}' is not an order; orders are pause, continue, command, stop")
        return order(find(str(self._file)), RunOrder(do, text=text))  # type: ignore[arg-type]

    def end(self) -> None:
        """Stop the run or search in progress."""
        if self.goes_on:
            assert self._process is not None
            self._process.send_signal(signal.SIGINT)
            try:
                self._process.wait(PATIENCE_s)
            except subprocess.TimeoutExpired:
                self._process.kill()

    def _hear(self, process: subprocess.Popen[str], do: str) -> None:
        """Send the output of a run to pages as it comes; after success, send its results before its messages on
        progress."""
        lines, found, progress, file = list[str](), list[str](), list[str](), self._file
        known: dict[str, Any] = {"do": do, "file": file.name, "live": False}
        self._say("run", {"running": True, "lines": [], **known})

        def hear(stream: IO[str] | None, *into: list[str]) -> None:
            for line in stream or ():
                if address := ADDRESS.search(line):
                    self.live, known["live"] = address[1], True
                for each in () if address else into:
                    each.append(line.rstrip("\n"))
                self._say("run", {"running": True, "lines": lines[-LINES:], **known})

        results = threading.Thread(target=hear, args=(process.stdout, lines, found))
        results.start()
        hear(process.stderr, lines, progress)
        results.join()
        code, self.live = process.wait(), ""
        shown = lines[-LINES:] if code else [*found, *progress][:LINES]
        self._say("run", {"running": False, "lines": shown, **known, "live": False, "code": code})
        if do == "plan" and file.exists():
            self._say("proposal", {"file": file.name, "text": present(file)})
            file.unlink()
