"""What a recording costs: share of a run's wall time, CPU and bytes per sample, and what a kill takes away.

    python tests/bench/recording.py [--json]

`turnover` in processes of its own, with a recording and with a recorder that does nothing, turn by turn; the medians of
five pairs are compared.  The peer of the CPU time is the plain Writer of the mcap library, given the same messages at
the same chunk size.  A kill is `kill -9` into a run; what is lost lies between the last message that can be recovered
and what the run had reached at the kill.
"""

import gc
import io
import json
import os
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from statistics import median

import msgspec
from heavylift.coordinator.record import tape
from heavylift.coordinator.run import run
from heavylift.coordinator.run.watch import Watch
from heavylift.nodes.scene import load
from heavylift.recordings import Digest, Recorder, Recording, recover
from heavylift.recordings.mcapfile import McapFile
from mcap.writer import Writer

PAIRS, KILLS = 5, 5
SHARE, SIZE_MB, SAMPLE_B, LOST_s = 10.0, 20.0, 1200.0, 1.0  # targets


class Nothing:
    """A recorder that records nothing."""

    def __init__(self, *_):
        self.digest, self.peaks = Digest(), {}

    def __getattr__(self, name):
        return lambda *_: None


class Told(Watch):
    """Says on standard output which simulation time was reached."""

    def progress(self, t_ns):
        print(t_ns, flush=True)


def child(what, folder):
    """One run in this process: `recorded`, `bare`, or `told` at 20 Hz."""
    if what == "bare":
        tape.Recorder = Nothing
    scene = load("turnover", ["samples=20 Hz"] if what == "told" else [])
    began = time.perf_counter()
    run(scene, Path(folder) / "run.mcap", watch=Told() if what == "told" else None)
    print(time.perf_counter() - began)


def start(what, folder):
    return subprocess.Popen([sys.executable, __file__, "--child", what, folder], stdout=subprocess.PIPE, text=True)


def seconds(what, folder):
    out, _ = start(what, folder).communicate()
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

    tape.Recorder, path = Capturing, folder / f"{rate}.mcap"
    run(load("turnover", [f"samples={rate} Hz"]), path)
    tape.Recorder = Recorder
    return layouts[0], batches, path


def cpu(work):
    """Least CPU seconds of three times."""
    times = []
    for _ in range(3):
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


def lost(folder, after):
    """Wall seconds of the run that a kill takes away, so many seconds after the first samples."""
    process, reached = start("told", folder), []
    assert process.stdout is not None
    while not reached or reached[-1][0] - reached[0][0] < after:
        t_ns = int(process.stdout.readline())
        reached.append((time.monotonic(), t_ns))
    os.kill(process.pid, signal.SIGKILL)
    killed = time.monotonic()
    process.wait()
    saved = round(recover(Path(folder) / "run.mcap.part", Path(folder) / "saved.mcap").sim_s * 1e9)
    return killed - max(wall for wall, t_ns in reached if t_ns <= saved)


def main():
    with tempfile.TemporaryDirectory() as name:
        for row in measured(Path(name)):
            tell(*row)


def measured(folder):
    """Name, value, unit, target, peer and its value of each measurement."""
    seconds("recorded", folder)  # the cache is warm from here on
    pairs = [(seconds("recorded", folder), seconds("bare", folder)) for _ in range(PAIRS)]
    share = 100 * (median(a for a, _ in pairs) / median(b for _, b in pairs) - 1)
    yield "wall time of a run that goes into its recording", share, "%", SHARE
    layout, batches, path = captured(2, folder)
    yield "recording of turnover by default", path.stat().st_size / 1e6, "MB", SIZE_MB
    n = sum(len(msgspec.msgpack.decode(batch)[1]) for batch in batches)
    whole = cpu(lambda: ours(layout, batches, folder / "ours.mcap"))
    yield "CPU per sample: rounded, encoded, digested, packed", 1e6 * whole / n, "us"
    rec = Recording(folder / "ours.mcap")
    messages = list(rec.messages(*rec.topics))
    peer = "mcap Writer", 1e6 * cpu(lambda: plain(messages)) / n
    yield "CPU per sample: made messages packed", 1e6 * packed(messages) / n, "us", None, *peer
    _, batches, path = captured(20, folder)
    n = sum(len(msgspec.msgpack.decode(batch)[1]) for batch in batches)
    yield "bytes per sample at 20 Hz", path.stat().st_size / n, "B", SAMPLE_B
    yield "lost by kill -9, worst of five", max(lost(folder, 1.5 + 0.37 * k) for k in range(KILLS)), "s", LOST_s


def tell(title, value, unit, target=None, peer=None, peer_value=None):
    row = {
        "name": title,
        "value": round(value, 3),
        "unit": unit,
        "peer": peer,
        "peer_value": peer_value and round(peer_value, 3),
        "ratio": peer_value and round(value / peer_value, 3),
        "target": target,
        "met": target is None or value <= target,
    }
    beside = f"   {peer} {peer_value:.1f} {unit}" if peer else ""
    wanted = f"   target {target:g} {unit}" if target else ""
    text = json.dumps(row) if "--json" in sys.argv else f"{title:<52} {value:8.2f} {unit}{wanted}{beside}"
    print(text, flush=True)


if __name__ == "__main__":
    child(*sys.argv[2:]) if "--child" in sys.argv else main()
