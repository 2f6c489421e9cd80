"""What does not grow: memory of long runs without events, bytes of GRANTs, memory of a run without an end.

    python tests/bench/memory.py [--json] [--short]

Silent scenes are the bundled pendulum, which swings and says nothing, and the bundled lift with all its columns, limits
and clearances: at rest, since nobody gives an order, or swinging once it is up.  Memory is the largest resident set
that any process of a run ever had, its verdict included: the coordinator's, or in process the only one.  What a kill
takes away is the wall time between `kill -9` and the moment at which the run had reached the last row that can be
recovered.
"""

import json
import os
import signal
import subprocess
import sys
import tempfile
import time
from contextlib import suppress
from pathlib import Path

from heavylift.coordinator import run_models
from heavylift.coordinator.run import conversation, run
from heavylift.coordinator.run.watch import Watch
from heavylift.nodes.devs import ns
from heavylift.nodes.scene import bundled, parse
from heavylift.recordings import recover

SHORT = "--short" in sys.argv
SWINGS, RESTS, LIFTED = "pendulum", "lift at rest", "lift"
SILENT = [(SWINGS, 36_000, 2), (SWINGS, 600, 200), (RESTS, 36_000, 2), (RESTS, 600, 200), (LIFTED, 600, 200)]  # s, Hz
SHORTLY = [(SWINGS, 36_000, 2), (RESTS, 60, 200), (LIFTED, 60, 20)]
KILLED = [(SWINGS, 36_000, 2), (SWINGS, 600, 200), (RESTS, 600, 200)]
SPANS = (100, 300) if SHORT else (100, 300, 1000, 2000)  # [s] of the queue
ENDLESS_s = 4.0 if SHORT else 20.0  # wall time of a run without an end
KILLS = 1 if SHORT else 3
RSS_MB, LOST_s, GROWTH = 250.0, 1.0, 1.1  # targets
QUEUE = f"{Path(__file__).with_name('queues.py')}:build"
CHILD = "--child"


def scene(name, end, hz):
    text = bundled()[name.split()[0]].read_text()
    if name == RESTS:
        text = f"{text[: text.index('actions:')]}actions:\n  - wait: {end} s\n"
    return parse(text.replace("wait: 60 s", f"wait: {end} s"), overrides=[f"end={end} s", f"samples={hz} Hz"])


class Told(Watch):
    """Says on standard output which simulation time was reached."""

    def progress(self, t_ns):
        print(t_ns, flush=True)


def child(what, folder, where, *of):
    """One run in this process: `silent` or `told` SCENE END HZ, or the `queue` without an end."""
    inside = where == "in-process"
    if what == "queue":
        run_models(QUEUE, output=Path(folder) / "run.mcap", in_process=inside)
        return
    run(scene(*of), Path(folder) / "run.mcap", in_process=inside, watch=Told() if what == "told" else None)


def start(what, folder, where, *of):
    told = subprocess.PIPE if what == "told" else subprocess.DEVNULL
    return subprocess.Popen([sys.executable, __file__, CHILD, what, folder, where, *map(str, of)], stdout=told)


def family(pid):
    """This process and all that descend from it."""
    parents = {}
    for entry in Path("/proc").iterdir():
        if entry.name.isdigit():
            with suppress(OSError):
                parents[int(entry.name)] = int((entry / "stat").read_text().rpartition(")")[2].split()[1])
    found = [pid]
    for each in found:
        found += [p for p, parent in parents.items() if parent == each]
    return found


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


def lost(where, name, end, hz, after):
    """Wall seconds of a silent run that a kill takes away, so many seconds after the first samples."""
    with tempfile.TemporaryDirectory() as folder:
        process, reached = start("told", folder, where, name, end, hz), []
        while not reached or reached[-1][0] - reached[0][0] < after:
            if t_ns := int(process.stdout.readline()):
                reached.append((time.monotonic(), t_ns))
        os.kill(process.pid, signal.SIGKILL)
        killed = time.monotonic()
        process.wait()
        saved = round(recover(Path(folder) / "run.mcap.part", Path(folder) / "saved.mcap").sim_s * 1e9)
        return killed - max(wall for wall, t_ns in reached if t_ns <= saved)


def granted(span):
    """Bytes of GRANTs per event of the queue over so many seconds."""
    sizes, events, encode = [], 0, conversation.m.encode

    def measured(message):
        data = encode(message)
        if isinstance(message, conversation.m.Grant):
            sizes.append(len(data))
        return data

    class Counted(Watch):
        def event(self, event):
            nonlocal events
            events += 1

    conversation.m.encode = measured
    try:
        run_models(QUEUE, until=ns(span), in_process=True, watch=Counted())
    finally:
        conversation.m.encode = encode
    return sum(sizes) / events


def grown(where):
    """By how much [MB] the process that grows most does, in the second half of a run without an end."""
    with tempfile.TemporaryDirectory() as folder:
        process = start("queue", folder, where)
        time.sleep(2.0 + ENDLESS_s / 2)
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
            worst = max(lost(where, name, 100 * end, hz, 1.1 + 0.37 * k) for k in range(KILLS))
            yield f"lost by kill -9, {name}, {hz} Hz, {where}", worst, "s", LOST_s


def main():
    for title, value, unit, target in measured():
        row = {"name": title, "value": round(value, 3), "unit": unit, "peer": None, "peer_value": None, "ratio": None}
        row |= {"target": target, "met": target is None or value <= target}
        wanted = f"   target {target:.4g} {unit}" if target else ""
        print(json.dumps(row) if "--json" in sys.argv else f"{title:<64} {value:8.2f} {unit}{wanted}", flush=True)


if __name__ == "__main__":
    child(*sys.argv[2:]) if sys.argv[1:2] == [CHILD] else main()
