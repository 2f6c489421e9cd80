"""Memory that must not grow: long runs without events, bytes of GRANTs, runs without an end.

    python tests/bench/memory.py [--json] [--short]

Silent scenes are the bundled pendulum, which swings and says nothing, and the bundled lift with all its columns, limits
and clearances: at rest, since nobody gives an order, or swinging once it is up.  Memory is the largest resident set
that any process of a run ever had, its verdict included: the coordinator's, or in process the only one.  What a kill
takes away is the wall time between `kill -9` and the moment at which the run had reached the last row that can be
recovered.
"""

import os
import signal
import subprocess
import sys
import tempfile
import time
from contextlib import suppress
from pathlib import Path

from heavylift import run_models
from heavylift.coordinator.run import RunObserver, conversation, run
from heavylift.kernel import Stopped
from heavylift.nodes.scene import bundled, parse
from shared.processes import Told, family, lost
from shared.rows import SHORT, options, row

SWINGS, RESTS, LIFTED = "pendulum", "lift at rest", "lift"
SILENT = [(SWINGS, 36_000, 2), (SWINGS, 600, 200), (RESTS, 36_000, 2), (RESTS, 600, 200), (LIFTED, 600, 200)]  # s, Hz
SHORTLY = [(LIFTED, 10, 20)]
KILLED = [(SWINGS, 36_000, 2), (SWINGS, 600, 200), (RESTS, 600, 200)][: 1 if SHORT else None]
SPANS = (20, 40) if SHORT else (100, 300, 1000, 2000)  # [s] of the queue
ENDLESS_s = 1.0 if SHORT else 20.0  # wall time of a run without an end
BEGUN_bytes = 30_000  # of a recording
KILLS = 1 if SHORT else 3
RSS_MB, LOST_s, GROWTH = 250.0, 1.0, 1.1  # targets
QUEUE = f"{Path(__file__).with_name('shared') / 'queues.py'}:build"
CHILD = "--child"


def scene(name, end, hz):
    text = bundled()[name.split()[0]].read_text()
    if name == RESTS:
        text = f"{text[: text.index('actions:')]}actions:\n  - wait: {end} s\n"
    return parse(text.replace("wait: 60 s", f"wait: {end} s"), overrides=[f"end={end} s", f"samples={hz} Hz"])


def child(what, folder, where, *of):
    """One run in this process: `silent` or `told` SCENE END HZ, or the `queue` without an end."""
    inside = where == "in-process"
    if what == "queue":
        with suppress(Stopped):
            run_models(QUEUE, output=Path(folder) / "run.mcap", in_process=inside)
        return
    run(scene(*of), Path(folder) / "run.mcap", in_process=inside, watch=Told() if what == "told" else None)


def start(what, folder, where, *of):
    message = subprocess.PIPE if what == "told" else subprocess.DEVNULL
    command = [sys.executable, __file__, CHILD, what, folder, where, *map(str, of)]
    return subprocess.Popen(command, stdout=message, text=True)


def memory(pid, field):
    """VmRSS or VmHWM of a process [MB]; 0 of one that is gone."""
    try:
        lines = Path(f"/proc/{pid}/status").read_text().splitlines()
    except OSError:
        return 0.0
    return next((int(line.split()[1]) / 1024 for line in lines if line.startswith(field)), 0.0)


def largest(where, *of):
    """Largest resident set of any process of a silent run [MB]."""
    with tempfile.TemporaryDirectory() as folder:
        process, most = start("silent", folder, where, *of), 0.0
        while True:
            pid, status, usage = os.wait4(process.pid, os.WNOHANG)
            if pid:
                assert status == 0, status
                return max(most, usage.ru_maxrss / 1024)
            most = max(most, *(memory(each, "VmHWM") for each in family(process.pid)))
            time.sleep(0.05)


def killed(where, name, end, hz, after):
    """Wall seconds of a silent run that a kill takes away, so many seconds after the first samples."""
    with tempfile.TemporaryDirectory() as folder:
        return lost(start("told", folder, where, name, end, hz), Path(folder), after)


def granted(span):
    """Bytes of GRANTs per event of the queue over so many seconds."""
    sizes, events, encode = [], 0, conversation.m.encode

    def measured(message):
        data = encode(message)
        if isinstance(message, conversation.m.Grant):
            sizes.append(len(data))
        return data

    class Counted(RunObserver):
        def event(self, event):
            nonlocal events
            events += 1

    conversation.m.encode = measured
    try:
        run_models(QUEUE, until=span, in_process=True, watch=Counted())
    finally:
        conversation.m.encode = encode
    return sum(sizes) / events


def grown(where):
    """By how much [MB] the process that grows most does, in the second half of a run without an end."""
    with tempfile.TemporaryDirectory() as folder:
        process = start("queue", folder, where)
        part = Path(folder) / "run.mcap.part"
        while not part.exists() or part.stat().st_size < BEGUN_bytes:
            assert process.poll() is None
            time.sleep(0.05)
        time.sleep(ENDLESS_s / 2)
        before = {pid: memory(pid, "VmRSS") for pid in family(process.pid)}
        time.sleep(ENDLESS_s / 2)
        after = {pid: memory(pid, "VmRSS") for pid in before}
        assert process.poll() is None
        process.send_signal(signal.SIGINT)
        process.wait()
        return max(after[pid] - before[pid] for pid in before)


def measured():
    """Name, value, unit and target of each measurement."""
    first, *spans = [granted(span) for span in SPANS]
    yield f"bytes of GRANT per event, {SPANS[0]} s of a queue", first, "B", None
    for span, value in zip(SPANS[1:], spans, strict=True):
        yield f"bytes of GRANT per event, {span} s of a queue", value, "B", GROWTH * first
    for where in ("in-process", "processes"):
        yield f"growth of a queue without an end, {where}", grown(where), "MB", 5.0
        for name, end, hz in SHORTLY if SHORT else SILENT:
            if not SHORT or where == "in-process":
                title = f"largest process, {name}, {end} s at {hz} Hz, {where}"
                yield title, largest(where, name, end, hz), "MB", RSS_MB
        for name, end, hz in KILLED:
            worst = max(killed(where, name, 100 * end, hz, 1.1 + 0.37 * k) for k in range(KILLS))
            yield f"lost by kill -9, {name}, {hz} Hz, {where}", worst, "s", LOST_s


def main():
    options(__doc__)
    for title, value, unit, target in measured():
        row(title, value, unit, at_most=target)


if __name__ == "__main__":
    child(*sys.argv[2:]) if sys.argv[1:2] == [CHILD] else main()
