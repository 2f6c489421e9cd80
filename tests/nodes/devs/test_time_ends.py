"""Time ends at 2**63 ns: longer waits are reported, and infinite waits make a model passive."""

from random import Random

import pytest
from devs_stories import Item, Relay, Sink
from heavylift.kernel import ModelError
from heavylift.nodes import drive
from heavylift.nodes.devs import FOREVER, NEVER, Atomic, Bag, In, Simulator, Tag, models, ms, ns, seconds, us
from heavylift.nodes.devs.execution import bags as schedule


class Sleeper(Atomic):
    """Sleeps for its first wait [ns], then for its second one."""

    into = In(Item)

    def __init__(self, first: int, second: int) -> None:
        super().__init__("m")
        self.first, self.second = first, second

    def start(self) -> None:
        self.hold_in(self.first)

    def internal(self) -> None:
        self.hold_in(self.second)

    def external(self, e: int, x: Bag) -> None:
        self.hold_in(self.second)


def slept(first: int, second: int) -> Tag | str:
    """When it wakes for the second time, or what it is reported."""
    simulator = Simulator(Sleeper(first, second))
    simulator.start()
    try:
        simulator.advance(simulator.next_time)
    except ModelError as error:
        return str(error)
    return simulator.next_time


@pytest.mark.parametrize(
    ("second", "told"),
    [(2**63, "2**63 or more"), (10**400, "2**1328 or more"), (NEVER - 5, str(NEVER - 5)), (NEVER - 1, str(NEVER - 1))],
)
def test_a_wait_beyond_the_last_representable_time_is_refused(
    second: int, told: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    end = "ends after the largest time, 2**63 ns or 292 years; hold for less, or call passivate() to wait for ever"
    assert slept(5, second) == f"m at (0.000000005 s, 0): hold_in({told}) [ns] {end}"
    monkeypatch.setattr(models, "NEVER", 2**9999)
    move = schedule.Schedule.move
    unasked = lambda schedule, m, t, now: move(schedule, m, t if t < NEVER else now + NEVER, now)  # noqa: E731
    monkeypatch.setattr(schedule.Schedule, "move", unasked)
    assert slept(5, second) == FOREVER, "it would never wake, without a word"


def test_waits_up_to_the_last_representable_time_and_endless_waits_are_accepted() -> None:
    r = Random(1)
    for _ in range(300):
        first = r.randrange(1, 2 ** r.randrange(1, 63))
        second = r.randrange(1, 2 ** r.randrange(1, 64))
        woken = slept(first, second)
        if first + second < NEVER:
            assert woken == Tag(first + second)
        else:
            assert isinstance(woken, str)
            assert f"hold_in({second}) [ns] ends beyond" in woken
    assert slept(5, NEVER) == FOREVER


def test_inputs_and_lookaheads_beyond_the_last_representable_time_are_refused() -> None:
    with pytest.raises(
        ModelError, match=r"^s: port o: lookahead of 2\*\*63 ns or more is longer than the largest time$"
    ):
        Sink("s").add_out("o", Item, 2**70)
    with pytest.raises(ModelError, match=r"^r: the input for into comes at 1180591620717411303424; take a time before"):
        drive(Relay("r"), [(2**70, "into", Item(1))])
    simulator = Simulator(Relay("r", first=1))
    simulator.start()
    simulator.run(2**70)
    assert simulator.next_time == FOREVER


def test_the_deprecated_function_ns_warns_that_its_argument_is_in_seconds() -> None:
    assert (seconds(1), ms(1), us(1)) == (1_000_000_000, 1_000_000, 1_000)
    with pytest.warns(
        DeprecationWarning, match=r"ns\(1\) looks like nanoseconds but takes seconds; write seconds\(1\)"
    ):
        assert ns(1) == seconds(1)
