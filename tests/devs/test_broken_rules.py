"""A model that breaks a rule ends the run with one sentence: path, tag, what is wrong, what to do."""

import re
from collections.abc import Callable
from typing import Any

import pytest
from devs_stories import Generator, Item, Relay, Sink, coupled, run
from heavylift.kernel.errors import KernelError, ModelError
from heavylift.nodes.devs import Atomic, Bag, In, Message, Out, ms, ns


class Model(Atomic):
    into, out, slow = In(Item), Out(Item), Out(Item, lookahead=ms(10))

    def start(self) -> None:
        self.hold_in(ns(1))

    def internal(self) -> None:
        self.passivate()


class Wrong(Message):
    n: int


def sentence_of(**behaviour: Callable[..., Any]) -> str:
    """What the user reads when a model behaves so at 1 s."""
    broken = type("Broken", (Model,), behaviour)
    with pytest.raises(ModelError) as caught:
        run(coupled("r", [broken("m")]), 10)
    return str(caught.value)


def test_negative_time_advance() -> None:
    sentence = "r.m at (1 s, 0): negative time advance: hold_in(-1) [ns], the wait must be >= 0"
    assert sentence_of(internal=lambda self: self.hold_in(-1)) == sentence


@pytest.mark.parametrize("wait", [0.5, float("nan"), "1", None, True])
def test_a_wait_that_is_no_int(wait: object) -> None:
    said = sentence_of(internal=lambda self: self.hold_in(wait))
    assert said == f"r.m at (1 s, 0): hold_in({wait!r}): the wait must be an int in ns, use ns(seconds)"


def test_internal_that_schedules_nothing() -> None:
    said = sentence_of(internal=lambda self: None)
    assert said == "r.m at (1 s, 0): internal() scheduled nothing: call hold_in or passivate"


def test_speaking_outside_output() -> None:
    said = sentence_of(internal=lambda self: self.out.send(Item(1)))
    assert said == "r.m at (1 s, 0): port out was sent to outside output(): only output() may speak"


def test_scheduling_inside_output() -> None:
    said = sentence_of(output=lambda self: self.hold_in(1))
    assert said == "r.m at (1 s, 0): output() must not change the state: call hold_in in a transition"


def test_a_message_of_the_wrong_type() -> None:
    said = sentence_of(output=lambda self: self.out.send(Wrong(1)))
    assert said == "r.m at (1 s, 0): port out carries Item, not Wrong: Wrong(n=1)"


def test_an_exception_keeps_its_own_sentence() -> None:
    said = sentence_of(internal=lambda self: {"H1": 1}["rope"])
    assert said == "r.m at (1 s, 0): internal() raised KeyError: 'rope'"

    def slack(self: Atomic) -> None:
        raise KernelError("rope H1 is 2 mm too short")

    assert sentence_of(internal=slack) == "r.m at (1 s, 0): rope H1 is 2 mm too short"
    assert sentence_of(start=slack) == "r.m at (0 s, 0): rope H1 is 2 mm too short"


def test_a_broken_lookahead_names_the_port() -> None:
    def again(self: Model) -> None:
        self.hold_in(ms(9))

    said = sentence_of(internal=again, output=lambda self: self.slow.send(Item(1)))
    assert said == (
        "r.m at (1.009 s, 0): port slow promises a lookahead of 10000000 ns and speaks 9000000 ns after the "
        "transition that scheduled it; hold for longer or declare less"
    )


def test_an_input_that_leaves_the_schedule_standing_does_not_break_the_lookahead() -> None:
    class Standing(Model):
        def external(self, e: int, x: Bag) -> None:
            pass

        def output(self) -> None:
            self.slow.send(Item(1))

    g, m = Generator("g", ns(0.999), count=1), Standing("m")
    assert run(coupled("r", [g, m], (g.out, m.into)), 2)[-1] == (1.0, 0, "r.m", "internal")


def test_a_zero_time_loop_names_its_models() -> None:
    a, b, c = Relay("a", first=1), Relay("b"), Generator("c", ns(1), first=0)
    with pytest.raises(ModelError) as caught:
        run(coupled("r", [a, b, c], (a.out, b.into), (b.out, a.into)), 1)
    assert str(caught.value) == (
        "r.a, r.b at (0 s, 10000): zero-time loop, 10000 microsteps in which no time passes; "
        "let one of them hold for more than 0 ns"
    )


def test_an_input_to_a_model_without_external() -> None:
    g, m = Generator("g", ns(0.5)), Model("m")
    with pytest.raises(ModelError, match=re.escape("r.m at (0.5 s, 0): an input arrived, but the model defines no")):
        run(coupled("r", [g, m], (g.out, m.into)), 1)


def test_when_all_are_passive_a_run_ends() -> None:
    assert len(run(coupled("r", [Relay("a", first=1), Sink("s")]), 1e6)) == 1
