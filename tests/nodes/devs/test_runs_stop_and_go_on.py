"""A run can be cut anywhere: by time, by a condition, by a snapshot; nothing of it shows in what happens."""

import random

import pytest
from devs_stories import Generator, Relay, Sink, coupled
from heavylift.kernel.errors import ModelError
from heavylift.nodes.devs import Atomic, Simulator, Transition, ns
from heavylift.nodes.zoo.queue import Transducer, workshop
from heavylift.nodes.zoo.token_ring import ring


def models():
    g, r, s = Generator("g", ns(0.3)), Relay("r", ns(0.7)), Sink("s")
    yield coupled("line", [g, r, s], (g.out, r.into), (r.out, s.into))
    yield ring(5, 3, ns(0.4))
    yield workshop(ns(1), ns(2.5), ns(10))


def whole(model) -> list[Transition]:
    log: list[Transition] = []
    simulator = Simulator(model, log.append)
    simulator.start()
    simulator.run(ns(12))
    return log


def test_two_halves_are_a_whole() -> None:
    for model, again in zip(models(), models(), strict=True):
        log: list[Transition] = []
        simulator = Simulator(model, log.append)
        simulator.start()
        for t in (1.1, 4.0, 4.0, 7.3, 12.0):
            simulator.run(ns(t))
        assert log == whole(again)


def test_a_snapshot_taken_anywhere_goes_on_as_if_nothing_had_happened() -> None:
    rng = random.Random(1)
    for number in range(3):
        expected = whole(list(models())[number])
        for _ in range(5):
            log: list[Transition] = []
            simulator = Simulator(list(models())[number], log.append)
            simulator.start()
            simulator.run(round(rng.uniform(0, ns(12))))
            done, snapshot = len(log), simulator.snapshot()
            simulator.run(ns(12))
            assert log == expected
            simulator.restore(snapshot)
            del log[done:]
            simulator.run(ns(12))
            assert log == expected


def test_a_snapshot_is_restored_in_another_simulator() -> None:
    first = Simulator(workshop(ns(1), ns(2.5), ns(10)))
    first.start()
    first.run(ns(5))
    other = Simulator(workshop(ns(1), ns(2.5), ns(10)))
    other.restore(first.snapshot())
    other.run(ns(100))
    (counter,) = [m for m in other.atomics if isinstance(m, Transducer)]
    assert (counter.arrivals, counter.solutions) == (11, 4)
    (untouched,) = [m for m in first.atomics if isinstance(m, Transducer)]
    assert untouched.arrivals == 5


def test_a_condition_on_the_state_ends_a_run_after_its_tag() -> None:
    g, s = Generator("g", ns(1)), Sink("s")
    simulator = Simulator(coupled("line", [g, s], (g.out, s.into)))
    simulator.start()
    simulator.run(stop=lambda: len(s.got) == 3)
    assert s.got[-1][0].t == ns(3)
    simulator.run(stop=lambda: len(s.got) == 5)
    assert s.got[-1][0].t == ns(5)


def test_a_state_that_cannot_be_kept_is_refused() -> None:
    class Secret(Atomic):
        def start(self) -> None:
            self.law = lambda x: x

    simulator = Simulator(Secret("secret"))
    simulator.start()
    with pytest.raises(
        ModelError, match=r"^secret: no snapshot can be taken \(.*\); keep only plain data and models' "
    ):
        simulator.snapshot()
