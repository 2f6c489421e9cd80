"""A drive tells when a move is done, by internal events exact to the nanosecond (closed form C24)."""

import json
from pathlib import Path
from typing import Any

import pytest
from heavylift.kernel import ModelError
from heavylift.kernel.description import Point, Threshold
from heavylift.nodes.devs import seconds
from heavylift.nodes.models.parts import (
    Done,
    DriveActor,
    Limit,
    Order,
    RopeState,
    SetFollow,
    SetProfile,
    StateEvent,
    Watch,
    WinchActor,
)
from heavylift.nodes.plan import EndOrder, Follow, Motion
from yard import Bench

MIN = 1 / 60
FORMS = json.loads((Path(__file__).parents[2] / "data" / "closed_forms.json").read_text())
C24 = {  # distance [m], speed [m/s], ramp [m/s2]
    "hoist 30 m at 3 m/min, a=0.02": (30.0, 3 * MIN, 0.02),
    "trolley 40 m at 20 m/min, a=0.05": (40.0, 20 * MIN, 0.05),
    "gantry 250 m at 30 m/min, a=0.05": (250.0, 30 * MIN, 0.05),
    "turn 90 deg by hoisting 20 m at 2 m/min": (20.0, 2 * MIN, 0.02),
    "lower 30 m at 3 m/min": (30.0, 3 * MIN, 0.02),
    "inching: 0.2 m at 0.3 m/min, a=0.005": (0.2, 0.3 * MIN, 0.005),
}


def run(speed: float, accel: float = 0.05, by: float | None = None, to: float | None = None, id: int = 1) -> Order:
    return Order("x", id, (2, 0), Motion(speed=speed, accel=accel, by=by, to=to))


def end(id: int, s: float = 0.0) -> Order:
    return Order("x", id, (0, 0), EndOrder(s=s))


def follow(kc: float) -> Order:
    return Order("x", 3, (0, 0), Follow(model="", actuator="x", master="turn", law=(0.0, kc, 0.0)))


def drive(lower: float | None = None, upper: float | None = None) -> Bench:
    return Bench(DriveActor("drive", "x", start=10.0, lower=lower, upper=upper))


def about(x: float) -> Any:
    return pytest.approx(x)


@pytest.mark.parametrize("name", C24)
def test_a_move_ends_at_its_theoretical_nanosecond(name: str) -> None:
    durations = next(c for c in FORMS if c["id"] == "C24")["expected"]
    distance, speed, accel = C24[name]
    expected = durations[name]
    out = drive().put(5.0, "order", run(speed, accel, by=-distance)).said()
    assert out == [
        (5.0, "input", SetProfile("x", seconds(5.0), -speed, accel, -distance)),
        ((seconds(5.0) + seconds(expected)) / 1e9, "report", Done("x", 1, 10.0 - distance)),
    ]


def test_a_move_to_a_target_position_starts_where_the_last_move_ended() -> None:
    context = drive().put(0.0, "order", run(1.0, 1.0, by=4.0)).put(10.0, "order", run(1.0, 1.0, to=11.0, id=2))
    assert context.said()[2:] == [
        (10.0, "input", SetProfile("x", seconds(10.0), -1.0, 1.0, -3.0)),
        (14.0, "report", Done("x", 2, 11.0)),
    ]


def test_a_move_over_a_distance_of_zero_is_done_at_once() -> None:
    assert drive().put(3.0, "order", run(1.0, to=10.0)).said() == [(3.0, "report", Done("x", 1, 10.0))]


def test_a_halted_move_ramps_down_and_is_reported_done_at_its_stop_position() -> None:
    context = drive().put(0.0, "order", run(-0.5)).put(30.0, "order", end(1))
    assert context.said() == [
        (0.0, "input", SetProfile("x", 0, -0.5, 0.05)),
        (30.0, "input", SetProfile("x", seconds(30.0), 0.0, 0.05)),
        (40.0, "report", Done("x", 1, about(10.0 - 2.5 - 10.0 - 2.5))),
    ]


def test_an_order_to_halt_that_comes_after_the_end_of_a_move_has_no_effect() -> None:
    context = drive().put(0.0, "order", run(1.0, 1.0, by=4.0)).put(9.0, "order", end(1))
    assert [type(m) for _, _, m in context.said()] == [SetProfile, Done]


def test_a_new_move_takes_over_from_one_that_is_ramping_down() -> None:
    context = drive().put(0.0, "order", run(0.5)).put(20.0, "order", end(1))
    out = context.put(25.0, "order", run(0.5, by=10.0, id=2)).said()[2:]
    x = 10.0 + 2.5 + 5.0 + (0.5 * 5 - 0.025 * 25)
    assert out[0] == (25.0, "input", SetProfile("x", seconds(25.0), 0.5, 0.05, 10.0))
    assert out[1] == (25.0, "report", Done("x", 1, about(x)))
    # 0.25 -> 0.5 m/s in 5 s over 1.875 m, 10 s down over 2.5 m, the rest at 0.5 m/s
    assert out[2] == (25.0 + 5 + 10 + 5.625 / 0.5, "report", Done("x", 2, about(x + 10.0)))


def test_two_simultaneous_moves_of_one_actuator_are_refused_with_the_number_of_the_second_order() -> None:
    context = drive()
    with pytest.raises(ModelError, match=r"drive at \(1 s, 0\): order 1 of action 3: x is already moving; wait for"):
        context.put(1.0, "order", run(1.0, by=4.0), run(1.0, by=-4.0, id=2)).said()


def test_an_actor_ignores_an_order_addressed_to_another_actor() -> None:
    assert drive().put(0.0, "order", Order("y", 1, (0, 0), Motion(speed=1.0, accel=1.0, by=4.0))).said() == []


def test_a_move_without_a_stated_distance_stops_at_the_end_position() -> None:
    out = drive(lower=0.0, upper=14.0).put(0.0, "order", run(1.0, 1.0)).said()
    assert out == [
        (0.0, "input", SetProfile("x", 0, 1.0, 1.0, 4.0)),
        (5.0, "report", Limit("x", "travel limit", 14.0)),
    ]


def test_a_distance_beyond_the_end_position_is_shortened_and_reported_and_moving_back_is_possible() -> None:
    context = drive(lower=0.0, upper=14.0).put(0.0, "order", run(1.0, 1.0, by=7.0))
    context.put(10.0, "order", run(1.0, 1.0, by=-4.0, id=2))
    assert context.said()[1:] == [
        (5.0, "report", Limit("x", "travel limit", 14.0)),
        (10.0, "input", SetProfile("x", seconds(10.0), -1.0, 1.0, -4.0)),
        (15.0, "report", Done("x", 2, 10.0)),
    ]


def test_an_actuator_released_from_its_master_drive_holds_its_position() -> None:
    context = drive().put(0.0, "order", follow(-14.6)).put(620.0, "order", end(3, 3.141592653589793))
    out = context.put(630.0, "order", run(1.0, 1.0, to=40.2)).said()
    assert out[0] == (0.0, "input", SetFollow("x", "turn", (0.0, -14.6, 0.0)))
    assert out[1] == (620.0, "input", SetFollow("x"))
    assert out[2] == (630.0, "input", SetProfile("x", seconds(630.0), 1.0, 1.0, about(1.0)))


def test_an_actuator_may_receive_the_release_from_its_master_drive_and_a_new_move_in_one_bag() -> None:
    context = drive().put(0.0, "order", follow(1.0))
    out = context.put(9.0, "order", end(3), run(1.0, 1.0, by=4.0)).said()
    assert [type(m) for _, _, m in out] == [SetFollow, SetFollow, SetProfile, Done]


def test_an_actuator_that_follows_a_master_refuses_moves() -> None:
    context = drive().put(0.0, "order", follow(1.0))
    with pytest.raises(ModelError, match=r"order 1 of action 3: x follows turn; wait until that is done"):
        context.put(9.0, "order", run(1.0, by=4.0)).said()


def winch() -> Bench:
    eye = Threshold("x.highest", "height", point=Point("loader-1.upper"))
    return Bench(WinchActor("H1", "x", start=60.0, lower=10.0, upper=90.0, switch=(eye, 80.0)))


def test_a_winch_stops_when_its_drum_is_empty() -> None:
    out = winch().put(0.0, "order", run(1.0, 1.0)).said()
    assert out[1:] == [
        (0.0, "input", SetProfile("x", 0, 1.0, 1.0, 30.0)),
        (31.0, "report", Limit("x", "drum empty", 90.0)),
    ]


def test_the_upper_limit_switch_stops_hoisting_and_allows_lowering() -> None:
    context = winch().put(0.0, "order", run(0.5, by=-40.0))
    context.put(20.0, "state", StateEvent("x.highest", "reached", 80.0))
    context.put(40.0, "order", run(0.5, by=-1.0, id=2)).put(50.0, "order", run(0.5, 0.5, by=2.0, id=3))
    context.put(52.0, "state", StateEvent("x.highest", "reached", 79.9))
    assert context.said() == [
        (0.0, "input", Watch("x.highest", 80.0, True)),
        (0.0, "input", SetProfile("x", 0, -0.5, 0.05, -40.0)),
        (20.0, "input", Watch("x.highest", 79.9, False)),
        (20.0, "input", SetProfile("x", seconds(20.0), 0.0, 0.05)),
        (30.0, "report", Limit("x", "upper limit", about(60.0 - 10.0))),
        (40.0, "report", Limit("x", "upper limit", about(50.0))),
        (50.0, "input", SetProfile("x", seconds(50.0), 0.5, 0.5, 2.0)),
        (52.0, "input", Watch("x.highest", 80.0, True)),
        (55.0, "report", Done("x", 3, about(52.0))),
    ]


def test_a_winch_reports_that_its_rope_went_slack() -> None:
    out = winch().put(4.0, "state", StateEvent("x", "slack", 0.0)).said()
    assert out[1:] == [(4.0, "report", RopeState("x", "slack", 0.0))]
