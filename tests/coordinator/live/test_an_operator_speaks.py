"""Commands are read like lines of the scene, given beside the action list, and refused without harm."""

import re

import msgspec
import pytest
from heavylift.kernel import SceneError
from heavylift.nodes import drive
from heavylift.nodes.devs import seconds
from heavylift.nodes.models import build_one
from heavylift.nodes.models.parts import (
    Done,
    Finished,
    Hooked,
    Lifted,
    OperatorAnswer,
    OperatorCommand,
    Order,
    Stage,
    Unhooked,
)
from heavylift.nodes.plan import BrakeOrder, EndOrder, Move, located
from heavylift.nodes.scene import load, parse, spoken
from sledge import SLEDGE

LIFT = load("lift")


def words(text: str) -> OperatorCommand:
    return OperatorCommand(text, msgspec.msgpack.encode(spoken(LIFT, text)))


def test_an_operator_command_has_the_meaning_of_the_same_words_in_a_scene() -> None:
    (hoist,) = spoken(LIFT, "crane.H1: hoist 3 m/min by 0.5 m").orders
    assert hoist == Move(verb="hoist", model="crane", actuator="crane.H1", speed=0.05, accel=0.05, by=-0.5)
    hooks = spoken(LIFT, "all hooks:  lower 3 m/min until all slings slack").orders
    assert [order.actuator for order in hooks if isinstance(order, Move)] == ["crane.H1", "crane.H2", "crane.H3"]
    (lock,) = spoken(LIFT, "loader-1: lock").orders
    assert lock == BrakeOrder(model="loader-1", brake="loader-1.hinge.lock", engaged=True)
    (push,) = spoken(parse(SLEDGE), "pusher: drive 6 m/min to 3 m").orders
    assert isinstance(push, Move)
    assert (push.actuator, push.to) == ("pusher", 3.0)


MISTAKES = [
    ("crane H1: hoit 3 m/min by 1 m", "an order begins with a verb, not 'hoit'", 10, "did you mean 'hoist'?"),
    ("crane H9: hoist 3 m/min by 1 m", "there is no 'crane H9' to give an order to", 0, "did you mean 'crane H3'?"),
    (
        "crane H1: hoist 3 kg by 1 m",
        "'3 kg' is not a valid speed: 'kg' is a unit of mass; use m/min, m/s, mm/s",
        16,
        "",
    ),
    (
        "crane H1: travel 3 m/min by 1 m",
        "'crane H1' cannot travel",
        10,
        "it can: hoist, lower, hook, unhook, lock, unlock",
    ),
    ("crane H1: hoist 3 m/min until all A slings taut", "there is no set of slings 'A'", 30, "known: "),
    ("crane H1: hoist 30 m/min by 1 m", "'crane.H1' can hoist at 10 m/min at most", 10, ""),
    ("crane H1 hoist", "name a target and its order, such as 'west H1: hoist 3 m/min by 2 m'", 14, ""),
    ("block: turn 1 deg/s to 90 deg", "a block that the scene never turns cannot be turned", 7, ""),
    ("wait: wait 3 s", "a command does something at once; to wait, give it later", 6, ""),
    (
        "crane H1: hoist 3 m/min until tension of crane.H1 >= 1 MN",
        "a command cannot wait for a measured quantity: give a distance, or a time with 'until after'",
        10,
        "",
    ),
]


@pytest.mark.parametrize(("text", "sentence", "column", "hint"), MISTAKES)
def test_a_mistake_in_an_operator_command_is_shown_with_a_caret(
    text: str, sentence: str, column: int, hint: str
) -> None:
    with pytest.raises(SceneError) as caught:
        spoken(LIFT, text)
    first, line, caret = str(caught.value).splitlines()
    assert first == f"command: {sentence}"
    assert line == f"    {text}"
    assert caret.startswith(f"{' ' * (4 + column)}^{' ' + hint if hint else ''}")


def test_an_extremely_long_operator_command_is_not_quoted_in_the_error() -> None:
    with pytest.raises(SceneError, match=r"^command: it has 1000010 characters; use at most 10000$"):
        spoken(LIFT, "crane H1: " + "9" * 1_000_000)


def commander(*given: tuple[int, OperatorCommand | Done | Lifted]):  # type: ignore[no-untyped-def]
    """What the commander of `lift` says when it hears these at these times [ns], as (seconds, message)."""
    heard = [(t, "command" if isinstance(what, OperatorCommand) else "report", what) for t, what in given]
    text = drive(build_one(LIFT.plan, "commander"), heard)
    return [(tag.t / 1e9, message) for tag, _, message in text]


def test_an_operator_command_can_be_given_while_the_action_list_runs() -> None:
    text = commander((seconds(3), words("loader-2: lock")))
    assert [message for t, message in text if t == 3.0] == [
        OperatorAnswer("loader-2: lock", seconds(3)),
        Order(
            "loader-2.hinge.lock", 4, (-2, 0), BrakeOrder(model="loader-2", brake="loader-2.hinge.lock", engaged=True)
        ),
    ]
    assert [message.name for _, message in text if isinstance(message, Stage)] == ["take up slack"]


def test_a_refused_operator_command_changes_nothing() -> None:
    """H1 is hoisting since 0 s: the command for all hooks is refused as a whole, and the list goes on."""
    text = "all hooks: hoist 3 m/min by 1 m"
    output = commander((seconds(3), words(text)))
    (answer,) = (message for t, message in output if t == 3.0)
    assert isinstance(answer, OperatorAnswer)
    assert answer.refused.startswith("crane.H1 gets an order while its hoist (order 1 of action 1) is not done")
    assert answer.at == (0, 0)
    sentence = located(LIFT.plan, answer.refused, answer.at)
    assert re.match(r"crane\.H1 gets an order while its hoist \(lift\.yaml:\d+:5\) is not done", sentence)
    assert output[:-1] == commander()


@pytest.mark.parametrize(
    ("setting", "text", "sentence"),
    [
        ("motion=across", "crane: travel 5 m/min by 1 m", "crane.gantry cannot move: it is held by 'motion: across'"),
        (
            "locked=[trolleys]",
            "crane upper trolley: traverse 5 m/min by 1 m",
            "crane.upper-slide cannot move: it is held by 'locked'",
        ),
    ],
)
def test_an_operator_command_to_a_joint_that_the_model_level_locks_is_refused(
    setting: str, text: str, sentence: str
) -> None:
    scene = load("lift", [f"fidelity.{setting}", "actions=[{wait: 10 s}]", "end=60 s"])
    output = drive(build_one(scene.plan, "commander"), [(seconds(3), "command", words(text))])
    (answer,) = (message for _, _, message in output)
    assert isinstance(answer, OperatorAnswer)
    assert answer.refused.startswith(f"{sentence} of 'fidelity'; write ")


REHUNG = """
heavylift: 1
name: rehung
blocks:
  A: {mass: 2 t, size: [2 m, 2 m, 2 m], at: [-1.5 m, 15 m, 2 m], lugs: {a: [0 m, 0 m, 1.1 m]}, supports: SUPPORTS}
  B: {mass: 2 t, size: [2 m, 2 m, 2 m], at: [1.5 m, 15 m, 2 m], lugs: {a: [0 m, 0 m, 1.1 m]}, supports: SUPPORTS}
cranes: {hall: {type: overhead-100, at: 0 m, trolley: 15 m}}
rigging: {legs: {on: hall main, to: [A.a], length: 6 m}}
actions: [{legs: unhook}, {legs: "hook [B.a]"}, {wait: 100 s}]
""".replace("SUPPORTS", "{height: 1 m, at: [[-1 m, -1 m], [1 m, -1 m], [0 m, 1 m]]}")


@pytest.mark.parametrize("target", ["hall main", "legs", "all hooks"])
def test_an_operator_can_unhook_slings_from_the_block_to_which_an_earlier_order_hooked_them(target: str) -> None:
    """The list takes the sling from block A to block B; what a command unhooks then hangs on B."""
    scene = parse(REHUNG)
    (off,), (on,) = (scene.plan.actions[i].orders for i in (0, 1))
    text = f"{target}: unhook"
    command = OperatorCommand(text, msgspec.msgpack.encode(spoken(scene, text)))
    reports = (Unhooked(off.sling), Done(off.sling, 1)), (Hooked(on.sling, "B.a"), Done(on.sling, 2))
    heard = [(seconds(t), "report", x) for t, each in enumerate(reports, 1) for x in each]
    heard.append((seconds(3), "command", command))
    said = [message for tag, _, message in drive(build_one(scene.plan, "commander"), heard) if tag.t == seconds(3)]
    assert [x.what.sling for x in said if isinstance(x, Order)] == [on.sling] != [off.sling]
    assert [x.refused for x in said if isinstance(x, OperatorAnswer)] == [""]


def test_an_empty_text_as_operator_command_ends_the_run() -> None:
    text = commander((seconds(3), OperatorCommand("stop")))
    assert text[-1] == (3.0, Finished())
    assert not [
        message for t, message in text if t > 0 and isinstance(message, Order) and isinstance(message.what, EndOrder)
    ]
