"""Cost of a recording: share of a run's wall time, CPU time and bytes per sample, and data lost by a kill.

    python tests/bench/recording.py [--json] [--short]

`turnover` in processes of its own, with a recording and with a recorder that does nothing, turn by turn; the medians of
five pairs are compared.  The peer of the CPU time is the plain Writer of the mcap library, given the same messages at
the same chunk size.  A kill is `kill -9` into a run; what is lost lies between the last message that can be recovered
and what the run had reached at the kill.
"""

import gc
import io
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from statistics import median

import msgspec
from heavylift.coordinator.record import run_record
from heavylift.coordinator.run import run
from heavylift.nodes.scene import load
from heavylift.recordings import Digest, Recorder, Recording
from heavylift.recordings.format import McapFile
from mcap.writer import Writer
from shared.processes import Told, lost
from shared.rows import SHORT, options, row

PAIRS, KILLS, SCENE, TIMES = (1, 1, "pendulum", 1) if SHORT else (5, 5, "turnover", 3)
SHARE, SIZE_MB, SAMPLE_B, LOST_s = 10.0, 20.0, 1200.0, 1.0  # targets
CHILD = "--child"
LONG = ["end=36000 s"] if SHORT else []  # it must not end before it is killed


class Nothing:
    """A recorder that records nothing."""

    def __init__(self, path, *_, **__):
        self.path, self.digest, self.peaks, self.notes = path, Digest(), {}, []

    def __getattr__(self, name):
        return lambda *_, **__: None


def child(what, folder):
    """One run in this process: `recorded`, `bare`, or `told` at 20 Hz."""
    if what == "bare":
        run_record.Recorder = Nothing
    scene = load(SCENE, ["samples=20 Hz", *LONG] if what == "told" else [])
    began = time.perf_counter()
    run(scene, Path(folder) / "run.mcap", watch=Told() if what == "told" else None)
    print(time.perf_counter() - began)


def start(what, folder):
    short = ["--short"] if SHORT else []
    command = [sys.executable, __file__, CHILD, what, folder, *short]
    return subprocess.Popen(command, stdout=subprocess.PIPE, text=True)


def seconds(what, folder):
    process = start(what, folder)
    out, _ = process.communicate()
    assert process.returncode == 0, what
    return float(out.split()[-1])


def captured(rate, folder):
    """Layout, batches and size [bytes] of the recording of a run at this sample rate."""
    layouts, batches = [], []

    class Capturing(Recorder):
        def layout(self, layout):
            layouts.append(layout)
            super().layout(layout)

        def samples(self, payload):
            batches.append(payload)
            super().samples(payload)

    run_record.Recorder, path = Capturing, folder / f"{rate}.mcap"
    run(load(SCENE, [f"samples={rate} Hz"]), path, in_process=True)
    run_record.Recorder = Recorder
    return layouts[0], batches, path


def cpu(work):
    """Least CPU seconds of several times."""
    times = []
    for _ in range(TIMES):
        gc.collect()
        began = time.process_time()
        work()
        times.append(time.process_time() - began)
    return min(times)


def ours(layout, batches, path):
    with Recorder(path, {}) as rec:
        rec.layout(layout)
        for batch in batches:
            rec.samples(batch)


def plain(messages):
    """The mcap library's Writer with the same messages."""
    writer = Writer(io.BytesIO(), chunk_size=256 * 1024, enable_data_crcs=True)
    writer.start()
    schema = writer.register_schema("x", "", b"")
    channels = [
        writer.register_channel(str(i), "protobuf", schema) for i in range(1 + max(m.channel for m in messages))
    ]
    for m in messages:
        writer.add_message(channels[m.channel], m.log_time, m.data, m.publish_time, m.sequence)
    writer.finish()


def packed(messages):
    """CPU seconds of our writer with the same messages."""

    def work():
        file = McapFile(io.BytesIO(), "bench")
        schema = file.schema("x", "", b"")
        for i in range(1 + max(m.channel for m in messages)):
            file.channel(str(i), "protobuf", schema, {})
        for m in messages:
            file.write(m.channel + 1, m.log_time, m.publish_time, m.data)
        file.finish()

    return cpu(work)


def main():
    options(__doc__)
    with tempfile.TemporaryDirectory() as name:
        measured(Path(name))


def measured(folder):
    if not SHORT:
        seconds("recorded", folder)  # the cache is warm from here on
    pairs = [(seconds("recorded", folder), seconds("bare", folder)) for _ in range(PAIRS)]
    share = 100 * (median(a for a, _ in pairs) / median(b for _, b in pairs) - 1)
    row("wall time of a run that goes into its recording", share, "%", at_most=SHARE)
    layout, batches, path = captured(2, folder)
    row(f"recording of {SCENE} by default", path.stat().st_size / 1e6, "MB", at_most=SIZE_MB)
    n = sum(len(msgspec.msgpack.decode(batch)[1]) for batch in batches)
    whole = cpu(lambda: ours(layout, batches, folder / "ours.mcap"))
    row("CPU per sample: rounded, encoded, digested, packed", 1e6 * whole / n, "us")
    rec = Recording(folder / "ours.mcap")
    messages = list(rec.messages(*rec.topics))
    peer = 1e6 * cpu(lambda: plain(messages)) / n
    row("CPU per sample: made messages packed", 1e6 * packed(messages) / n, "us", "mcap Writer", peer)
    _, batches, path = captured(20, folder)
    n = sum(len(msgspec.msgpack.decode(batch)[1]) for batch in batches)
    row("bytes per sample at 20 Hz", path.stat().st_size / n, "B", at_most=SAMPLE_B)
    worst = 0.0
    for k in range(KILLS):
        with tempfile.TemporaryDirectory(dir=folder) as name:
            worst = max(worst, lost(start("told", name), Path(name), 1.1 + 0.37 * k))
    row(f"lost by kill -9, worst of {KILLS}", worst, "s", at_most=LOST_s)


if __name__ == "__main__":
    child(*sys.argv[2:4]) if sys.argv[1:2] == [CHILD] else main()
