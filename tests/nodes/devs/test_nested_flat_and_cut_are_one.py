"""Random coupled models of up to 30 atomics on four levels, zero delays included: three ways to run them, one log.

The nested way is written after the book and shares no algorithm with the engine, so it is the oracle.
"""

from operator import itemgetter

import pytest
from abstract_simulator import nested
from devs_stories import Item, Relay, Sink, coupled
from heavylift.nodes.devs import Coupled, Simulator, Tag, Trace, Transition, seconds
from heavylift.nodes.devs.execution import bags, simulator
from heavylift.nodes.zoo import ring, workshop
from nested_flat_cut import three_ways
from random_models import END, build_deep, flat

MODELS = range(60)


def test_sixty_random_models_give_equal_logs_in_nested_flat_and_distributed_simulators() -> None:
    transitions = confluent = microsteps = 0
    for seed in MODELS:
        by_the_book, flattened, cut = three_ways(seed)
        assert flattened == by_the_book, seed
        assert cut == by_the_book, seed
        lines = [line for log in by_the_book.values() for line in log]
        transitions += len(lines)
        confluent += sum(line.kind == "confluent" for line in lines)
        microsteps += sum(line.tag.k > 0 for line in lines)
    assert transitions > 5_000
    assert confluent > 300
    assert microsteps > 1_000


def test_randomly_generated_devs_models_have_the_stated_size_and_depth() -> None:
    atomics = [Simulator(build_deep(seed)).atomics for seed in MODELS]
    assert 20 <= max(map(len, atomics)) <= 30
    assert max(m.path.count(".") for models in atomics for m in models) == 4


@pytest.mark.parametrize(
    "model", [lambda: ring(5, 3, seconds(0.4)), lambda: workshop(seconds(1), seconds(2.5), seconds(10))]
)
def test_the_printed_trace_of_a_devs_run_equals_the_reference_log_line_by_line(model) -> None:
    by_the_book: list[Transition] = []
    nested(model(), seconds(12), by_the_book.append)
    message: list[Transition] = []
    trace = Trace()
    for tested in (Simulator(model(), message.append), Simulator(model(), trace=trace)):
        tested.start()
        tested.run(seconds(12))
    assert message == by_the_book
    assert list(trace) == by_the_book
    assert len(trace) == len(by_the_book) > 20


def test_messages_from_outside_a_model_precede_internal_ones_in_a_bag_at_any_nesting_depth() -> None:
    """Two sources inside, one outside three levels up whose name sorts last."""

    def model() -> tuple[Coupled, Sink]:
        sink, outer = Sink("sink"), Relay("zz", first=0)
        inside: Coupled = coupled("in", [sink, a := Relay("a", first=1), b := Relay("b", first=2)])
        for source in (b, a):
            inside.connect(source.out, sink.into)
        inside.connect(inside.add_in("i", Item), sink.into)
        for name in ("mid", "top"):
            around = coupled(name, [inside])
            around.connect(around.add_in("i", Item), inside.ports["i"])
            inside = around
        return coupled("r", [inside, outer], (outer.out, inside.ports["i"])), sink

    flattened, sink = model()
    run = Simulator(flattened)
    run.start()
    run.run(1)
    assert sink.got == [(Tag(0), [0, 1, 2])]
    by_the_book, sink = model()
    nested(by_the_book, 1, lambda line: None)
    assert sink.got == [(Tag(0), [0, 1, 2])]


def test_the_comparison_of_logs_detects_a_simulator_that_does_not_sort_simultaneous_messages(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    truth = [flat(seed, END, build_deep) for seed in MODELS]
    monkeypatch.setattr(bags, "place", lambda entry: -entry[0])
    assert sum(flat(seed, END, build_deep) != truth[seed] for seed in MODELS) > 10
    monkeypatch.setattr(bags, "place", itemgetter(0))
    monkeypatch.setattr(simulator, "deliver", lambda sources, values, t: bags.deliver(sources[::-1], values[::-1], t))
    assert sum(flat(seed, END, build_deep) != truth[seed] for seed in MODELS) > 3
