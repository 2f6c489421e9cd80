"""Cost of conservative synchronisation: one grant, a full round, the ring workload, many nodes; beside peers.

    pip install '.[bench]' && python tests/bench/sync.py [--json] [--short] [--repeats 5] [--only grant]

Every run is the product's own: node processes, CRC, sequence, hash and journal on, no recording.  What takes
microseconds is the median of the single cycles of a run, ours and peers' alike, for a busy machine interrupts few of
them; each figure is the best of several runs in processes of their own, peers in turn.
Pinned: all processes of a run share one core.
  grant        clocks that tick in turn: at each decision one of N nodes is imminent (sync_models.turns); a raw round is
               one message of a GRANT's size over a unix socket (SOCK_SEQPACKET) and one of a DONE's back, in Python
  full round   8 clocks tick together and say 50 characters to their neighbour; in HELICS (tcp core) 8 federates publish
               50 characters to their neighbour and ask for the next time.  On both sides a round is a sixteenth of a
               block of 16 rounds, and a block ends when the last of all models or federates has done its last round,
               or, where several rounds are done in one GRANT, with that GRANT.  Each model in a process of its own,
               four in each of two, or all in the coordinator's.  CPU: of all processes, which others disturb less
  workload     8 stations in a ring, each with ticks of its own at random gaps; a tick or an arrival is an event, every
               third one is passed to the neighbour after the lookahead (sync_models.workload), two cores
  queue        M/M/3 with feedback over 150 s, beside one simulator that runs it alone
  observers    the same with processes that watch it and stand still: from when all of them do
"""

from __future__ import annotations

import os
import resource
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable
from contextlib import suppress
from functools import partial
from statistics import median
from typing import ClassVar

from heavylift import run_models
from heavylift.coordinator.live import running
from heavylift.coordinator.protocol import GrantDone, OpenCoordinator
from heavylift.coordinator.run import conversation
from heavylift.coordinator.transport import LocalHub
from heavylift.kernel import Stopped
from heavylift.nodes.devs import Event, Simulator
from shared.processes import Forked
from shared.rows import SHORT, options, row
from shared.sync_models import GAP, Station, queue, workload
from shared.sync_peers import BLOCK, ROUNDS, SIZE, cycle, helics_round, helics_there, raw

GRANTS, MESSAGES = (100, 200) if SHORT else (4000, 20_000)
QUEUE = 2 if SHORT else 150  # seconds
GAPS = {1: 20, 10: 40} if SHORT else {1: 600, 10: 3000}  # lookahead in gaps -> length of the workload in gaps
WATCHED = 500 if SHORT else 100_000  # DONEs that are timed once all observers stand still
NODES, MANY, RING, OBSERVERS = ((2,), (), 2, 1) if SHORT else ((2, 8, 16, 32), (64, 128), 8, 8)
WATCH = "from heavylift.coordinator.cli import main; main()"
MODELS = "shared.sync_models"


# in a process of its own: one measurement


class Stamped(OpenCoordinator):
    """Notes when each DONE was taken, and how many events had been said by then."""

    at: ClassVar[list[float]] = []
    said: ClassVar[list[int]] = []
    events: ClassVar[int] = 0

    def done(self, name: str, done: GrantDone) -> None:
        super().done(name, done)
        self.at.append(time.perf_counter())
        self.said.append(Stamped.events)

    def _hold(self, event: Event) -> None:
        super()._hold(event)
        Stamped.events += 1


class Watched(Stamped):
    """Ends the run when so many DONEs have come since all observers stand still."""

    since: ClassVar[float] = float("inf")

    def done(self, name: str, done: GrantDone) -> None:
        super().done(name, done)
        if len(self.at) == self.since + WATCHED:
            raise KeyboardInterrupt


def grant(n: int) -> float:
    """Microseconds of one grant cycle among n nodes."""
    conversation.OpenCoordinator = Stamped  # type: ignore[misc]
    run_models(f"{MODELS}:turns({n})", until=1e-6 * GRANTS)
    return cycle(Stamped.at)


def full_round(n: int, rounds: int = ROUNDS, processes: int = 0, in_process: bool = False) -> float:
    """Microseconds of a round in which n models speak and hear."""
    conversation.OpenCoordinator = Stamped  # type: ignore[misc]
    until = 1000 * rounds + 1
    run = run_models(f"{MODELS}:rounds({n}, {SIZE})", until=until / 1e9, processes=processes, in_process=in_process)
    assert Stamped.events == n * rounds, "each has spoken in each round"
    blocks, begun, before = [], Stamped.at[0], Stamped.said[0]
    for at, text in zip(Stamped.at, Stamped.said, strict=True):
        if text - before >= n * BLOCK:
            blocks.append((at - begun) / (text - before) * n * 1e6)
            begun, before = at, text
    return median(blocks or [run.rounds_s / rounds * 1e6])


def paired_round(n: int, rounds: int = ROUNDS) -> float:
    """The same of two processes with half of them each."""
    return full_round(n, rounds, processes=2)


def local_round(n: int, rounds: int = ROUNDS) -> float:
    """The same in one process."""
    return full_round(n, rounds, in_process=True)


def spent(work: Callable[[int, int], float], n: int) -> float:
    """Microseconds of CPU time that all processes of a measurement take for a round."""
    few, before, found = ROUNDS // 2, cpu(), list[float]()
    for rounds in (few, ROUNDS):
        Forked(work, n, rounds).result()
        before, now = cpu(), cpu() - before
        found.append(now)
    return (found[1] - found[0]) / (ROUNDS - few) * 1e6


def cpu() -> float:
    """Seconds that processes which have ended took, with those that they started."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def events(gaps: int, processes: int = 0) -> float:
    """Events per second of the ring workload, each station a process."""
    simulator = Simulator(workload(RING, gaps))
    simulator.start()
    simulator.run(GAPS[gaps] * GAP)
    count = sum(m.events for m in simulator.atomics if isinstance(m, Station))
    run = run_models(f"{MODELS}:workload({RING}, {gaps})", until=GAPS[gaps] * GAP / 1e9, processes=processes)
    return count / run.rounds_s


def paired_events(gaps: int) -> float:
    """The same in two processes."""
    return events(gaps, 2)


def alone(_: int) -> float:
    """Seconds of the queue in one simulator."""
    simulator = Simulator(queue())
    simulator.start()
    began = time.perf_counter()
    simulator.run(QUEUE * 10**9)
    return time.perf_counter() - began


def queued(processes: int) -> float:
    """The same in so many processes, or in this one."""
    return run_models(f"{MODELS}:queue", until=float(QUEUE), processes=processes, in_process=not processes).rounds_s


def observed(n: int) -> float:
    """DONEs per second of the ring workload once n observers stand still; it is broken off when enough are timed."""
    conversation.OpenCoordinator = Watched  # type: ignore[misc]
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
        Watched.since = len(Watched.at)

    watching = threading.Thread(target=watch)
    watching.start()
    try:
        with suppress(Stopped):
            run_models(f"{MODELS}:workload({RING}, 1)")
    finally:
        watching.join()
        for observer in frozen:
            observer.kill()
            observer.communicate()
    timed = Watched.at[Watched.since :]
    return len(timed) / (timed[-1] - timed[0])


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


HELICS = partial(spent, helics_round)
CPU = (
    (f"{RING} processes", partial(spent, full_round), 1.5),
    ("two", partial(spent, paired_round), 0.5),
    ("one", partial(spent, local_round), 0.35),
)


# in the process of the user: which measurements, in turn, and what they mean


def main() -> None:
    repeats, only = {"type": int, "default": 1 if SHORT else 5}, {"default": "", "help": "rows whose name holds this"}
    given = options(__doc__ or "", {"--repeats": repeats, "--only": only})
    # name, unit, what is measured (n, cores), the peer's name and measurement, target: at most, of a speed at least
    rows = [
        *((f"grant, one of {n}, pinned", "us", (grant, n, 1), "raw unix round", (raw, 0, 1), 12.0) for n in NODES),
        (f"grant, one of {RING}, free", "us", (grant, RING, 2), "raw unix round", (raw, 0, 2), None),
        *((f"grant, one of {n}, free", "us", (grant, n, 2), None, None, None) for n in MANY),
        *((f"grant, one of {n}, pinned", "us", (grant, n, 1), None, None, None) for n in MANY),
        (f"full round of {RING}, pinned", "us", (full_round, RING, 1), "HELICS tcp", (helics_round, RING, 1), 1.5),
        (f"full round of {RING}, free", "us", (full_round, RING, 2), "HELICS tcp", (helics_round, RING, 2), 1.0),
        (
            "full round, two processes, pinned",
            "us",
            (paired_round, RING, 1),
            "HELICS tcp",
            (helics_round, RING, 1),
            0.5,
        ),
        ("full round, two processes, free", "us", (paired_round, RING, 2), "HELICS tcp", (helics_round, RING, 2), 0.5),
        ("full round, one process", "us", (local_round, RING, 1), "HELICS tcp", (helics_round, RING, 1), 0.35),
        *(
            (f"CPU of a full round, {where}", "us", (work, RING, 1), "HELICS tcp", (HELICS, RING, 1), most)
            for where, work, most in CPU
        ),
        ("workload, lookahead of one gap", "events/s", (events, 1, 2), None, None, 10_000.0),
        ("workload, lookahead of ten gaps", "events/s", (events, 10, 2), None, None, 20_000.0),
        ("workload, ten gaps, two processes", "events/s", (paired_events, 10, 2), None, None, 50_000.0),
        ("queue, one process", "s", (queued, 0, 2), "flat simulator", (alone, 0, 2), 4.0),
        ("queue, four processes", "s", (queued, 4, 2), "flat simulator", (alone, 0, 2), 40.0),
        (
            f"workload, {OBSERVERS} frozen observers",
            "1/s",
            (observed, OBSERVERS, 2),
            "unwatched",
            (observed, 0, 2),
            0.9,
        ),
        ("empty message in one process", "us", (empty, 0, 1), None, None, 5.0),
    ]
    rows = [x for x in rows if given.only in x[0]]
    there = any(m in (helics_round, HELICS) for x in rows for m in (x[2][0], (x[4] or (None,))[0]))
    absent = () if there and Forked(helics_there).result() else (helics_round, HELICS)
    found: dict[tuple[object, int, int], list[float]] = {}
    for name, unit, own, peer, other, target in rows:
        new = [m for m in (own, other) if m and m not in found and m[0] not in absent]
        found |= {m: [] for m in new}
        for _ in range(given.repeats):
            for work, n, cores in new:
                found[work, n, cores].append(Forked(work, n, cores=cores).result())
        speed = unit.endswith("/s")
        best = max if speed else min
        theirs = best(found[other]) if other in found else None
        bound = {"at_least" if speed else "at_most": target}
        row(name, best(found[own]), unit, peer, theirs, **bound)


if __name__ == "__main__":
    main()
