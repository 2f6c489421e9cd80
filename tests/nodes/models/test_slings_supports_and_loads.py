"""Models of lifting beam and block: hooking, hinge lock, taut and slack slings, overload, lift-off and landing."""

from math import degrees

from heavylift.nodes.models import build_one
from heavylift.nodes.models.parts import (
    Attitude,
    BrakeState,
    Done,
    Hook,
    Hooked,
    Landed,
    Lifted,
    Order,
    Overload,
    RopeState,
    SetBrake,
    StateEvent,
    Touched,
    Unhook,
    Unhooked,
    Watch,
)
from heavylift.nodes.plan import BrakeOrder, Hookup, UnhookSling as Release
from yard import Bench, turnover

RATED = Watch("loader-3.load", 2.6e6, True)
ONE, TWO, LOCK = "loader-3.sling-1", "loader-3.sling-2", "loader-3.hinge.lock"


def loader(hooked: str = "AB") -> Bench:
    return Bench(build_one(turnover(hooked=hooked), "loader-3"))


def test_a_sling_is_hooked_at_its_new_lug_and_the_hinge_is_freed() -> None:
    context = loader(hooked="A").put(
        1.0, "order", Order(ONE, 7, (0, 0), Hookup(sling=ONE, lug="B'+16", p=(16.0, 12.0, -5.6)))
    )
    context.put(2.0, "order", Order(TWO, 8, (0, 0), Hookup(sling=TWO, lug="B'+20", p=(20.0, 12.0, -5.6))))
    assert context.said() == [
        (0.0, "input", RATED),
        (1.0, "input", Hook(ONE, b=(16.0, 12.0, -5.6))),
        (1.0, "report", Hooked(ONE, "B'+16")),
        (1.0, "report", Done(ONE, 7)),
        (1.0, "input", SetBrake(LOCK, False)),
        (1.0, "report", BrakeState(LOCK, False)),
        (2.0, "input", Hook(TWO, b=(20.0, 12.0, -5.6))),
        (2.0, "report", Hooked(TWO, "B'+20")),
        (2.0, "report", Done(TWO, 8)),
    ]


def test_the_hinge_of_a_lifting_beam_is_locked_when_its_last_sling_is_unhooked() -> None:
    context = (
        loader()
        .put(1.0, "order", Order(ONE, 1, (0, 0), Release(sling=ONE)))
        .put(2.0, "order", Order(TWO, 2, (0, 0), Release(sling=TWO)))
    )
    assert context.said()[1:] == [
        (1.0, "input", Unhook(ONE)),
        (1.0, "report", Unhooked(ONE)),
        (1.0, "report", Done(ONE, 1)),
        (2.0, "input", Unhook(TWO)),
        (2.0, "report", Unhooked(TWO)),
        (2.0, "report", Done(TWO, 2)),
        (2.0, "input", SetBrake(LOCK, True)),
        (2.0, "report", BrakeState(LOCK, True)),
    ]


def test_a_repeated_order_to_lock_a_hinge_acts_once_and_is_answered_each_time() -> None:
    context = (
        loader()
        .put(1.0, "order", Order(LOCK, 4, (0, 0), BrakeOrder(model="loader-3", brake=LOCK, engaged=True)))
        .put(2.0, "order", Order(LOCK, 5, (0, 0), BrakeOrder(model="loader-3", brake=LOCK, engaged=True)))
    )
    assert context.said()[1:] == [
        (1.0, "input", SetBrake(LOCK, True)),
        (1.0, "report", BrakeState(LOCK, True)),
        (1.0, "report", Done(LOCK, 4)),
        (2.0, "report", Done(LOCK, 5)),
    ]


def test_a_lifting_beam_reports_at_once_that_a_sling_becomes_taut_or_slack() -> None:
    context = loader().put(1.5, "state", StateEvent(ONE, "taut", 0.0), StateEvent(TWO, "taut", 0.0))
    assert context.said()[1:] == [
        (1.5, "report", RopeState(ONE, "taut", 0.0)),
        (1.5, "report", RopeState(TWO, "taut", 0.0)),
    ]


def test_an_overload_of_a_sling_is_reported_when_it_begins_and_when_it_ends() -> None:
    context = loader()
    for t, tension in ((1.0, 2.6e6), (2.0, 2.5e6), (3.0, 2.6e6)):
        context.put(t, "state", StateEvent("loader-3.load", "reached", tension))
    assert context.said() == [
        (0.0, "input", RATED),
        (1.0, "input", Watch("loader-3.load", 0.97 * 2.6e6, False)),
        (1.0, "report", Overload("loader-3.load", 2.6e6, 2.6e6, True)),
        (2.0, "input", RATED),
        (2.0, "report", Overload("loader-3.load", 2.5e6, 2.6e6, False)),
        (3.0, "input", Watch("loader-3.load", 0.97 * 2.6e6, False)),
        (3.0, "report", Overload("loader-3.load", 2.6e6, 2.6e6, True)),
    ]


def test_lift_off_is_reported_when_the_last_support_opens_and_landing_when_the_last_one_closes() -> None:
    context = Bench(build_one(turnover(), "block"))
    for i in (1, 2, 3, 4):
        context.put(100.0 + i, "state", StateEvent(f"block.lower-{i}", "open", 0.0))
    for i in (1, 2, 3, 4):
        context.put(200.0 + i, "state", StateEvent(f"block.upper-{i}", "closed", 0.0))
    assert [line for line in context.said() if line[1] == "report"] == [
        (104.0, "report", Lifted("block")),
        (201.0, "report", Touched("block", "block.upper-1")),
        (204.0, "report", Landed("block", "upper")),
    ]


def test_the_block_reports_its_attitude_once_every_30_degrees() -> None:
    up, down = "block.attitude-up", "block.attitude-down"
    context = Bench(build_one(turnover(), "block")).put(1.0, "state", StateEvent(up, "reached", 0.0))
    context.put(2.0, "state", StateEvent(down, "reached", 0.0))
    text = [(t, m) for t, _, m in context.said()]
    marks = [(m.threshold, round(degrees(m.value), 9)) for _, m in text if isinstance(m, Watch)]
    assert marks == [(up, 30.0), (down, -1.0), (up, 60.0), (down, 29.0), (up, 30.0), (down, -1.0)]
    reports = [(t, round(degrees(m.angle), 9), m.rising) for t, m in text if isinstance(m, Attitude)]
    assert reports == [(1.0, 30.0, True), (2.0, 29.0, False)]
