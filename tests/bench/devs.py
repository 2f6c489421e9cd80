"""How fast the DEVS engine is: DEVStone, sparse generators, building, tracing; beside other engines where installed.

    pip install '.[bench]' && python tests/bench/devs.py [--json]

CPU time of this thread, the best of several runs, engines in turn, so that a busy machine slows all alike.  Atomics do
nothing but pass on one event, in every engine; a transition is a change of state (a confluent one counts twice).
Peers: xdevs (flattened), and the minimal kernel of PythonPDEVS if it can be imported as `pypdevs.minimal`.
"""

import gc
import importlib.util
import json
import sys
import time
from collections.abc import Callable

from heavylift.nodes.devs import Atomic, Coupled, In, Message, Out, Simulator, Trace

REPEATS = 5
W = D = 50
TRANSITIONS = 2 * (1 + (D - 1) * W * (W - 1) // 2)  # of DEVStone HI, internal and external
GENERATORS, SPAN = 1000, 60_000_000


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


def best(run: Callable[[], Callable[[], object]], repeats: int = REPEATS) -> float:
    """Least CPU seconds of what `run` prepares."""
    least = float("inf")
    for _ in range(repeats):
        work = run()
        gc.collect()
        began = time.thread_time()
        work()
        least = min(least, time.thread_time() - began)
    return least


def ours(simulator: Simulator) -> Callable[[], Callable[[], object]]:
    def prepare() -> Callable[[], object]:
        simulator.start()
        return simulator.run

    return prepare


def traced(trace: Trace) -> Simulator:
    return Simulator(seeded(W, D), trace=trace)


def xdevs_hi() -> float | None:
    """Seconds of xdevs for the same DEVStone, flattened as ours is; None if it is not installed."""
    if importlib.util.find_spec("xdevs") is None:
        return None
    from xdevs.examples.devstone.devstone import DEVStone  # type: ignore[import-not-found]
    from xdevs.sim import Coordinator  # type: ignore[import-not-found]

    sys.setrecursionlimit(100_000)

    def prepare() -> Callable[[], object]:
        coordinator = Coordinator(DEVStone("root", "HI", W, D, 0, 0), flatten=True)
        coordinator.initialize()
        return coordinator.simulate_time  # type: ignore[no-any-return]

    return best(prepare, 3)


def rows() -> list[tuple[str, float, str, str | None, float | None, float | None, float, bool]]:
    """name, value, unit, peer, its value, ratio, target, met."""
    peer = xdevs_hi()
    plain = best(ours(Simulator(seeded(W, D))))

    def with_trace() -> Callable[[], object]:
        simulator.trace = Trace()
        return ours(simulator)()

    simulator = traced(Trace())
    on = best(with_trace)
    root = Coupled("r")
    for n in range(GENERATORS):
        root.add(Periodic(f"g{n}", 1_000_003 + 7 * n))
    sparse = Simulator(root)
    sparse.start()
    began = time.thread_time()
    sparse.run(SPAN)
    events = sum(SPAN // (1_000_003 + 7 * n) for n in range(GENERATORS))
    rate = events / (time.thread_time() - began) / 1e6
    small, large = (best(lambda n=n: lambda: Simulator(seeded(n, n)), 3) for n in (50, 100))  # type: ignore[misc]
    speed, theirs = TRANSITIONS / on / 1e6, TRANSITIONS / peer / 1e6 if peer else None
    unit = "M transitions/s"
    ratio = speed / theirs if theirs else None
    overhead = 100 * (on / plain - 1)
    return [
        (
            f"DEVStone HI {W}x{D}, traced",
            speed,
            unit,
            "xdevs, flattened",
            theirs,
            ratio,
            4.5,
            bool(ratio and ratio >= 4.5),
        ),
        ("trace overhead", overhead, "%", None, None, None, 12.0, overhead <= 12.0),
        (f"{GENERATORS} generators with periods of their own", rate, unit, None, None, None, 0.88, rate >= 0.88),
        ("DEVStone 100x100, built and flattened", large, "s", None, None, None, 0.3, large <= 0.3),
        (
            "building 4 times as many atomics takes",
            large / small,
            "times as long",
            None,
            None,
            None,
            6.0,
            large / small <= 6.0,
        ),
    ]


def main() -> None:
    for name, value, unit, peer, peer_value, ratio, target, met in rows():
        if "--json" in sys.argv:
            keys = ("name", "value", "unit", "peer", "peer_value", "ratio", "target", "met")
            print(json.dumps(dict(zip(keys, (name, value, unit, peer, peer_value, ratio, target, met), strict=True))))
        else:
            beside = f"   {peer} {peer_value:.3g}, ratio {ratio:.2f}" if peer_value and ratio else ""
            print(f"{name:<45} {value:8.3g} {unit:<16} target {target:g}{beside}   {'met' if met else 'MISSED'}")


if __name__ == "__main__":
    main()
