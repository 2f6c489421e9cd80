"""The classic GPT model in closed form, flat and nested, and how a model is driven offline in a few lines."""

import pytest
from devs_stories import Generator, Item, Relay, coupled, run
from heavylift.kernel.errors import ModelError
from heavylift.nodes.devs import Atomic, Bag, Coupled, In, Message, Out, Tag, ns
from heavylift.nodes.testing import drive


class Processor(Atomic):
    """Works 2.5 s at one job; what comes meanwhile is lost."""

    into, done = In(Item), Out(Item)

    def start(self) -> None:
        self.job: Item | None = None

    def external(self, e: int, x: Bag) -> None:
        if self.job is None:
            self.job = x[self.into][0]
            self.hold_in(ns(2.5))

    def output(self) -> None:
        if self.job is not None:
            self.done.send(self.job)

    def internal(self) -> None:
        self.job = None
        self.passivate()


class Transducer(Atomic):
    """Counts what arrives and what is solved for 10 s, then ends the generator."""

    arrived, solved, stop = In(Item), In(Item), Out(Item)

    def start(self) -> None:
        self.arrivals, self.solutions, self.last = 0, 0, Tag(0)
        self.hold_in(ns(10))

    def external(self, e: int, x: Bag) -> None:
        self.arrivals += len(x.get(self.arrived, []))
        self.solutions += len(x.get(self.solved, []))
        self.last = self.now

    def output(self) -> None:
        self.stop.send(Item(0))

    def internal(self) -> None:
        self.passivate()


@pytest.mark.parametrize("nested", [False, True])
def test_eleven_jobs_of_which_four_are_done(nested: bool) -> None:
    g, p, t = Generator("g", ns(1), first=0), Processor("p"), Transducer("t")
    if nested:
        frame = coupled("ef", [g, t], (t.stop, g.stop), (g.out, t.arrived))
        frame.connect(g.out, frame.add_out("job", Item))
        frame.connect(frame.add_in("solved", Item), t.solved)
        model = coupled("gpt", [frame, p], (frame.ports["job"], p.into), (p.done, frame.ports["solved"]))
    else:
        model = coupled("gpt", [g, p, t])
        for source, target in [(g.out, p.into), (g.out, t.arrived), (p.done, t.solved), (t.stop, g.stop)]:
            model.connect(source, target)
    run(model, 100)
    assert (t.arrivals, t.solutions, t.last) == (11, 4, Tag(ns(11.5)))
    assert (t.solutions / t.arrivals, t.solutions / (t.last.t / 1e9)) == (4 / 11, 4 / 11.5)


def test_a_model_is_driven_in_one_line() -> None:
    jobs = [(ns(t), "into", Item(t)) for t in (1, 2, 4)]
    assert drive(Processor("p"), jobs) == [(Tag(ns(3.5)), "done", Item(1)), (Tag(ns(6.5)), "done", Item(4))]
    assert drive(Processor("p"), jobs, until=ns(6.5)) == [(Tag(ns(3.5)), "done", Item(1))]


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
            self.n += 1
            super().output()

    with pytest.raises(ModelError, match=r"^g at \(1 s, 0\): output\(\) says something else when called again; "):
        drive(Impure("g", ns(1)), until=ns(3))
