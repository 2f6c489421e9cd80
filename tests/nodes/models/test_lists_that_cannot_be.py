"""Contradictory or endless action lists end in one sentence with the line of the action."""

import pytest
from heavylift.kernel import ModelError
from heavylift.nodes.models.parts import StateEvent
from heavylift.nodes.plan import (
    Action,
    And,
    BrakeOrder,
    Hookup,
    LiftedCondition,
    Move,
    MovesDone,
    Order,
    Plan,
    SlingsCondition,
    Turn,
    UnhookSling,
    Wait,
)
from test_the_action_list import SLINGS, events, hoist, taut, travel
from yard import Yard, turnover

LINE = "turnover.yaml:44:5"
DONE = "wait for `moves done` or end that order with `until`"


def at(order: Order) -> Action:
    return Action(orders=(order,))


def fails(plan: Plan, *script: tuple[float, StateEvent]) -> str:
    with pytest.raises(ModelError) as error:
        Yard(plan, *script).run()
    return str(error.value).removeprefix("yard.commander.actions at ")


def line(order: Order) -> Order:
    import msgspec

    return msgspec.structs.replace(order, where=LINE)


def test_two_orders_for_one_actuator_in_one_action_are_refused() -> None:
    both = Action(orders=(hoist("west.H1", -2.0), line(hoist("west.H1", 2.0))))
    assert fails(turnover(both)) == (
        f"(0 s, 0): {LINE}: west.H1 gets an order while its hoist (order 1 of action 1) is not done; {DONE}"
    )


def test_an_order_for_an_actuator_that_is_moving_is_refused() -> None:
    first = Action(orders=(line(hoist("west.H1", -9.5)),))
    lifted = [e for i in (1, 2, 3, 4) for e in events("open", 5.0, f"block.lower-{i}")]
    second = Action(when=LiftedCondition(), orders=(hoist("west.H1", 2.0),))
    assert f"west.H1 gets an order while its hoist ({LINE}) is not done" in fails(turnover(first, second), *lifted)


def test_an_order_for_an_actuator_that_follows_a_turn_over_is_refused() -> None:
    both = Action(orders=(Turn(rate=0.1, accel=0.1, to=1.0), line(hoist("east.H3", 2.0))))
    assert fails(turnover(both)) == (
        f"(0 s, 0): {LINE}: east.H3 gets an order while it follows the turn; wait until that is done"
    )


def test_travelling_with_a_block_on_its_supports_is_refused() -> None:
    go = Action(when=taut(SLINGS[0]), orders=(line(travel("west", 120.0)),))
    assert fails(turnover(go), *events("taut", 9.0, SLINGS[0])) == (
        f"(9 s, 1): {LINE}: west cannot travel while block stands on its supports and loader-1.sling-1 is "
        f"taut; wait until it is lifted or slacken the slings"
    )


def test_a_crane_whose_block_has_left_its_supports_may_travel() -> None:
    go = Action(when=taut(SLINGS[0]), orders=(line(travel("east", 120.0)),))
    assert Yard(turnover(go), *events("taut", 9.0, SLINGS[0])).run()


@pytest.mark.parametrize(
    ("order", "sentence"),
    [
        (hoist("west.H7", -1.0), "west has no hook or drive west.H7"),
        (
            Move(verb="travel", model="west", actuator="east.gantry.drive", speed=1.0, accel=1.0, by=1.0),
            "west has no hook or drive east.gantry.drive",
        ),
        (Hookup(sling="loader-9.sling-1", lug="A+10"), "there is no sling loader-9.sling-1"),
        (
            Hookup(sling="loader-1.sling-1", lug="A+10"),
            "sling loader-1.sling-1 is already hooked to lug A-26; unhook it first",
        ),
        (Hookup(sling="loader-3.sling-1", lug="C"), "there is no lug C"),
        (UnhookSling(sling="loader-3.sling-1"), "sling loader-3.sling-1 is not hooked and cannot be unhooked"),
        (BrakeOrder(model="loader-1", brake="lock", engaged=True), "loader-1 has no brake lock"),
    ],
)
def test_orders_to_unknown_hooks_drives_slings_lugs_and_brakes_are_refused(order: Order, sentence: str) -> None:
    assert fails(turnover(at(line(order)), hooked="A")) == f"(0 s, 0): {LINE}: {sentence}"


def test_a_wait_for_slings_that_are_not_hooked_is_refused() -> None:
    when = SlingsCondition(
        names=("loader-3.sling-1", "loader-3.sling-2"), state="taut", text="B slings taut", where=LINE
    )
    assert fails(turnover(Action(when=when, orders=()), hooked="A")) == (
        f"(0 s, 0): {LINE}: `B slings taut` refers to no sling: none of loader-3.sling-1, loader-3.sling-2 is hooked"
    )


def test_a_wait_beyond_its_timeout_ends_the_run_with_a_one_sentence_error() -> None:
    first = Action(orders=(hoist("west.H1", -9.5),))
    second = Action(when=taut(*SLINGS[:2]), where=LINE, timeout=60.0, orders=())
    assert fails(turnover(first, second), *events("taut", 30.0, SLINGS[0])) == (
        f"(60 s, 0): still waiting for all of 2 slings taut (loader-1.sling-2 is slack) since 0 s, "
        f"{LINE}: the timeout of 60 s has passed"
    )


def test_an_action_list_that_cannot_continue_reports_the_condition_that_does_not_hold() -> None:
    first = Action(orders=(hoist("west.H1", -9.5),))
    when = And(all=(MovesDone(), SlingsCondition(names=SLINGS, state="taut", text="all slings taut")), where=LINE)
    second = Action(when=MovesDone(), orders=(hoist("west.H2", -9.5),))
    script = [e for s in SLINGS if s != "loader-3.sling-2" for e in events("taut", 30.0, s)]
    builder = Yard(turnover(first, second, Action(when=when, orders=())), *script).run()
    assert builder.waiting_for() == (
        f"still waiting for all slings taut (loader-3.sling-2 is slack) since 20 s, {LINE}"
    )


def test_a_stage_that_waits_for_moves_reports_the_unfinished_wait_of_the_previous_action() -> None:
    first = Action(orders=(Wait(seconds=1200.0),), where=LINE)
    builder = Yard(turnover(first, Action(when=MovesDone(), orders=(), where=LINE))).run(60.0)
    assert builder.waiting_for() == f"still waiting for moves done (wait until 1200 s) since 0 s, {LINE}"


def test_a_move_stopped_by_an_end_position_does_not_count_as_done() -> None:
    down = Action(orders=(line(hoist("west.H1", 40.0)),), where=LINE)
    builder = Yard(turnover(down, Action(orders=(), where=LINE))).run()
    assert builder.waiting_for() == (
        f"still waiting for moves done (lower of west.H1) since 0 s; west.H1 stopped (drum empty), {LINE}"
    )
