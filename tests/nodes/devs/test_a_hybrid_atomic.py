"""Hybrid atomics integrate a differential equation between located events: closed forms, to the nanosecond."""

from itertools import pairwise
from math import ceil, cos, exp, log, nan, pi, sin
from random import Random

import pytest
from heavylift.kernel import ModelError
from heavylift.nodes import drive
from heavylift.nodes.devs import Bag, Coupled, Hybrid, In, Message, Out, Simulator, State, Tag, hybrid, seconds
from heavylift.nodes.zoo import Bounce, FallingBall, G

SECOND = 10**9


class Passed(Message):
    which: tuple[int, ...]
    state: tuple[float, ...]


class Ask(Message):
    push: float = 0.0


class Observed(Hybrid):
    """Tells its events, and its state when asked; each ask pushes the first number."""

    ask, said = In(Ask), Out(Passed)

    def tell(self, which: tuple[int, ...]) -> None:
        self.said.send(Passed(which, self.ahead))

    def fell(self, which: tuple[int, ...]) -> None:
        self.go(*self.state)

    def heard(self, x: Bag) -> None:
        self.go(self.state[0] + x[self.ask][0].push, *self.state[1:])


class Pendulum(Observed):
    def start(self) -> None:
        self.go(1.0, 0.0)

    def flow(self, x: State) -> State:
        return x[1], -x[0]

    def guards(self, x: State) -> State:
        return x[0], -x[0], x[1]


def test_each_state_event_of_a_hybrid_model_occurs_once_per_period_at_its_theoretical_time() -> None:
    text = [(tag, m) for tag, _, m in drive(Pendulum("p"), until=seconds(13)) if isinstance(m, Passed)]
    falls = [(0, pi / 2), (1, 3 * pi / 2), (2, 2 * pi), (0, 5 * pi / 2), (1, 7 * pi / 2), (2, 4 * pi)]
    assert [m.which for _, m in text] == [(which,) for which, _ in falls]
    for (tag, m), (_, t) in zip(text, falls, strict=True):
        assert tag.t == pytest.approx(t * SECOND, abs=5)
        assert m.state == pytest.approx((cos(tag.t / SECOND), -sin(tag.t / SECOND)), abs=5e-9)


class Cooling(Observed):
    """Falls to 20 with the rate 1/s; hears pushes."""

    def start(self) -> None:
        self.go(100.0)

    def flow(self, x: State) -> State:
        return (20.0 - x[0],)

    def guards(self, x: State) -> State:
        return (x[0] - 30.0,)

    def result(self) -> Passed:
        return Passed((), self.present)


def test_a_state_event_is_located_to_the_nanosecond_and_moves_if_an_input_changes_the_state() -> None:
    alone = [(tag, m) for tag, _, m in drive(Cooling("c"), until=seconds(30))]
    assert [tag for tag, _ in alone] == [Tag(ceil(log(8) * SECOND))]
    pushed = drive(Cooling("c"), [(seconds(1), "ask", Ask(40.0))], seconds(30))
    start = 20 + 80 * exp(-1) + 40
    assert pushed[0][0].t == pytest.approx((1 + log((start - 20) / 10)) * SECOND, abs=2)


def test_frequent_inputs_that_change_nothing_do_not_move_a_state_event() -> None:
    asked = [(seconds(0.1 * i), "ask", Ask()) for i in range(1, 20)]
    (tag, _, _), *_ = drive(Cooling("c"), asked, seconds(30))
    assert tag.t == pytest.approx(log(8) * SECOND, abs=3)


def test_the_final_state_of_a_hybrid_model_is_returned_as_the_result_of_the_run() -> None:
    simulator = Simulator(Cooling("c"))
    simulator.start()
    simulator.run(seconds(1.5))
    (message,) = simulator.results(seconds(1.5)).values()
    assert isinstance(message, Passed)
    assert message.state == pytest.approx((20 + 80 * exp(-1.5),), rel=1e-9)


def test_a_hybrid_model_restored_from_a_snapshot_repeats_the_run_bit_for_bit() -> None:
    whole, cut = Simulator(FallingBall("ball", 3.0, 0.7)), Simulator(FallingBall("ball", 3.0, 0.7))
    for simulator in (whole, cut):
        simulator.start()
    whole.run(seconds(9))
    cut.run(seconds(2))
    other = Simulator(FallingBall("ball", 3.0, 0.7))
    other.start()
    other.restore(cut.snapshot())
    other.run(seconds(9))
    assert other.snapshot() == whole.snapshot()


@pytest.mark.parametrize(("height", "e"), [(10.0, 0.8), (2.0, 0.5), (0.3, 0.9)])
def test_a_bouncing_ball_bounces_at_the_times_of_the_closed_form_and_comes_to_rest(height: float, e: float) -> None:
    model = Coupled("room")
    ball = model.add(FallingBall("ball", height, e))
    model.connect(ball.bounce, model.add_out("bounce", Bounce))
    text = [(tag.t, m) for tag, _, m in drive(model) if isinstance(m, Bounce)]
    first, fall = (2 * height / G) ** 0.5, G * (2 * height / G) ** 0.5
    for n, (t, bounce) in enumerate(text, 1):
        assert bounce.number == n
        assert t == pytest.approx(first * (1 + 2 * (e - e**n) / (1 - e)) * SECOND, abs=2 + 10 * n)
        assert bounce.speed == pytest.approx(fall * e**n, rel=1e-4)
    assert len(text) == ceil(log(1e-3 / fall) / log(e))
    assert all(a < b for (a, _), (b, _) in pairwise(text))


@pytest.mark.parametrize("name", ["state", "at", "tell", "start"])
def test_a_port_of_a_hybrid_model_cannot_have_the_name_of_a_model_method(name: str) -> None:
    with pytest.raises(ModelError, match=rf"^m: a port cannot be named {name}: every "):
        Pendulum("m").add_in(name, Ask)


class Odd(Cooling):
    def __init__(self, name: str, flow: object, guards: object = lambda x: (x[0],), start: float = 1.0) -> None:
        super().__init__(name)
        self.flow, self.guards, self.first = flow, guards, start  # type: ignore[assignment, method-assign]

    def start(self) -> None:
        self.go(self.first)


@pytest.mark.parametrize(
    ("model", "sentence"),
    [
        (Odd("m", lambda x: (1.0, 2.0)), "flow() returned 2 rates for a state of 1"),
        (Odd("m", lambda x: (x[0] ** 2 * 1e3,)), "the flow cannot be integrated from"),
        (Odd("m", lambda x: (-1.0,), lambda x: (x[0],) * (1 + (x[0] < 0.5))), "guards() returned 1 numbers, then 2"),
        (Odd("m", lambda x: (-1.0,), lambda x: (x[0] if x[0] > 0.5 else nan,)), "guards() returned (nan,) at (0.4"),
        (Odd("m", lambda x: (-1e7 * (x[0] - 2.0),)), "the flow from (1.0,) needs more than 1000 steps for 0.0002"),
        (
            Odd("m", lambda x: (1.0,), start=float("nan")),
            "go() was called with (nan,): the state must consist of finite numbers",
        ),
    ],
)
def test_a_hybrid_model_whose_equations_cannot_be_integrated_is_reported(
    model: Odd, sentence: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(hybrid, "STEPS", 1000)
    with pytest.raises(ModelError) as message:
        drive(model, until=seconds(5))
    assert str(message.value).startswith(f"m at (0 s, 0): {sentence}")


class Relay(Observed):
    """Goes down at one speed above its lower guard and up at another below the upper one."""

    def __init__(self, down: float, up: float, width: float = 0.0, start: float = 1e-6) -> None:
        super().__init__("relay")
        self.speeds, self.width, self.x, self.rising, self.n = (-down, up), width, start, False, 0

    def start(self) -> None:
        self.go(self.x)

    def flow(self, x: State) -> State:
        return (self.speeds[self.rising],)

    def guards(self, x: State) -> State:
        return (1.0, self.width - x[0]) if self.rising else (x[0], 1.0)

    def fell(self, which: tuple[int, ...]) -> None:
        self.rising, self.n = not self.rising, self.n + 1
        self.go(*self.state)


@pytest.mark.parametrize("seed", range(6))
def test_a_sliding_mode_at_a_guard_is_reported_by_name(seed: int) -> None:
    down, up = (10.0 ** Random(f"{seed} {side}").uniform(-3, 3) for side in "du")
    model = Relay(down, up)
    with pytest.raises(
        ModelError, match=r"^relay at \(\d.*\): guards 0, 1 of guards\(\) became negative 1000 times"
    ) as message:
        drive(model, until=seconds(10))
    at = float(str(message.value).partition("(")[2].partition(" s")[0])
    slide = 1e-6 / down
    slowest = 1e-9 * max(down / up, up / down, 1.0) + 2e-9
    assert slide <= at <= slide + 2 * hybrid.CROWD * slowest, "it ends while it chatters"
    assert model.n <= 2 * hybrid.CROWD + 10


@pytest.mark.parametrize("period", [1e-6, 2e-8], ids=["1 MHz", "50 MHz"])
@pytest.mark.parametrize("duty", [0.2, 0.5, 0.8])
def test_rapid_switching_of_a_hybrid_model_is_not_mistaken_for_endless_events(period: float, duty: float) -> None:
    model = Relay(1 / duty, 1 / (1 - duty), width=period, start=period)
    n = 3 * hybrid.CROWD
    drive(model, until=seconds(n * period))
    assert model.n == pytest.approx(2 * n, rel=0.3), "each event lags by up to a nanosecond, and so does the way back"


class Shrinking(Relay):
    """Each cycle is a fifth smaller; below `rest` it stays where it is."""

    rest = 0.0

    def fell(self, which: tuple[int, ...]) -> None:
        self.width *= 0.8
        if self.width < self.rest:
            self.passivate()
        else:
            super().fell(which)


@pytest.mark.parametrize("rest", [0.0, 1e-10])
def test_ever_shorter_event_cycles_of_a_hybrid_model_are_reported_unless_the_model_comes_to_rest(rest: float) -> None:
    model = Shrinking(1.0, 1.0, width=1e-4, start=1e-4)
    model.rest = rest
    if rest:
        drive(model, until=seconds(1))
        assert model.n > 50
    else:
        with pytest.raises(ModelError, match="became negative 1000 times"):
            drive(model, until=seconds(1))
