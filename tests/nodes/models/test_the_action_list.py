"""The commander executes its action list: each order is sent once, in order, on its condition."""

from math import pi
from typing import Literal

import pytest
from heavylift.kernel.description import Threshold
from heavylift.nodes.devs import seconds
from heavylift.nodes.models.parts import (
    Finished,
    Hook,
    Order,
    SetFollow,
    SetProfile,
    Stage,
    StateEvent,
    Unhook,
    Unwatch,
    Watch,
)
from heavylift.nodes.plan import (
    Action,
    AfterCondition,
    And,
    Condition,
    CrossingCondition,
    EndOrder,
    Follow,
    Hookup,
    LandedCondition,
    LiftedCondition,
    Motion,
    Move,
    MovesDone,
    SlingsCondition,
    Turn,
    UnhookSling as UnhookAction,
    Wait,
)
from yard import HOOKS, Yard, turnover

CRANES = ("west", "east")
SLINGS = tuple(f"loader-{i}.sling-{j}" for i in range(1, 7) for j in (1, 2))
COMMANDER = "commander.actions"


def hoist(hook: str, by: float | None = None, speed: float = 0.5, until: Condition | None = None) -> Move:
    """Hoist (by < 0) or lower a hook at 0.5 m/s with ramps of 0.5 m/s2."""
    verb: Literal["lower", "hoist"] = "lower" if (speed if by is None else by) > 0 else "hoist"
    return Move(verb=verb, model=hook.split(".")[0], actuator=hook, speed=speed, accel=0.5, by=by, until=until)


def travel(crane: str, by: float) -> Move:
    return Move(verb="travel", model=crane, actuator=f"{crane}.gantry.drive", speed=0.5, accel=0.05, by=by)


def taut(*names: str, state: Literal["taut", "slack"] = "taut") -> SlingsCondition:
    return SlingsCondition(names=names or SLINGS, state=state)


def events(what: str, at: float, *names: str) -> list[tuple[float, StateEvent]]:
    return [(at, StateEvent(name, what, 0.0)) for name in names]


def runs(builder: Yard) -> list[tuple[float, str]]:
    return [(t, m.actuator) for t, m in builder.inputs(SetProfile)]


def test_an_action_begins_when_the_moves_of_the_previous_one_are_done() -> None:
    hooks = [f"{crane}.{hook}" for crane in CRANES for hook in HOOKS]
    lift = Action(stage="hoist", orders=tuple(hoist(hook, -9.5) for hook in hooks))
    shift = Action(stage="travel", orders=tuple(travel(crane, 120.0) for crane in CRANES))
    builder = Yard(turnover(lift, shift), *events("open", 3.0, *(f"block.lower-{i}" for i in (1, 2, 3, 4)))).run()
    in_order = [f"{crane}.{hook}" for crane in ("east", "west") for hook in ("H3", "H1", "H2")]  # by path
    assert builder.inputs(SetProfile) == [
        *((0.0, SetProfile(hook, 0, -0.5, 0.5, -9.5)) for hook in in_order),
        *((20.0, SetProfile(f"{c}.gantry.drive", seconds(20.0), 0.5, 0.05, 120.0)) for c in ("east", "west")),
    ]
    assert builder.said(COMMANDER, Stage) == [(0.0, Stage("hoist", 0)), (20.0, Stage("travel", 1))]
    assert builder.said(COMMANDER, Finished) == [(270.0, Finished())]
    for hook in hooks:
        crane, name = hook.split(".")
        winch = f"{crane}.{'lower' if name == 'H3' else 'upper'}-body.{name}"
        assert [m.actor for m in builder.got(winch, Order)].count(hook) == 1
    assert builder.waiting_for() == ""


def test_editing_the_action_list_changes_the_run() -> None:
    first, second = Action(orders=(hoist("west.H1", -9.5),)), Action(orders=(hoist("west.H2", -9.5),))
    assert runs(Yard(turnover(first, second)).run()) == [(0.0, "west.H1"), (20.0, "west.H2")]
    assert runs(Yard(turnover(second, first)).run()) == [(0.0, "west.H2"), (20.0, "west.H1")]
    assert runs(Yard(turnover(second)).run()) == [(0.0, "west.H2")]


def test_each_hook_creeps_upward_until_its_own_slings_are_taut() -> None:
    pairs = {f"{c}.{h}": SLINGS[2 * i : 2 * i + 2] for i, (c, h) in enumerate((c, h) for c in CRANES for h in HOOKS)}
    creep = Action(orders=tuple(hoist(h, speed=-0.005, until=taut(*s)) for h, s in pairs.items()))
    load = Action(when=taut(), orders=(hoist("west.H1", -1.0),))
    script = [line for i, s in enumerate(SLINGS) for line in events("taut", 50.0 + i, s)]
    builder = Yard(turnover(creep, load), *script).run(100.0)
    halts = [(t, m.actor) for t, m in builder.said(COMMANDER, Order) if isinstance(m.what, EndOrder)]
    assert halts == [(51.0 + 2 * i, hook) for i, hook in enumerate(pairs)]
    assert [(t, m.actor) for t, m in builder.said(COMMANDER, Order) if isinstance(m.what, Motion)][6:] == [
        (61.0, "west.H1")
    ]


def test_an_action_may_begin_while_the_last_move_of_the_previous_action_ramps_down() -> None:
    creep = Action(orders=(hoist("west.H1", speed=-0.005, until=taut(SLINGS[0])),))
    load = Action(when=taut(SLINGS[0]), orders=(hoist("west.H1", -9.5),))
    builder = Yard(turnover(creep, load), *events("taut", 50.0, SLINGS[0])).run()
    winch = next(x for machine in turnover().machines for x in machine.actuators if x.name == "west.H1")
    assert builder.inputs(SetProfile) == [
        (0.0, SetProfile("west.H1", 0, -0.005, 0.5, winch.lower - winch.start)),
        (50.0, SetProfile("west.H1", seconds(50.0), 0.0, 0.5)),
        (50.0, SetProfile("west.H1", seconds(50.0), -0.5, 0.5, -9.5)),
    ]
    assert [t for t, _ in builder.said(COMMANDER, Finished)] == [pytest.approx(70.0, abs=0.02)]


def test_an_action_begins_at_once_if_its_condition_is_already_true() -> None:
    slack = taut(state="slack")
    skipped = Action(orders=(hoist("west.H1", speed=0.5, until=slack),))
    at_once = Action(when=And(all=(slack, LandedCondition())), orders=(hoist("west.H2", -9.5),))
    builder = Yard(turnover(skipped, at_once)).run()
    assert runs(builder) == [(0.0, "west.H2")]


def test_waiting_times_are_measured_from_the_previous_action() -> None:
    wait = Action(orders=(Wait(seconds=60.0), hoist("west.H1", -9.5)))
    after = Action(when=And(all=(MovesDone(), AfterCondition(seconds=100.0))), orders=(hoist("west.H2", -9.5),))
    early = Action(
        when=And(all=(MovesDone(verbs=("hoist",)), AfterCondition(seconds=5.0))), orders=(hoist("west.H3", -9.5),)
    )
    assert runs(Yard(turnover(wait, after)).run()) == [(0.0, "west.H1"), (100.0, "west.H2")]
    assert runs(Yard(turnover(wait, early)).run()) == [(0.0, "west.H1"), (20.0, "west.H3")]


def test_an_action_can_wait_for_lift_off() -> None:
    load = Action(orders=(hoist("west.H1", speed=-0.5, until=LiftedCondition()),))
    up = Action(when=LiftedCondition(), orders=(hoist("east.H1", -9.5),))
    script = [line for i in (1, 2, 3, 4) for line in events("open", 10.0 + i, f"block.lower-{i}")]
    builder = Yard(turnover(load, up), *script).run()
    assert runs(builder) == [(0.0, "west.H1"), (14.0, "east.H1"), (14.0, "west.H1")]


def test_thresholds_are_watched_only_while_an_action_waits_for_them() -> None:
    level = Threshold("block.height-1", "height", of="block")
    tilt = Threshold("block.angle-1", "angle", of="block")
    high = CrossingCondition(model="block", threshold=level, value=30.0, rising=True)
    turned = CrossingCondition(model="block", threshold=tilt, value=1.5, rising=True)
    up = Action(orders=(hoist("west.H1", by=-9.5, until=high),))
    next_ = Action(when=turned, orders=(hoist("west.H2", -9.5),))
    builder = Yard(turnover(up, next_), *events("reached", 33.0, "block.angle-1")).run()
    ours = ("block.height-1", "block.angle-1")
    mine = [(t, m) for t, _, m in builder.kernel.got if isinstance(m, Watch | Unwatch) and m.threshold in ours]
    assert mine == [
        (0.0, Watch("block.height-1", 30.0, True)),
        (0.0, Watch("block.angle-1", 1.5, True)),
        (20.0, Unwatch("block.height-1")),
    ]
    assert runs(builder)[1] == (33.0, "west.H2")


def test_a_turn_sends_its_motion_laws_once_and_releases_the_actuators_at_its_end() -> None:
    turn = Action(orders=(Turn(rate=0.01, accel=0.001, to=pi / 2),))
    slack = Action(orders=(hoist("west.H3", 0.5), hoist("east.H3", 0.5)))
    builder = Yard(turnover(turn, slack)).run()
    done = (seconds(pi / 2 / 0.01 + 10.0)) / 1e9
    assert builder.inputs(SetProfile) == [
        (0.0, SetProfile("turn", 0, 0.01, 0.001, pi / 2)),
        *((done, SetProfile(f"{c}.H3", seconds(done), 0.5, 0.5, 0.5)) for c in ("east", "west")),
    ]
    follows = builder.inputs(SetFollow)
    assert [t for t, _ in follows] == [0.0] * 10 + [done] * 10
    assert dict((m.actuator, m.law[1:]) for _, m in follows[:10])["west.H3"] == (-5.6, 12.0)
    assert [m.master for _, m in follows] == ["turn"] * 10 + [""] * 10
    assert {m.what.s for _, m in builder.said(COMMANDER, Order) if isinstance(m.what, Follow | EndOrder)} == {
        0.0,
        pi / 2,
    }


def test_after_slings_change_their_lugs_the_turn_law_uses_the_new_lugs() -> None:
    b = [(s, s.split("-")[2]) for s in SLINGS if s.startswith(("loader-3", "loader-6"))]
    unhook = Action(orders=tuple(UnhookAction(sling=s) for s, _ in b))
    side = {"loader-3": "-", "loader-6": "+"}
    us = {"1": "16", "2": "20"}
    hook = Action(orders=tuple(Hookup(sling=s, lug=f"B'{side[s[:8]]}{us[i]}") for s, i in b))
    turn = Action(orders=(Turn(rate=0.01, accel=0.001, to=pi),))
    builder = Yard(turnover(unhook, hook, turn)).run()
    assert [m.rope for _, m in builder.inputs(Unhook)] == sorted(s for s, _ in b)
    assert builder.inputs(Hook)[0] == (0.0, Hook("loader-3.sling-1", b=(-16.0, 12.0, -5.6)))
    law = {m.actuator: m.law[1:] for _, m in builder.inputs(SetFollow)[:10]}
    assert law["east.lower-slide.drive"] == (12.0, -5.6)


def test_a_run_with_a_stated_end_time_continues_after_its_action_list() -> None:
    builder = Yard(turnover(Action(orders=(hoist("west.H1", -9.5),)), end=100.0)).run()
    assert builder.said(COMMANDER, Finished) == []
