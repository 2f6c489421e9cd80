"""Runs the installed command `heavylift` as a user would, and waits for what it prints."""

import os
import subprocess
import sys
import time
from contextlib import suppress
from pathlib import Path

HEAVYLIFT = Path(sys.executable).parent / "heavylift"
PATIENCE_s = 60.0  # tells hanging from working, on a loaded machine too


def start(folder, *arguments):
    """The command in a folder, its output in pipes."""
    return subprocess.Popen(
        [HEAVYLIFT, *arguments], cwd=folder, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    )


def finish(folder, *arguments, **environment):
    """Exit code, standard output, standard error of the whole command."""
    done = subprocess.run(
        [HEAVYLIFT, *arguments],
        cwd=folder,
        env={**os.environ, **environment},
        capture_output=True,
        text=True,
        timeout=PATIENCE_s,
    )
    return done.returncode, done.stdout, done.stderr


def until(process, words):
    """Read standard error until a line holds the words."""
    text = []
    for line in process.stderr:
        text.append(line)
        if words in line:
            return line
    raise AssertionError(f"the command ended without saying {words!r}: {''.join(text)}")


def descendants(pid):
    """Processes below this one, as the system knows them."""
    parents = {}
    for entry in Path("/proc").iterdir():
        if entry.name.isdigit():
            try:
                stat = (entry / "stat").read_text()
            except OSError:
                continue
            parents[int(entry.name)] = int(stat.rpartition(")")[2].split()[1])
    found, todo = set(), [pid]
    while todo:
        todo = [p for p, parent in parents.items() if parent in todo]
        found.update(todo)
    return found


def all_of_node(pids, name):
    """Those of these processes that run the node of this name."""
    found = []
    for pid in pids:
        with suppress(OSError):
            if Path(f"/proc/{pid}/comm").read_text().rstrip("\n") == f"hl {name}"[:15]:
                found.append(pid)
    return found


def gone(pids):
    """Whether all these processes end."""
    deadline = time.monotonic() + PATIENCE_s
    while time.monotonic() < deadline:
        if not any(_lives(p) for p in pids):
            return True
        time.sleep(0.02)
    return False


def _lives(pid):
    try:
        os.kill(pid, 0)
        return "Z" not in Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0]
    except (ProcessLookupError, FileNotFoundError):
        return False
