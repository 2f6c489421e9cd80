"""`heavylift limits`: the last green and the first red value, or why there is no such pair."""

from __future__ import annotations

from collections.abc import Callable

import pytest
from heavylift.coordinator.sweeps import limiting
from heavylift.kernel.errors import SceneError
from heavylift.nodes.scene import load

MASS = "block.mass=300..900 t"


@pytest.fixture(scope="module")
def lift():
    return load("lift")


@pytest.fixture
def told(lift, monkeypatch: pytest.MonkeyPatch):
    """What is found of a lift whose verdict is told by a function of the mass [t]."""

    def found(green: Callable[[float], bool], asked: str = MASS, cut: bool = False) -> limiting.Limited:
        def played(task, variant):
            (x,) = variant.values
            status = "cut" if cut else "done" if green(x) else "red"
            used = {"use": x / 1000.0, "limit": "crane.H3 hook load", "limit stage": "up"}
            return {"status": status, "sentence": "cut after 60 s", "verdict": "red: too heavy", **used}

        monkeypatch.setattr(limiting, "played", played)
        return limiting.limits_of(lift, asked)

    return found


@pytest.mark.parametrize("limit", [300.5, 333.3, 512.0, 899.0])
def test_the_limit_lies_between_green_and_red(told, limit: float) -> None:
    found = told(lambda x: x <= limit)
    assert not found.wrong
    assert found.green <= limit < found.red
    assert found.red - found.green <= max(0.5, 0.01 * (limit - 300.0))
    assert f"green up to {found.green:.5g} t, where crane.H3 hook load" in str(found)
    assert str(found).endswith("red: too heavy")
    assert len(found.runs) < 25


@pytest.mark.parametrize(
    ("green", "wrong"),
    [
        (lambda x: False, "red at the start, 300 t: red: too heavy"),
        (lambda x: True, "nothing turns red up to 900 t"),
        (lambda x: x < 400.0 or x > 700.0, "but green again at"),
    ],
)
def test_what_has_no_limit_is_said(told, green, wrong: str) -> None:
    assert wrong in told(green).wrong


def test_runs_that_were_cut_say_nothing(told) -> None:
    with pytest.raises(SceneError, match="cut after 60 s"):
        told(lambda x: True, cut=True)


@pytest.mark.parametrize("asked", ["block.mas", "stage up/all hooks/hoist", "block.mass=3 t", "block.mass=9..3 t"])
def test_what_is_no_number_is_refused(lift, asked: str) -> None:
    with pytest.raises(SceneError, match=asked.partition("=")[0]):
        limiting.limits_of(lift, asked)
