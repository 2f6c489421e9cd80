"""Violated lookahead, and errors with their own sentence; other faults: `test_every_illegality_is_named`."""

from collections.abc import Callable
from typing import Any

import pytest
from devs_stories import Generator, Item, Relay, Sink, coupled, run
from heavylift.kernel import KernelError, ModelError
from heavylift.nodes.devs import FOREVER, Atomic, Bag, In, Out, Simulator, Tag, ms, seconds


class Model(Atomic):
    into, out, slow = In(Item), Out(Item), Out(Item, lookahead=ms(10))

    def start(self) -> None:
        self.hold_in(seconds(1))

    def internal(self) -> None:
        self.passivate()


def sentence_of(**behaviour: Callable[..., Any]) -> str:
    """What the user reads when a model behaves so at 1 s."""
    broken = type("Broken", (Model,), behaviour)
    with pytest.raises(ModelError) as caught:
        run(coupled("r", [broken("m")]), 10)
    return str(caught.value)


def test_an_exception_raised_in_model_code_keeps_its_own_text() -> None:
    text = sentence_of(internal=lambda self: {"H1": 1}["rope"])
    assert text == "r.m at (1 s, 0): internal() raised KeyError: 'rope' (test_broken_rules.py:31)"

    def slack(self: Atomic) -> None:
        raise KernelError("rope H1 is 2 mm too short")

    assert sentence_of(internal=slack) == "r.m at (1 s, 0): rope H1 is 2 mm too short"
    assert sentence_of(start=slack) == "r.m at (0 s, 0): rope H1 is 2 mm too short"


def test_a_model_that_violates_its_lookahead_is_reported_with_the_port() -> None:
    def again(self: Model) -> None:
        self.hold_in(ms(9))

    text = sentence_of(internal=again, output=lambda self: self.slow.send(Item(1)))
    assert text == (
        "r.m at (1.009 s, 0): port slow promises a lookahead of 10000000 ns but sends 9000000 ns after the "
        "transition that scheduled the output; hold for longer or declare less"
    )


def test_an_input_that_does_not_change_the_next_event_of_a_model_does_not_violate_its_lookahead() -> None:
    class Standing(Model):
        def external(self, e: int, x: Bag) -> None:
            pass

        def output(self) -> None:
            self.slow.send(Item(1))

    g, m = Generator("g", seconds(0.999), count=1), Standing("m")
    assert run(coupled("r", [g, m], (g.out, m.into)), 2)[-1] == (1.0, 0, "r.m", "internal")


def test_a_devs_simulation_ends_when_all_its_models_are_passive() -> None:
    """At once, and after a step of positive length that left everybody passive."""
    assert len(run(coupled("r", [Relay("a", first=1), Sink("s")]), 1e6)) == 1
    g, a = Generator("g", seconds(1), count=1), Relay("a", seconds(2))
    simulator = Simulator(coupled("r", [g, a], (g.out, a.into)))
    simulator.start()
    simulator.run()
    assert (a.now, simulator.next_time, simulator.outputs()) == (Tag(seconds(3)), FOREVER, [])
