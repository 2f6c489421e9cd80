"""Runs every script of this folder, each by itself: prints its rows as they come and how long it took, checks them,
fails if one does.

    python tests/bench/all.py [--short] [--json] [--at-once N]

The short forms run two at a time, for their figures mean nothing; long ones alone.  `--json`: what else there is to say
goes to standard error.
"""

from __future__ import annotations

import os
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path

import msgspec
from shared.rows import JSON, SHORT, Row, line, options

HERE = Path(__file__)
PATIENCE_s = 120.0 if SHORT else 3600.0  # of one script; a short form takes 15 s on two idle cores


class Script:
    """One script, in a process group of its own and in a folder that goes with it."""

    def __init__(self, path: Path) -> None:
        self.name, self._began = path.name, time.monotonic()
        self.seconds, self.rows, self.fault, self._told = 0.0, "", "", 0
        self._folder = Path(tempfile.mkdtemp(prefix="bench-"))
        command = [sys.executable, str(path), "--json", *(["--short"] if SHORT else [])]
        with (self._folder / "rows").open("w") as rows, (self._folder / "errors").open("w") as errors:
            self._process = subprocess.Popen(
                command, stdout=rows, stderr=errors, cwd=self._folder, start_new_session=True
            )

    def ended(self) -> bool:
        """Whether it has; then the rest is known."""
        self.seconds = time.monotonic() - self._began
        code = self._process.poll()
        if code is None and self.seconds < PATIENCE_s:
            return False
        self.rows, errors = ((self._folder / name).read_text() for name in ("rows", "errors"))
        why = f"no end within {PATIENCE_s:g} s" if code is None else f"exit code {code}" if code else fault(self.rows)
        self.fault = f"{why}\n{errors}" if why else ""
        self.tell()
        self.end()
        return True

    def tell(self) -> None:
        """Print the rows that have come."""
        rows = (self._folder / "rows").read_text()
        new = rows[self._told : rows.rfind("\n") + 1]
        self._told += len(new)
        for text in new.splitlines():
            with suppress(msgspec.DecodeError):  # `fault` says so
                print(text if JSON else line(msgspec.json.decode(text, type=Row)), flush=True)

    def end(self) -> None:
        """Nothing of it is left."""
        with suppress(ProcessLookupError):
            os.killpg(self._process.pid, signal.SIGKILL)
        self._process.wait()
        shutil.rmtree(self._folder, ignore_errors=True)


def fault(rows: str) -> str:
    """What is wrong with the rows of a script; "" if nothing is."""
    for number, text in enumerate(rows.splitlines(), 1):
        try:
            row = msgspec.json.decode(text, type=Row)
        except msgspec.DecodeError as error:
            return f"line {number} is no row ({error}): {text}"
        if (row.ratio is None) != (not row.peer_value) or (row.peer is None and row.peer_value is not None):
            return f"line {number}: peer, its value and the ratio do not go together: {text}"
    return "" if rows else "no rows"


def played(scripts: list[Path], at_once: int) -> Iterator[Script]:
    """All, in the order in which they end."""
    waiting, running = list(scripts), list[Script]()
    try:
        while waiting or running:
            while waiting and len(running) < at_once:
                running.append(Script(waiting.pop(0)))
            for script in [s for s in running if s.ended()]:
                running.remove(script)
                yield script
            for script in running:
                script.tell()
            time.sleep(0.05)
    finally:
        for script in running:
            script.end()


def main() -> None:
    given = options(__doc__ or "", {"--at-once": {"type": int, "default": 2 if SHORT else 1}})
    scripts = sorted(path for path in HERE.parent.glob("*.py") if path.name != HERE.name)
    began, failed = time.monotonic(), 0
    for script in played(scripts, given.at_once):
        failed += bool(script.fault)
        message = f"{len(script.rows.splitlines())} rows" if not script.fault else f"FAILED: {script.fault}"
        print(
            f"{script.name:<20} {script.seconds:6.1f} s  {message}", file=sys.stderr if JSON else sys.stdout, flush=True
        )
    message = f"{len(scripts)} scripts in {time.monotonic() - began:.1f} s, {failed} failed"
    print(message, file=sys.stderr if JSON else sys.stdout)
    sys.exit(1 if failed else 0)


if __name__ == "__main__":
    main()
