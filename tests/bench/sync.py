"""What conservative time costs: one grant, a full round, the ring workload, many nodes, one process; beside peers.

    pip install '.[bench]' && python tests/bench/sync.py [--json] [--repeats 5]

Every run is the product's own: node processes, CRC, sequence, hash and journal on, no recording.  What takes
microseconds is the median of the single cycles of a run, ours and peers' alike, for a busy machine interrupts few of
them; each figure is the best of several runs in processes of their own, peers in turn, with the median run beside.
Pinned: all processes of a run share one core.
  grant        clocks that tick in turn: at each decision one of N nodes is imminent (sync_models.turns); a raw round is
               one message of a GRANT's size over a unix socket (SOCK_SEQPACKET) and one of a DONE's back, in Python
  full round   8 clocks tick together and say 50 characters to their neighbour; in HELICS (tcp core) 8 federates publish
               50 characters to their neighbour and ask for the next time
  workload     8 stations in a ring, each with ticks of its own at random gaps; a tick or an arrival is an event, every
               third one is passed to the neighbour after the lookahead (sync_models.workload), two cores
  observers    the same with processes that watch it and stand still: its second half, when all of them do
"""

from __future__ import annotations

import argparse
import importlib.util
import json
import os
import signal
import socket
import subprocess
import sys
import threading
import time
from itertools import pairwise
from statistics import median
from typing import ClassVar

from heavylift.coordinator import run_models
from heavylift.coordinator.live import running
from heavylift.coordinator.protocol.messages import Done, Grant, encode
from heavylift.coordinator.protocol.outside import OpenCoordinator
from heavylift.coordinator.run import conversation
from heavylift.coordinator.transport.frame import Topic, Writer
from heavylift.coordinator.transport.hub import LocalHub
from heavylift.nodes.devs import Simulator, Tag
from sync_models import GAP, Station, workload

GRANTS, ROUNDS, SIZE = 4000, 1000, 50
GAPS = {1: 600, 10: 3000}  # lookahead in gaps -> length of the workload in gaps
RAW, MESSAGES = 20_000, 20_000
WATCHED = 12_000  # length of the workload that is watched, in gaps: longer than all observers need to come
WATCH = "from heavylift.coordinator.cli import main; main()"
HELICS = importlib.util.find_spec("helics") is not None
Measured = dict[str, list[float]]


# in a process of its own: one measurement, printed


class Stamped(OpenCoordinator):
    """Notes when each DONE was taken."""

    at: ClassVar[list[float]] = []

    def done(self, name: str, done: Done) -> None:
        super().done(name, done)
        self.at.append(time.perf_counter())


def cycle(at: list[float], step: int = 1) -> float:
    """Microseconds of the median cycle, each of so many stamps."""
    stamps = at[::step]
    return median(b - a for a, b in pairwise(stamps)) * 1e6


def grant(n: int, in_process: bool = False) -> float:
    """Microseconds of one grant cycle among n nodes."""
    conversation.OpenCoordinator = Stamped  # type: ignore[misc]
    run_models(f"sync_models:turns({n})", until=1000 * GRANTS, in_process=in_process)
    return cycle(Stamped.at)


def local_grant(n: int) -> float:
    """The same with all nodes in one process."""
    return grant(n, True)


def full_round(n: int) -> float:
    """Microseconds of a round in which n nodes speak and hear."""
    conversation.OpenCoordinator = Stamped  # type: ignore[misc]
    run_models(f"sync_models:rounds({n}, {SIZE})", until=1000 * ROUNDS)
    return cycle(Stamped.at, n)


def events(gaps: int) -> float:
    """Events per second of the ring workload."""
    simulator = Simulator(workload(8, gaps))
    simulator.start()
    simulator.run(GAPS[gaps] * GAP)
    count = sum(m.events for m in simulator.atomics if isinstance(m, Station))
    run = run_models(f"sync_models:workload(8, {gaps})", until=GAPS[gaps] * GAP)
    return count / run.rounds_s


def observed(n: int) -> float:
    """Grants per second in the second half of the ring workload, with n observers that have stood still by then."""
    conversation.OpenCoordinator = Stamped  # type: ignore[misc]
    frozen: list[subprocess.Popen[str]] = []

    def watch() -> None:
        while not (runs := [r for r in running() if r.notice.pid == os.getpid()]):
            time.sleep(0.01)
        command = [sys.executable, "-c", WATCH, "watch", runs[0].notice.run]
        started = [subprocess.Popen(command, stdout=subprocess.PIPE, text=True) for _ in range(n)]
        for observer in started:
            assert observer.stdout
            assert observer.stdout.readline()  # it watches
            observer.send_signal(signal.SIGSTOP)
            frozen.append(observer)

    watching = threading.Thread(target=watch)
    watching.start()
    run_models("sync_models:workload(8, 1)", until=WATCHED * GAP)
    watching.join()
    for observer in frozen:
        observer.kill()
        observer.communicate()
    assert len(frozen) == n
    half = Stamped.at[len(Stamped.at) // 2 :]
    return len(half) / (half[-1] - half[0])


def raw(_: int) -> float:
    """Microseconds of a round over a unix socket with the sizes of a GRANT and a DONE."""
    there, here = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
    tag, crc = Tag(1_000_000), bytes(16)
    ask = Writer("0" * 16, "n0", Topic.IN, 1).frame(encode(Grant(1000, tag, (0, 7), False, [])))
    answer = Writer("0" * 16, "n0", Topic.OUT, 1).frame(encode(Done(1000, tag, [], tag, [], tag, crc)))
    if os.fork() == 0:
        here.close()
        while there.recv(4096):
            there.send(answer)
        os._exit(0)
    there.close()
    at = []
    for _ in range(RAW):
        here.send(ask)
        here.recv(4096)
        at.append(time.perf_counter())
    here.close()
    os.wait()
    return cycle(at)


def empty(_: int) -> float:
    """Microseconds of an empty message between coordinator and node in one process, either way."""
    with LocalHub(["n0"]) as hub:
        link = hub.link("n0")
        link.serve(lambda data: link.send(b""))
        at = []
        for _ in range(MESSAGES // 2):
            hub.send("n0", b"")
            hub.receive()
            at.append(time.perf_counter())
    return cycle(at) / 2


def helics_round(n: int) -> float:
    """Microseconds of a round of n HELICS federates."""
    import helics as h  # type: ignore[import-untyped]

    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    near = "--local_interface=127.0.0.1 --loglevel=error"
    broker = h.helicsCreateBroker("tcp", "", f"-f {n} --localport={port} --name=b{port} {near}")
    core = f"--federates=1 --broker_address=127.0.0.1 --brokerport={port} {near}"
    command = [sys.executable, __file__, "--federate", str(n), core]
    federates = [subprocess.Popen([*command, str(i)], stdout=subprocess.PIPE, text=True) for i in range(n)]
    seconds = [float(f.communicate(timeout=60)[0].split()[-1]) for f in federates]
    h.helicsBrokerDisconnect(broker)
    h.helicsCloseLibrary()
    return seconds[0] * 1e6


def federate(n: int, core: str, i: int) -> None:
    """One of n HELICS federates in a ring."""
    import helics as h

    info = h.helicsCreateFederateInfo()
    h.helicsFederateInfoSetCoreTypeFromString(info, "tcp")
    h.helicsFederateInfoSetCoreInitString(info, core)
    h.helicsFederateInfoSetTimeProperty(info, h.HELICS_PROPERTY_TIME_PERIOD, 1.0)
    own = h.helicsCreateValueFederate(f"f{i}", info)
    out = h.helicsFederateRegisterGlobalPublication(own, f"p{i}", h.HELICS_DATA_TYPE_STRING, "")
    into = h.helicsFederateRegisterSubscription(own, f"p{(i - 1) % n}", "")
    h.helicsFederateEnterExecutingMode(own)
    heard, at = 0, []
    for k in range(1, ROUNDS + 1):
        h.helicsPublicationPublishString(out, "x" * SIZE)
        h.helicsFederateRequestTime(own, float(k))
        if h.helicsInputIsUpdated(into):
            heard += len(h.helicsInputGetString(into)) == SIZE
        at.append(time.perf_counter())
    h.helicsFederateDisconnect(own)
    assert heard >= ROUNDS - 1, heard
    print(cycle(at) / 1e6, flush=True)
    os._exit(0)


MEASURES = {f.__name__: f for f in (grant, local_grant, full_round, events, observed, raw, empty, helics_round)}


# in the process of the user: which measurements, in turn, and what they mean


def measure(what: str, n: int, cores: int) -> float:
    """One measurement in a process of its own, on the first `cores` of the cores that we may use."""
    mine = sorted(os.sched_getaffinity(0))
    command = [sys.executable, __file__, "--one", what, str(n)]
    done = subprocess.run(
        command,
        stdout=subprocess.PIPE,
        text=True,
        check=True,
        timeout=300,
        preexec_fn=lambda: os.sched_setaffinity(0, mine[-cores:]),
    )
    return float(done.stdout.split()[-1])


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--json", action="store_true")
    parser.add_argument("--repeats", type=int, default=5)
    parser.add_argument("--only", default="", help="rows whose name holds this text")
    given = parser.parse_args()
    # name, unit, what is measured (n, cores), the peer's name and measurement, what is judged, target
    rows = [
        *((f"grant, one of {n}, pinned", "us", ("grant", n, 1), "raw unix round", ("raw", 0, 1), 12.0) for n in NODES),
        ("grant, one of 8, free", "us", ("grant", 8, 2), "raw unix round", ("raw", 0, 2), None),
        *((f"grant, one of {n}, free", "us", ("grant", n, 2), None, None, None) for n in (64, 128)),
        *((f"grant, one of {n}, pinned", "us", ("grant", n, 1), None, None, None) for n in (64, 128)),
        ("full round of 8, pinned", "us", ("full_round", 8, 1), "HELICS tcp", ("helics_round", 8, 1), -2.0),
        ("full round of 8, free", "us", ("full_round", 8, 2), "HELICS tcp", ("helics_round", 8, 2), -2.0),
        ("workload, lookahead of one gap", "events/s", ("events", 1, 2), None, None, 10_000.0),
        ("workload, lookahead of ten gaps", "events/s", ("events", 10, 2), None, None, 50_000.0),
        ("workload, 8 frozen observers", "grants/s", ("observed", 8, 2), "unwatched", ("observed", 0, 2), 0.9),
        ("empty message in one process", "us", ("empty", 0, 1), None, None, 5.0),
        ("grant, one of 8, in one process", "us", ("local_grant", 8, 1), None, None, None),
    ]
    rows = [row for row in rows if given.only in row[0]]
    wanted = dict.fromkeys(m for row in rows for m in (row[2], row[4]) if m and (HELICS or m[0] != "helics_round"))
    found: dict[tuple[str, int, int], list[float]] = {m: [] for m in wanted}
    for _ in range(given.repeats):
        for m in wanted:
            found[m].append(measure(*m))
    for row in rows:
        show(row, found, given.json)


NODES = (2, 8, 16, 32)


def show(row, found, as_json: bool) -> None:  # type: ignore[no-untyped-def]
    """One row, judged: a ratio to the peer at most the target (at least, if it is negative), or the value itself."""
    name, unit, own, peer, other, target = row
    best = max if unit.endswith("/s") else min
    value, middle = best(found[own]), median(found[own])
    theirs = best(found[other]) if other in found else None
    ratio = None if theirs is None else theirs / value if target and target < 0 else value / theirs
    judged = ratio if peer else value
    met: bool | None = None
    if target is not None and judged is not None:
        met = judged >= abs(target) if target < 0 or best is max else judged <= target
    if as_json:
        keys = ("name", "value", "unit", "peer", "peer_value", "ratio", "target", "met", "median")
        told = (name, value, unit, peer, theirs, ratio, abs(target) if target else None, met, middle)
        print(json.dumps(dict(zip(keys, told, strict=True))), flush=True)
        return
    words = {True: "met", False: "MISSED", None: ""}[met]
    beside = f"{peer} {theirs:.1f}, ratio {ratio:.1f}" if theirs and ratio else ""
    goal = f"target {abs(target):g}" if target else ""
    print(f"{name:<34} {value:9.1f} {unit:<9} median {middle:9.1f}   {beside:<36} {goal:<14} {words}", flush=True)


if __name__ == "__main__":
    if sys.argv[1:2] == ["--one"]:
        print(MEASURES[sys.argv[2]](int(sys.argv[3])))
    elif sys.argv[1:2] == ["--federate"]:
        federate(int(sys.argv[2]), sys.argv[3], int(sys.argv[4]))
    else:
        main()
