"""A run stopped by time, by a condition or by a snapshot continues with the log of an uninterrupted run."""

import random

import pytest
from devs_stories import Generator, Relay, Sink, coupled
from heavylift.kernel import ModelError
from heavylift.nodes.devs import Atomic, Simulator, Transition, seconds
from heavylift.nodes.zoo import Transducer, ring, workshop


def models():
    g, r, s = Generator("g", seconds(0.3)), Relay("r", seconds(0.7)), Sink("s")
    yield coupled("line", [g, r, s], (g.out, r.into), (r.out, s.into))
    yield ring(5, 3, seconds(0.4))
    yield workshop(seconds(1), seconds(2.5), seconds(10))


def whole(model) -> list[Transition]:
    log: list[Transition] = []
    simulator = Simulator(model, log.append)
    simulator.start()
    simulator.run(seconds(12))
    return log


def test_a_simulation_run_in_several_pieces_has_the_log_of_an_undivided_run() -> None:
    for model, again in zip(models(), models(), strict=True):
        log: list[Transition] = []
        simulator = Simulator(model, log.append)
        simulator.start()
        for t in (1.1, 4.0, 4.0, 7.3, 12.0):
            simulator.run(seconds(t))
        assert log == whole(again)


def test_a_simulator_that_continues_from_a_snapshot_at_any_time_gives_the_undisturbed_log() -> None:
    rng = random.Random(1)
    for number in range(3):
        expected = whole(list(models())[number])
        for _ in range(5):
            log: list[Transition] = []
            simulator = Simulator(list(models())[number], log.append)
            simulator.start()
            simulator.run(round(rng.uniform(0, seconds(12))))
            done, snapshot = len(log), simulator.snapshot()
            simulator.run(seconds(12))
            assert log == expected
            simulator.restore(snapshot)
            del log[done:]
            simulator.run(seconds(12))
            assert log == expected


def test_a_simulator_can_be_restored_from_the_snapshot_of_another_simulator() -> None:
    first = Simulator(workshop(seconds(1), seconds(2.5), seconds(10)))
    first.start()
    first.run(seconds(5))
    other = Simulator(workshop(seconds(1), seconds(2.5), seconds(10)))
    other.restore(first.snapshot())
    other.run(seconds(100))
    (counter,) = [m for m in other.atomics if isinstance(m, Transducer)]
    assert (counter.arrivals, counter.solutions) == (11, 4)
    (untouched,) = [m for m in first.atomics if isinstance(m, Transducer)]
    assert untouched.arrivals == 5


def test_a_stop_condition_on_the_model_state_ends_a_run_after_the_present_logical_time() -> None:
    g, s = Generator("g", seconds(1)), Sink("s")
    simulator = Simulator(coupled("line", [g, s], (g.out, s.into)))
    simulator.start()
    simulator.run(stop=lambda: len(s.got) == 3)
    assert s.got[-1][0].t == seconds(3)
    simulator.run(stop=lambda: len(s.got) == 5)
    assert s.got[-1][0].t == seconds(5)


def test_the_snapshot_of_a_model_whose_state_cannot_be_saved_is_refused() -> None:
    class Secret(Atomic):
        def start(self) -> None:
            self.law = lambda x: x

    simulator = Simulator(Secret("secret"))
    simulator.start()
    with pytest.raises(
        ModelError, match=r"^secret: no snapshot can be taken \(.*\); keep only plain data and models' "
    ):
        simulator.snapshot()
