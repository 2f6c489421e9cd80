"""`load` takes settings as text, several texts, a dict, or keywords with the same meaning."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from heavylift import load
from heavylift.kernel import SceneError

SAME: list[tuple[tuple[Any, ...], dict[str, Any]]] = [
    (("block.mass=280 t",), {}),
    ((["block.mass=280 t"],), {}),
    (({"block.mass": "280 t"},), {}),
    (({"block": {"mass": "280 t"}},), {}),
    ((), {"block": {"mass": "280 t"}}),
    ((), {"block.mass": "280 t"}),
    (("block.mass=1 t",), {"block": {"mass": "280 t"}}),  # what comes last lies on top
    ((("block.mass=1 t", "block.mass=280 t"),), {}),
]


@pytest.mark.parametrize(("given", "named"), SAME)
def test_all_forms_of_settings_in_python_give_the_same_plan(given: tuple[Any, ...], named: dict[str, Any]) -> None:
    assert load("lift", *given, **named).plan == load("lift", ["block.mass=280 t"]).plan
    assert load("lift").plan != load("lift", *given, **named).plan


def test_settings_may_be_numbers_booleans_and_lists() -> None:
    wanted = load("lift", ["microsteps=500", "block.at=[41 m, 75 m, 6 m]", "accuracy=0.02"]).plan
    for number in (500, np.int64(500)):
        given = {"microsteps": number, "block": {"at": ["41 m", "75 m", "6 m"]}, "accuracy": np.float64(0.02)}
        assert load("lift", given).plan == load("lift", **given).plan == wanted


@pytest.mark.parametrize("wrong", [5, None, ["block.mass=280 t", 5], [("block.mass", "280 t")]])
def test_invalid_settings_given_in_python_are_refused(wrong: Any) -> None:
    with pytest.raises(
        SceneError, match=r"are not settings; write 'block.mass=280 t', a list of such texts, or a dict"
    ):
        load("lift", wrong)


def test_errors_in_settings_are_reported_with_the_name_of_the_setting() -> None:
    for wrong in ({"block.mas": "280 t"}, "block.mas=280 t"):
        with pytest.raises(SceneError, match=r"(?s)block.mas: .*did you mean 'mass'"):
            load("lift", wrong)  # type: ignore[arg-type]
    with pytest.raises(SceneError, match="missing unit"):
        load("lift", block={"mass": 280})
    with pytest.raises(SceneError, match=r"end: <object .* is not a valid value of a setting"):
        load("lift", end=object())
