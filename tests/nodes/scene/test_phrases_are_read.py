"""Phrases of orders and conditions: their values, and the place of the fault in invalid ones."""

import math
from fractions import Fraction

import pytest
from heavylift.nodes.plan import AfterCondition, MovesDone
from heavylift.nodes.scene.language import (
    CrossTest,
    GroundTest,
    OrderPhrase,
    PhraseError,
    SlingTest,
    read_condition,
    read_order,
)

RATE = float(Fraction("0.15") * Fraction(math.radians(1)))
ORDERS = {
    "hoist 3 m/min by 2 m": OrderPhrase("hoist", 0.05, by=2.0),
    "hoist 3 m/min ramp 0.02 m/s2 by 23 m": OrderPhrase("hoist", 0.05, ramp=0.02, by=23.0),
    "lower 3 m/min to 61 m of rope": OrderPhrase("lower", 0.05, to=61.0, of_rope=True),
    "traverse 20 m/min by -11.2 m": OrderPhrase("traverse", 1 / 3, by=-11.2),
    "drive 2 deg/s by 10 deg": OrderPhrase("drive", math.radians(2), True, by=math.radians(10)),
    "turn 0.15 deg/s to 90 deg": OrderPhrase("turn", RATE, True, to=math.pi / 2),
    "hook [C1, C2]": OrderPhrase("hook", lugs=("C1", "C2")),
    "unhook": OrderPhrase("unhook"),
    "wait 1.5 min": OrderPhrase("wait", seconds=90.0),
}

CONDITIONS = {
    "all slings taut": SlingTest("all", "", "slings", "taut", 0, text="all slings taut"),
    "any B slings slack": SlingTest("any", "B", "slings", "slack", 0, text="any B slings slack"),
    "loader-1.sling-2 taut": SlingTest("all", "loader-1.sling-2", "one", "taut", 0, text="loader-1.sling-2 taut"),
    "moves done": MovesDone(text="moves done"),
    "hoist done": MovesDone(verbs=("hoist",), text="hoist done"),
    "lifted": GroundTest("lifted", 0, text="lifted"),
    "after 60 s": AfterCondition(seconds=60.0, text="after 60 s"),
    "angle >= 90 deg": CrossTest("angle", "", True, math.pi / 2, True, 0, text="angle >= 90 deg"),
    "tension of A slings <= 3 MN": CrossTest(
        "tension", "A slings", False, 3e6, False, 0, text="tension of A slings <= 3 MN"
    ),
}

WRONG = {
    "hoist 3 m/min bye 2 m": (14, "after the speed 'by' or 'to' or 'until' must follow, not 'bye'"),
    "hoist": (5, "the phrase ends where a speed is expected"),
    "hoist 3 m/min by 2 m now": (21, "the phrase is complete before 'now'; remove the rest"),
    "hoist 3 m/min until taut": (20, "'taut' needs to know of what"),
    "turn 0.15 deg/s by 90 deg": (16, "after the rate 'to' must follow, not 'by'"),
    "hook C1": (5, "after 'hook' '[' must follow, not 'C1'"),
    "unhook all": (0, "nothing can follow 'unhook': remove 'all'"),
    "wait -3 s": (5, "-3 s is out of range: choose 0.001 ms to 100 days"),
    "wait nan s": (5, "nan is out of range: choose 0.001 ms to 100 days"),
    "wait 101 days": (5, "101 days is out of range: choose 0.001 ms to 100 days"),
    "hoist 3 m/min until after 2401 h": (26, "2401 h is out of range: choose 0.001 ms to 100 days"),
}


@pytest.mark.parametrize("text", ORDERS)
def test_order_phrases_are_parsed_into_their_values(text: str) -> None:
    assert read_order(text) == ORDERS[text]


@pytest.mark.parametrize("text", CONDITIONS)
def test_condition_phrases_are_parsed_into_their_values(text: str) -> None:
    assert read_condition(text) == (CONDITIONS[text],)


def test_conditions_of_an_action_can_be_joined_by_the_word_and() -> None:
    text = "landed and all slings slack"
    assert read_condition(text) == (
        GroundTest("landed", 0, text="landed"),
        SlingTest("all", "", "slings", "slack", 11, text="all slings slack"),
    )


@pytest.mark.parametrize("text", WRONG)
def test_an_invalid_phrase_of_an_order_or_condition_is_refused(text: str) -> None:
    with pytest.raises(PhraseError) as refusal:
        read_order(text)
    assert (refusal.value.column, str(refusal.value)) == WRONG[text]


def test_an_order_text_of_more_than_10_000_characters_is_refused() -> None:
    for text in ("lower " + "9" * 1_500_000, "lower 1 m" + " " * 1_500_000, "when " + "x" * 1_500_000):
        for read in (read_order, read_condition):
            with pytest.raises(PhraseError, match=f"a phrase has at most 10000 characters, this one has {len(text)}"):
                read(text)
