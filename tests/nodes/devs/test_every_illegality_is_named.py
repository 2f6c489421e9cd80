"""Each illegal action of a model and its error sentence: path, (t, microstep), fault.

The model m holds for 1 s, hears 7 at 2 s and again at 3 s, when it is due as well. None of these runs hangs.
"""

from collections.abc import Callable
from pathlib import Path
from typing import Any, NoReturn

import pytest
from devs_stories import Generator, Item, Relay, Sink, coupled, kinds, run
from heavylift.kernel import ModelError
from heavylift.nodes.devs import Atomic, Bag, Coupled, In, Message, Out, Simulator, Tag, seconds
from heavylift.nodes.devs.execution import LONGER


class Alien(Message):
    n: int


class M(Atomic):
    """Legal: speaks at 1 s, then is passive until 2 s, due at 3 s, when it is confluent."""

    into, out = In(Item), Out(Item)

    def start(self) -> None:
        self.hold_in(seconds(1))

    def output(self) -> None:
        self.out.send(Item(1))

    def internal(self) -> None:
        self.passivate()

    def external(self, e: int, x: Bag) -> None:
        self.hold_in(seconds(1))


def yard(cls: type[M]) -> Coupled:
    g = Generator("g", seconds(1), first=seconds(2), count=2)
    m, sink = cls("m"), Sink("sink")
    return coupled("r", [g, m, sink], (g.out, m.into), (m.out, sink.into))


def sentence(**behaviour: Callable[..., Any]) -> str:
    """What the run of a model with this behaviour ends with."""
    broken = type("Broken", (M,), behaviour)
    with pytest.raises(ModelError) as caught:
        run(yard(broken), 10)
    return str(caught.value)


def place(function: Callable[..., Any]) -> str:
    """File and line of a function of one line."""
    return f"{Path(__file__).name}:{function.__code__.co_firstlineno + 1}"


def test_the_model_that_tests_make_illegal_by_single_changes_is_legal_without_them() -> None:
    assert kinds(yard(M), 10)["r.m"] == "ieci"


def raising(self: Atomic, *_: object) -> NoReturn:
    raise ZeroDivisionError("division by zero")


FIVE = [
    ("start", "r.m at (0 s, 0): start()"),
    ("output", "r.m at (1 s, 0): output()"),
    ("internal", "r.m at (1 s, 0): internal()"),
    ("external", "r.m at (2 s, 0): external()"),
    ("confluent", "r.m at (3 s, 0): confluent()"),
]


@pytest.mark.parametrize(("function", "where"), FIVE, ids=lambda x: x.split()[0])
def test_an_exception_in_any_of_the_five_model_functions_is_reported(function: str, where: str) -> None:
    assert sentence(**{function: raising}) == f"{where} raised ZeroDivisionError: division by zero ({place(raising)})"


def leaving(self: Atomic, *_: object) -> NoReturn:
    raise SystemExit("two\nlines")


@pytest.mark.parametrize(("function", "where"), FIVE, ids=lambda x: x.split()[0])
def test_a_model_that_calls_exit_cannot_end_the_program(function: str, where: str) -> None:
    assert sentence(**{function: leaving}) == f"{where} raised SystemExit: two lines ({place(leaving)})"


def endless(self: Atomic, *_: object) -> None:
    endless(self)


@pytest.mark.parametrize(("function", "where"), FIVE, ids=lambda x: x.split()[0])
def test_endless_recursion_in_a_devs_function_of_a_model_is_reported(function: str, where: str) -> None:
    assert sentence(**{function: endless}).startswith(f"{where} raised RecursionError: maximum recursion depth")


WAITS: list[tuple[Any, str]] = [
    (-1, "negative time advance: hold_in(-1) [ns]; the wait must be >= 0"),
    (-(2**70), f"negative time advance: hold_in({-(2**70)}) [ns]; the wait must be >= 0"),
    (0.5, "hold_in(0.5): the wait must be an int in ns, such as seconds(1.5)"),
    (float("nan"), "hold_in(nan): the wait must be an int in ns, such as seconds(1.5)"),
    (float("inf"), "hold_in(inf): the wait must be an int in ns, such as seconds(1.5)"),
    (None, "hold_in(None): the wait must be an int in ns, such as seconds(1.5)"),
    (True, "hold_in(True): the wait must be an int in ns, such as seconds(1.5)"),
    ("1 s", "hold_in('1 s'): the wait must be an int in ns, such as seconds(1.5)"),
]


@pytest.mark.parametrize(("wait", "wrong"), WAITS, ids=[repr(wait) for wait, _ in WAITS])
def test_an_invalid_wait_in_an_action_list_is_reported(wait: Any, wrong: str) -> None:
    assert sentence(start=lambda self: self.hold_in(wait)) == f"r.m at (0 s, 0): {wrong}"
    assert sentence(internal=lambda self: self.hold_in(wait)) == f"r.m at (1 s, 0): {wrong}"
    assert sentence(external=lambda self, e, x: self.hold_in(wait)) == f"r.m at (2 s, 0): {wrong}"
    assert sentence(confluent=lambda self, x: self.hold_in(wait)) == f"r.m at (3 s, 0): {wrong}"


OUTPUTS: list[tuple[str, Callable[[Any], object], str]] = [
    ("wait", lambda m: m.hold_in(5), "output() must not change the state: call hold_in in a transition"),
    ("passivate", lambda m: m.passivate(), "output() must not change the state: call hold_in in a transition"),
    ("type", lambda m: m.out.send(Alien(1)), "port out carries Item, not Alien: Alien(n=1)"),
    ("no message", lambda m: m.out.send(1), "port out carries Item, not int: 1"),
    (
        "list inside",
        lambda m: m.out.send(Item([1])),
        "message Item, field n: the list [1] can be changed by a receiver; "
        "use numbers, str, bytes, tuples, enums or other messages",
    ),
    ("unknown port", lambda m: m.ports["report"], "output() raised KeyError: 'report' (LINE)"),
    (
        "in port",
        lambda m: m.into.send(1),
        "output() raised AttributeError: 'InPort' object has no attribute 'send' (LINE)",
    ),
    (
        "foreign port",
        lambda m: m.parent.children["g"].out.send(Item(1)),
        "r.g.out was used by another model; output() may send only on ports of its own model",
    ),
]


@pytest.mark.parametrize(("speak", "wrong"), [entry[1:] for entry in OUTPUTS], ids=[entry[0] for entry in OUTPUTS])
def test_an_output_function_that_changes_the_state_of_its_model_is_reported(
    speak: Callable[[Any], object], wrong: str
) -> None:
    line = f"{Path(__file__).name}:{speak.__code__.co_firstlineno}"
    assert sentence(output=speak) == f"r.m at (1 s, 0): {wrong}".replace("LINE", line)


@pytest.mark.parametrize(
    "change",
    [
        lambda r: r.add(Sink("late")),
        lambda r: r.remove("g"),
        lambda r: r.disconnect(*r.couplings[0]),
    ],
    ids=["add", "remove", "disconnect"],
)
def test_the_output_function_must_not_change_the_model_structure(change: Callable[[Any], object]) -> None:
    home = yard(type("Broken", (M,), {"output": lambda m: change(m.parent)}))
    with pytest.raises(ModelError) as caught:
        run(coupled("site", [home]), 10)
    assert str(caught.value) == (
        "site.r.m at (1 s, 0): output() must not change the structure of site.r: do that in a transition"
    )


@pytest.mark.parametrize(
    ("function", "where"), [("start", "0"), ("internal", "1"), ("external", "2"), ("confluent", "3")]
)
def test_a_model_that_sends_a_message_outside_its_output_function_is_reported(function: str, where: str) -> None:
    text = sentence(**{function: lambda self, *_: self.out.send(Item(1))})
    assert text == f"r.m at ({where} s, 0): port out was used outside output(); only output() may send"


def test_a_model_that_sets_no_new_schedule_after_a_scheduled_transition_is_reported() -> None:
    nothing = "() scheduled nothing: call hold_in or passivate"
    assert sentence(internal=lambda self: None) == f"r.m at (1 s, 0): internal{nothing}"
    assert sentence(confluent=lambda self, x: None) == f"r.m at (3 s, 0): confluent{nothing}"


def test_a_model_class_that_lacks_a_required_function_is_reported() -> None:
    class Deaf(Atomic):
        into, out = In(Item), Out(Item)

        def start(self) -> None:
            self.hold_in(seconds(1))

    assert (
        sentence_of(Deaf("m"))
        == "r.m at (1 s, 0): the scheduled time came, but the model defines no internal(); define it"
    )
    Deaf.start = Atomic.start
    assert sentence_of(Deaf("m")) == "r.m at (2 s, 0): an input arrived, but the model defines no external(); define it"


def sentence_of(m: Any) -> str:
    g = Generator("g", seconds(1), first=seconds(2), count=2)
    simulator = Simulator(coupled("r", [g, m], (g.out, m.into)))
    simulator.start()
    with pytest.raises(ModelError) as caught:
        simulator.run(seconds(10))
    return str(caught.value)


def zero_time_loop(model: Coupled) -> str:
    simulator = Simulator(model)
    simulator.start()
    with pytest.raises(ModelError) as caught:
        simulator.run()
    limit = ": zero-time loop: 10000 microsteps without time passing; let one of these models "
    limit += f"hold for more than 0 ns{LONGER}"
    assert str(caught.value).endswith(limit)
    return str(caught.value).removesuffix(limit)


def test_a_model_that_always_waits_0_ns_for_its_next_event_is_reported() -> None:
    class Restless(M):
        def internal(self) -> None:
            self.hold_in(0)

    assert zero_time_loop(coupled("r", [Restless("a")])) == "r.a at (1 s, 10000)"


@pytest.mark.parametrize("members", [2, 5])
def test_a_cycle_of_models_without_delay_is_reported_with_its_members_only(members: int) -> None:
    ring = [Relay(name, first=1 if name == "a" else None) for name in "abcde"[:members]]
    couplings = [(m.out, ring[i - members + 1].into) for i, m in enumerate(ring)]
    model = coupled("r", [*ring, Generator("g", 1, first=0)], *couplings)
    assert zero_time_loop(model) == ", ".join(m.path for m in ring) + " at (0 s, 10000)"


def test_zero_delays_at_many_different_times_are_accepted_by_the_simulator() -> None:
    g, r = Generator("g", 10, count=200), Relay("r")
    simulator = Simulator(coupled("r", [g, r], (g.out, r.into)), microsteps=3)
    simulator.start()
    simulator.run()
    assert simulator.next_time.t > 2000


def test_a_model_that_runs_its_own_simulator_inside_a_transition_is_reported() -> None:
    class Hasty(M):
        def internal(self) -> None:
            simulator.run()

    simulator = Simulator(yard(Hasty))
    simulator.start()
    with pytest.raises(ModelError) as caught:
        simulator.run()
    again = "r at (1 s, 0): a transition at this time failed, or called the simulator itself; start again"
    assert str(caught.value) == f"r.m at (1 s, 0): {again}"
    for onward in (simulator.run, simulator.snapshot, simulator.outputs, lambda: simulator.advance(Tag(seconds(2)))):
        with pytest.raises(ModelError) as caught:
            onward()
        assert str(caught.value) == again
    simulator.start()
    simulator.run(seconds(1))
    assert simulator.next_time == Tag(seconds(1))


def test_running_a_devs_simulator_before_its_start_is_refused() -> None:
    with pytest.raises(ModelError, match=r"^r: the simulation has not begun; call start\(\) first$"):
        Simulator(yard(M)).run()


def test_a_model_class_whose_constructor_does_not_call_that_of_its_base_class_is_reported() -> None:
    class Forgetful(Atomic):
        def __init__(self) -> None:
            self.load = 3

    with pytest.raises(ModelError, match=r"^r: Forgetful.__init__ must call super\(\).__init__\(name\)$"):
        Coupled("r").add(Forgetful())


def test_inputs_in_the_past_and_steps_beyond_the_next_event_are_refused_by_a_simulator() -> None:
    simulator = Simulator(m := M("m"))
    simulator.start()
    simulator.advance(Tag(seconds(1)))
    simulator.inject("into", Item(1))
    for tag in (Tag(seconds(0.5)), Tag(seconds(1))):
        with pytest.raises(ModelError) as caught:
            simulator.advance(tag)
        assert str(caught.value) == f"m at (1 s, 0): late message: {tag} has already passed"
    simulator.advance(Tag(seconds(1), 1))
    assert (m.now, simulator.next_time) == (Tag(seconds(1), 1), Tag(seconds(2)))
    with pytest.raises(
        ModelError, match=r"^m: cannot advance to \(3 s, 0\): the next transition is due before, at \(2 s, 0\)$"
    ):
        simulator.advance(Tag(seconds(3)))
