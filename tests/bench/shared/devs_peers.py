"""The same models in other engines, for `tests/bench/devs.py`: DEVStone HI, sparse generators, a shop.

Each function prepares a run and returns what is to be timed, or None where the engine is not installed.
"""

import sys
from collections.abc import Callable, Iterator
from functools import cache
from random import Random
from typing import Any

from heavylift.nodes.devs import Tag, Tally, TimeWeighted, seconds
from heavylift.nodes.queueing import Erlang, LogNormal

from .rows import peer_module

Run = Callable[[], object]


def xdevs_stone(w: int, d: int) -> Run | None:
    """xdevs, flattened as ours is; its own DEVStone."""
    if not _xdevs():
        return None
    from xdevs.examples.devstone.devstone import DEVStone  # type: ignore[import-not-found]
    from xdevs.sim import Coordinator  # type: ignore[import-not-found]

    sys.setrecursionlimit(100_000)
    coordinator = Coordinator(DEVStone("root", "HI", w, d, 0, 0), flatten=True)
    coordinator.initialize()
    return coordinator.simulate_time  # type: ignore[no-any-return]


def pdevs_stone(w: int, d: int) -> Run | None:
    """The minimal kernel of PythonPDEVS; it has its own direct connection."""
    pdevs = _pdevs()
    if pdevs is None:
        return None

    class Stone(pdevs.AtomicDEVS):  # type: ignore[misc,name-defined]
        def __init__(self, name: str, active: bool = False) -> None:
            super().__init__(name)
            self.i, self.o, self.state = self.addInPort("i"), self.addOutPort("o"), active

        def timeAdvance(self) -> float:
            return 0.0 if self.state else float("inf")

        def outputFnc(self) -> dict[Any, Any]:
            return {self.o: [0]}

        def intTransition(self) -> bool:
            return False

        def extTransition(self, inputs: object) -> bool:
            return True

    def hi(d: int) -> Any:
        model = pdevs.CoupledDEVS(f"c{d}")
        model.i, model.o = model.addInPort("i"), model.addOutPort("o")
        inner = model.addSubModel(Stone("a") if d == 1 else hi(d - 1))
        model.connectPorts(model.i, inner.i)
        model.connectPorts(inner.o, model.o)
        before = None
        for n in range(w - 1 if d > 1 else 0):
            stone = model.addSubModel(Stone(f"a{n}"))
            model.connectPorts(model.i, stone.i)
            if before is not None:
                model.connectPorts(before.o, stone.i)
            before = stone
        return model

    root = pdevs.CoupledDEVS("r")
    seed, model = root.addSubModel(Stone("seed", True)), root.addSubModel(hi(d))
    root.connectPorts(seed.o, model.i)
    return _run(pdevs.Simulator(root), 1.0)


def pdevs_sparse(periods: list[int], span: int) -> Run | None:
    """Generators with periods of their own in the minimal kernel of PythonPDEVS."""
    pdevs = _pdevs()
    if pdevs is None:
        return None

    class Periodic(pdevs.AtomicDEVS):  # type: ignore[misc,name-defined]
        def __init__(self, name: str, period: float) -> None:
            super().__init__(name)
            self.o, self.period = self.addOutPort("o"), period

        def timeAdvance(self) -> float:
            return self.period

        def outputFnc(self) -> dict[Any, Any]:
            return {self.o: [0]}

    root = pdevs.CoupledDEVS("r")
    for n, period in enumerate(periods):
        root.addSubModel(Periodic(f"g{n}", float(period)))
    return _run(pdevs.Simulator(root), float(span))


def _run(simulator: Any, until: float) -> Run:
    simulator.setTerminationTime(until)

    def run() -> None:
        try:
            simulator.simulate()
        except IndexError:  # its empty schedule, once all are passive
            return

    return run


@cache
def _xdevs() -> Any:
    return peer_module("xdevs", "xdevs", "pip install '.[bench]'")


@cache
def _pdevs() -> Any:
    return peer_module("pypdevs.minimal", "PythonPDEVS", "a clone, as `tests/bench/devs.py` describes")


def simpy_shop(until: float) -> Run | None:
    """A G/G/3 whose first priority interrupts the second and whose units fail, with the same statistics."""
    if (simpy := _simpy()) is None:
        return None
    random, instant, waits, stays = Random(1), simpy.Environment(), Tally(), Tally()
    crew, line, busy = simpy.PreemptiveResource(instant, 3), TimeWeighted(), TimeWeighted()
    service, every = LogNormal(2.4, 1.2), Erlang(2, 1.0)

    def now() -> Tag:
        return Tag(seconds(instant.now))

    def job(priority: int) -> Iterator[object]:
        born, remaining = instant.now, -1.0
        while True:
            line.set(line.value + 1, now())
            with crew.request(priority=priority) as request:
                yield request
                line.set(line.value - 1, now())
                busy.set(busy.value + 1, now())
                if remaining < 0:
                    waits.add(instant.now - born)
                    remaining = service.draw(random)
                began = instant.now
                try:
                    yield instant.timeout(remaining)
                    stays.add(instant.now - born)
                    return
                except simpy.Interrupt:
                    remaining -= instant.now - began
                finally:
                    busy.set(busy.value - 1, now())

    def jobs() -> Iterator[object]:
        while True:
            yield instant.timeout(every.draw(random))
            instant.process(job(int(random.random() >= 0.2)))

    def failing() -> Iterator[object]:
        while True:
            yield instant.timeout(random.expovariate(1 / 200.0))
            with crew.request(priority=-1) as request:
                yield request
                yield instant.timeout(random.expovariate(1 / 10.0))

    instant.process(jobs())
    for _ in range(3):
        instant.process(failing())
    return lambda: instant.run(until)


@cache
def _simpy() -> Any:
    return peer_module("simpy", "SimPy", "pip install '.[bench]'")
