"""The classic GPT model in closed form, flat and nested, and how a model is driven offline in a few lines."""

import pytest
from devs_stories import Item, Relay, coupled, run
from heavylift.kernel.errors import ModelError
from heavylift.nodes.devs import Coupled, Message, Tag, ns
from heavylift.nodes.testing import drive
from heavylift.nodes.zoo.queue import Generator, Job, Processor, Transducer, workshop


@pytest.mark.parametrize("nested", [False, True])
def test_eleven_jobs_of_which_four_are_done(nested: bool) -> None:
    if nested:
        model = workshop(ns(1), ns(2.5), ns(10))
        t = model.children["frame"].children["transducer"]
    else:
        g, p, t = Generator("g", ns(1)), Processor("p", ns(2.5)), Transducer("t", ns(10))
        model = coupled("gpt", [g, p, t])
        for source, target in [(g.job, p.into), (g.job, t.arrived), (p.done, t.solved), (t.stop, g.stop)]:
            model.connect(source, target)
    run(model, 100)
    assert (t.arrivals, t.solutions, t.last) == (11, 4, Tag(ns(11.5)))
    assert (t.solutions / t.arrivals, t.solutions / (t.last.t / 1e9)) == (4 / 11, 4 / 11.5)


def test_a_model_is_driven_in_one_line() -> None:
    jobs = [(ns(t), "into", Job(t)) for t in (1, 2, 4)]
    processor = Processor("p", ns(2.5))
    assert drive(processor, jobs) == [(Tag(ns(3.5)), "done", Job(1)), (Tag(ns(6.5)), "done", Job(4))]
    assert drive(processor, jobs, until=ns(6.5)) == [(Tag(ns(3.5)), "done", Job(1))]


def test_inputs_of_one_tag_are_one_bag_and_tags_may_have_microsteps() -> None:
    inputs: list[tuple[int | Tag, str, Message]] = [(5, "into", Item(1)), (5, "into", Item(2))]
    assert drive(Relay("r", 3), inputs) == [(Tag(8), "out", Item(1)), (Tag(8), "out", Item(2))]
    assert drive(Relay("r", 0), [(Tag(5, 2), "into", Item(1))]) == [(Tag(5, 3), "out", Item(1))]


def test_a_coupled_model_is_driven_through_its_own_ports() -> None:
    first, second = Relay("first", 1), Relay("second", 2)
    model = coupled("both", [first, second], (first.out, second.into))
    model.connect(model.add_in("i", Item), first.into)
    model.connect(second.out, model.add_out("o", Item))
    assert isinstance(model, Coupled)
    assert drive(model, [(10, "i", Item(1))]) == [(Tag(13), "o", Item(1))]


def test_an_output_that_changes_its_model_is_refused() -> None:
    class Impure(Generator):
        def output(self) -> None:
            self.number += 1
            super().output()

    with pytest.raises(ModelError, match=r"^g at \(0 s, 0\): output\(\) says something else when called again; "):
        drive(Impure("g", ns(1)), until=ns(3))
