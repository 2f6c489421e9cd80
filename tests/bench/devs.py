"""Speed of the DEVS engine: DEVStone, sparse generators, building, tracing; beside other engines if installed.

    pip install '.[bench]' && PYTHONPATH=pypdevs/src python tests/bench/devs.py [--json] [--short]

CPU time of this thread, engines in turn and the best of all rounds, so that a busy machine slows all alike. Atomics do
nothing but pass on one event, in every engine; a transition is a change of state (a confluent one counts twice).
Ours runs with its trace on where the name says so, peers run without. Peers: xdevs, flattened, and SimPy for queues
(extra `bench`), and the minimal kernel of PythonPDEVS, which no registry has: clone it (Van Tendeloo, University of
Antwerp), make it Python 3 with `2to3 -w -n src/pypdevs/minimal.py src/pypdevs/schedulers`, put its `src` on the path.
"""

import gc
import time
from collections.abc import Callable

from heavylift.nodes.devs import Atomic, Coupled, In, Message, Out, Simulator, Trace
from heavylift.nodes.queueing import Erlang, Exponential, Failures, LogNormal, Server, Sink, Source
from shared.devs_peers import Run, pdevs_sparse, pdevs_stone, simpy_shop, xdevs_stone
from shared.rows import SHORT, options, row

ROUNDS, W, MANY = (1, 10, 50) if SHORT else (7, 50, 1000)
D = W
TRANSITIONS = 2 * (1 + (D - 1) * W * (W - 1) // 2)  # of DEVStone HI, internal and external
PERIODS, SPAN = [1_000_003 + 7 * n for n in range(MANY)], 60_000_000
TICKS = sum((SPAN - 1) // period for period in PERIODS)


JOBS = 5_000 if SHORT else 20_000  # of a G/G/3 with priorities and failures, one a second


class Item(Message):
    n: int


ITEM = Item(0)


class Stone(Atomic):
    i, o = In(Item), Out(Item)

    def external(self, e: int, x: object) -> None:
        self.hold_in(0)

    def output(self) -> None:
        self.o.send(ITEM)

    def internal(self) -> None:
        self.passivate()


class Periodic(Atomic):
    o = Out(Item)

    def __init__(self, name: str, period: int) -> None:
        super().__init__(name)
        self.period = period

    def start(self) -> None:
        self.hold_in(self.period)

    def output(self) -> None:
        self.o.send(ITEM)

    def internal(self) -> None:
        self.hold_in(self.period)


class Seed(Stone):
    def start(self) -> None:
        self.hold_in(0)


def hi(w: int, d: int) -> Coupled:
    """DEVStone HI: each level holds the next one and a chain of w - 1 atomics."""
    model = Coupled(f"c{d}")
    i, o = model.add_in("i", Item), model.add_out("o", Item)
    if d == 1:
        stone = model.add(Stone("a"))
        model.connect(i, stone.i)
        model.connect(stone.o, o)
        return model
    inner = model.add(hi(w, d - 1))
    model.connect(i, inner.ports["i"])
    model.connect(inner.ports["o"], o)
    before = None
    for n in range(w - 1):
        stone = model.add(Stone(f"a{n}"))
        model.connect(i, stone.i)
        if before is not None:
            model.connect(before.o, stone.i)
        before = stone
    return model


def seeded(w: int, d: int) -> Coupled:
    root, model = Coupled("r"), hi(w, d)
    seed = root.add(Seed("seed"))
    root.add(model)
    root.connect(seed.o, model.ports["i"])
    return root


def sparse() -> Coupled:
    root = Coupled("r")
    for n, period in enumerate(PERIODS):
        root.add(Periodic(f"g{n}", period))
    return root


def shop() -> Coupled:
    """A G/G/3 whose first priority interrupts the second, and whose units fail."""
    net = Coupled("shop")
    jobs, done = net.add(Source("jobs", Erlang(2, 1.0), weights=(0.2, 0.8))), net.add(Sink("done"))
    failures = Failures(Exponential(200.0), Exponential(10.0))
    crew = net.add(Server("crew", LogNormal(2.4, 1.2), 3, "priority", preemptive=True, failures=failures))
    net.connect(jobs.out, crew.into)
    net.connect(crew.done, done.into)
    return net


def ours(simulator: Simulator, until: int, traced: bool) -> Run:
    simulator.trace = Trace() if traced else None
    simulator.start()
    return lambda: simulator.run(until)


def seconds(contenders: dict[str, Callable[[], Run | None]]) -> dict[str, float]:
    """Least CPU seconds of each, prepared anew and timed in turn; those that are not installed are left out."""
    least: dict[str, float] = {}
    for _ in range(ROUNDS):
        for name, prepare in contenders.items():
            work = prepare()
            if work is not None:
                gc.collect()
                began = time.thread_time()
                work()
                least[name] = min(least.get(name, float("inf")), time.thread_time() - began)
    return least


def main() -> None:
    options(__doc__ or "")
    stones, generators = Simulator(seeded(W, D)), Simulator(sparse())
    t = seconds(
        {
            "stones": lambda: ours(stones, 1, False),
            "traced": lambda: ours(stones, 1, True),
            "xdevs stones": lambda: xdevs_stone(W, D),
            "pdevs stones": lambda: pdevs_stone(W, D),
            "sparse": lambda: ours(generators, SPAN, False),
            "sparse traced": lambda: ours(generators, SPAN, True),
            "pdevs sparse": lambda: pdevs_sparse(PERIODS, SPAN),
            "shop": lambda: ours(Simulator(shop()), JOBS * 10**9, False),
            "simpy shop": lambda: simpy_shop(float(JOBS)),
            "build": lambda: lambda: Simulator(seeded(W, D)),
            "build 4": lambda: lambda: Simulator(seeded(2 * W, 2 * D)),
        }
    )
    pdevs, stone, many = "PythonPDEVS minimal", f"DEVStone HI {W}x{D}, traced", f"{MANY} generators, own periods"
    for name, n, mine, peer, theirs, target in (
        (stone, TRANSITIONS, "traced", "xdevs flattened", "xdevs stones", 4.5),
        (stone, TRANSITIONS, "traced", pdevs, "pdevs stones", 2.0),
        (many, TICKS, "sparse", pdevs, "pdevs sparse", 2.0),
        (f"{many}, traced", TICKS, "sparse traced", pdevs, "pdevs sparse", 1.0),
    ):
        other = n / t[theirs] / 1e6 if theirs in t else None
        row(name, n / t[mine] / 1e6, "M transitions/s", peer, other, at_least=target)
    other = JOBS / t["simpy shop"] / 1e3 if "simpy shop" in t else None
    row("G/G/3, priorities and failures", JOBS / t["shop"] / 1e3, "thousand jobs/s", "SimPy", other, at_least=0.67)
    row("overhead of the trace on DEVStone", 100 * (t["traced"] / t["stones"] - 1), "%", at_most=12.0)
    row(f"DEVStone {2 * W}x{2 * D}, built and flattened", t["build 4"], "s", at_most=0.3)
    row("building 4 times as many atomics takes", t["build 4"] / t["build"], "times as long", at_most=6.0)


if __name__ == "__main__":
    main()
