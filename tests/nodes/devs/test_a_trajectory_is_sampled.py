"""`sampled` records the state of a hybrid model at fixed times without changing its events."""

from math import exp

import pytest
from heavylift.nodes import drive
from heavylift.nodes.devs import Hybrid, In, Message, Out, Simulator, Tag, Trajectory, ms, seconds


class Level(Message):
    level: float


class Tank(Hybrid):
    """Fills up to 4 m3, is emptied then, and in part by its input."""

    full, empty = Out(Level), In(Level)

    def start(self):
        self.go(0.0)

    def flow(self, x):
        return (0.5 - 0.1 * x[0],)

    def guards(self, x):
        return (4.0 - x[0],)

    def tell(self, which):
        self.full.send(Level(self.ahead[0]))

    def fell(self, which):
        self.go(0.0)

    def heard(self, x):
        self.go(self.state[0] - x[self.empty][-1].level)


class SampledTank(Tank):
    sampled = ms(700)


INPUTS = [(ms(2100), "empty", Level(0.5)), (ms(3333), "empty", Level(0.25))]


def level(t: float, start: float = 0.0) -> float:
    return 5.0 + (start - 5.0) * exp(-0.1 * t)


def test_samples_of_a_hybrid_model_agree_with_the_closed_form_and_change_no_event():
    plain = drive(Tank("tank"), INPUTS, until=seconds(40))
    sampled = drive(SampledTank("tank"), INPUTS, until=seconds(40))
    assert [x for x in sampled if x[1] == "full"] == plain
    assert len(plain) == 2
    samples = {tag.t: value.state[0] for tag, port, value in sampled if port == "trajectory"}
    fills = [0, *(tag.t for tag, _, _ in plain)]
    assert all(t % ms(700) == 0 for t in samples)
    assert len(samples) == 57
    assert samples[ms(1400)] == pytest.approx(level(1.4), abs=1e-9)
    after = level(3.333 - 2.1, level(2.1) - 0.5) - 0.25
    assert samples[ms(3500)] == pytest.approx(level(3.5 - 3.333, after), abs=1e-9)
    for begin, end in zip(fills[1:], [*fills[2:], seconds(40)], strict=True):
        for t in (t for t in samples if begin < t < end):
            assert samples[t] == pytest.approx(level((t - begin) * 1e-9), abs=1e-8)


def test_a_model_that_samples_its_trajectory_continues_from_a_snapshot():
    def made():
        simulator = Simulator(SampledTank("tank"))
        simulator.start()
        return simulator

    first = made()
    first.run(seconds(5))
    kept = first.snapshot()
    first.run(seconds(20))
    other = made()
    other.restore(kept)
    other.run(seconds(20))
    assert other.outputs() == first.outputs()
    assert isinstance(first.outputs()[0].value, Trajectory)
    assert first.outputs()[0].tag == Tag(ms(20300))
