"""Runs of the open scene, each a process `heavylift run`, and what has been recorded in its folder."""

from __future__ import annotations

import re
import signal
import subprocess
import sys
import threading
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

from heavylift.coordinator.live import RunOrder, find, order
from heavylift.coordinator.verdict.judging import verdict_of
from heavylift.kernel.errors import HeavyliftError, SceneError
from heavylift.nodes.scene.text.files import within
from heavylift.recordings import Recording
from heavylift.recordings.documents.document import alternatives, report_sheet
from heavylift.recordings.documents.facts import facts
from heavylift.recordings.read.verdict import RecordedVerdict
from heavylift.recordings.render.view import content, page
from heavylift.recordings.sheets.sheet import page_of

from .editing import present

COMMAND = [sys.executable, "-c", "from heavylift.coordinator.cli import main; main()"]
ADDRESS = re.compile(r"watch it at (http://127\.0\.0\.1:\d+/[\w-]+/)")
ENDING = ".mcap"
MOST = 100  # recordings that are listed
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

    @property
    def goes_on(self) -> bool:
        """Whether a run is in progress."""
        return self._process is not None and self._process.poll() is None

    def start(self, scene: Path, folder: Path, live: bool = False) -> None:
        """Run a scene into the folder (`live`: with a page of its own); raises SceneError if a run is in progress."""
        file = folder / f"{scene.stem}{ENDING}"
        self._begin(folder, file, "run", str(scene), "-o", str(file), "--force", *(["--view"] if live else []))

    def plan(self, scene: Path, folder: Path, budget: str) -> None:
        """Search for the shortest timing of a scene within a wall time; the result is written next to it as
        NAME-planned.yaml."""
        file = folder / f"{scene.stem}-planned.yaml"
        self._begin(folder, file, "plan", str(scene), "-o", str(file), "--force", "--budget", budget)

    def _begin(self, folder: Path, file: Path, *words: str) -> None:
        with self._lock:
            if self.goes_on:
                raise SceneError("a run goes on; wait for its end, or stop it")
            self._file = file
            self._process = subprocess.Popen(
                [*COMMAND, *words],
                cwd=folder,
                stdin=subprocess.DEVNULL,
                stdout=subprocess.PIPE,
                stderr=subprocess.STDOUT,
                text=True,
            )
        threading.Thread(target=self._hear, args=(self._process,), daemon=True, name="run of a scene").start()

    def order(self, do: str, text: str = "") -> str:
        """Give an order to the run: pause, continue, command or stop; returns its reply."""
        if not self.goes_on:
            raise SceneError("no run goes on")
        assert self._process is not None
        if do == "stop":
            self._process.send_signal(signal.SIGINT)
            return "stopping"
        if do not in ("pause", "continue", "command"):
            raise SceneError(f"'{do}' is no order: pause, continue, command, stop")
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

    def _hear(self, process: subprocess.Popen[str]) -> None:
        lines, file = list[str](), self._file
        known = {"file": file.name, "live": ""}
        self._say("run", {"running": True, "lines": [], **known})
        assert process.stdout is not None
        for line in process.stdout:
            if found := ADDRESS.search(line):
                known["live"] = found[1]
            else:
                lines = [*lines, line.rstrip("\n")][-LINES:]
            self._say("run", {"running": True, "lines": lines, **known})
        code = process.wait()
        self._say("run", {"running": False, "lines": lines, **known, "code": code})
        if file.suffix == ".yaml" and file.exists():
            self._say("proposal", {"file": file.name, "text": present(file)})


def recordings(folder: Path) -> Iterator[dict[str, str]]:
    """Return the recordings of a folder, newest first, with their verdicts."""
    found = sorted(folder.glob(f"*{ENDING}"), key=lambda path: -path.stat().st_mtime_ns)
    for path in found[:MOST]:
        try:
            verdict = verdict_of(Recording(path))
            yield {
                "name": path.name,
                "state": verdict.state if verdict else "none",
                "line": verdict.line if verdict else "",
            }
        except (HeavyliftError, OSError) as error:
            yield {"name": path.name, "state": "none", "line": str(error)}


def result(folder: Path, kind: str, name: str) -> str:
    """Return the page of a recording in the folder, `view` in 3D or `report`; raises HeavyliftError if there is
    none."""
    rec, verdict = _recorded(folder, name)
    if kind not in ("view", "report"):
        raise SceneError(f"'{kind}' is no page of a recording")
    return page(content(rec, verdict)) if kind == "view" else page_of(report_sheet(rec, verdict, pictures=True))


def compared(folder: Path, a: str, b: str) -> str:
    """Return the page that compares two recordings in the folder; raises HeavyliftError if there are none."""
    one, other = (facts(*_recorded(folder, name)) for name in (a, b))
    return page_of(alternatives(one, other, pictures=True))


def _recorded(folder: Path, name: str) -> tuple[Recording, RecordedVerdict | None]:
    try:
        path = within(folder, folder / name)
    except ValueError as error:
        raise SceneError(f"'{name}': {error}") from None
    if path.suffix != ENDING:
        raise SceneError(f"'{name}' is no recording")
    rec = Recording(path)
    return rec, verdict_of(rec)
