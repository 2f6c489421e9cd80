"""`heavylift limits`: the last green and the first red value, or why there is no such pair."""

from __future__ import annotations

from collections.abc import Callable

import pytest
from heavylift.coordinator.sweeps import limiting, limits_sheet, limits_table, motion_of
from heavylift.kernel import SceneError
from heavylift.nodes.scene import load
from heavylift.recordings.sheets import page_of, table_text

MASS = "block.mass=300..900 t"


@pytest.fixture(scope="module")
def lift():
    return load("lift")


@pytest.fixture
def told(lift, monkeypatch: pytest.MonkeyPatch):
    """What is found of a lift whose verdict is reported by a function of the mass [t]."""

    def found(
        green: Callable[[float], bool], asked: str = MASS, cut: bool = False, waits: str = ""
    ) -> limiting.FoundLimit:
        def played(task, variant):
            (x,) = variant.values
            status = "cut" if cut else "done" if green(x) else "red"
            name = "crane.H3 hook load"
            used = {
                "use": x / 1000.0,
                f"use/{name}": x / 1000.0,
                "limit": name,
                "limit stage": "up",
                "limit at [s]": 30.0,
                "unfinished": waits,
            }
            return {
                "status": status,
                "state": "green" if status == "done" else "red",
                "sentence": "cut after 60 s",
                "verdict": "red: too heavy",
                **used,
            }

        monkeypatch.setattr(limiting, "played", played)
        return limiting.limits_of(lift, asked)

    return found


@pytest.mark.parametrize("limit", [300.5, 333.3, 512.0, 899.0])
def test_the_found_limit_of_an_input_lies_between_its_last_green_and_its_first_red_value(told, limit: float) -> None:
    found = told(lambda x: x <= limit)
    assert not found.wrong
    assert found.green <= limit < found.red
    assert found.red - found.green <= max(0.5, 0.01 * (limit - 300.0))
    assert f"green up to {found.green:.5g} t, governed by crane.H3 hook load" in str(found)
    assert str(found).endswith("red: too heavy")
    assert len(found.runs) < 25


def test_a_limit_search_whose_scene_ends_before_the_lift_suggests_a_later_end(told) -> None:
    assert str(told(lambda x: x <= 400.0, waits="moves done")).endswith(
        "red: too heavy; let the run last longer, --set 'end=...'"
    )


def test_a_search_downward_from_a_high_value_finds_the_lower_limit(told) -> None:
    found = told(lambda x: x >= 400.0, "block.mass=900..300 t")
    assert found.red < 400.0 <= found.green
    assert found.green - found.red <= 3.0


def test_a_limit_search_finds_the_limit_of_a_linear_utilisation_in_one_step(
    lift, monkeypatch: pytest.MonkeyPatch
) -> None:
    def played(task, variant):
        (x,) = variant.values
        row = {"use": x / 512.0, "use/hook": x / 512.0, "limit": "hook", "limit stage": "up", "limit at [s]": None}
        status, state = ("done", "green") if x <= 512.0 else ("red", "red")
        return row | {"status": status, "state": state, "verdict": "red: too heavy", "sentence": ""}

    monkeypatch.setattr(limiting, "played", played)
    monkeypatch.setattr(limiting, "_bar", lambda *_: 0.01)
    found = limiting.limits_of(lift, MASS)
    assert found.green <= 512.0 < found.red
    assert len(found.runs) == 8 + 2 + 3  # growing steps, one guess on either side, beyond
    assert "in stage 'up'; red at" in str(found), "a design load has no time"
    assert "hook" in table_text(limits_table([found]))
    assert found.half == pytest.approx(5.12)
    assert "green up to" in str(found)
    assert " +- 5.1 t, governed by hook (" in str(found)
    assert " +- 1.00%) in stage 'up'; red at " in str(found)


@pytest.mark.parametrize(("fails", "shown"), [("red", "amber"), ("undecided", "undecided: too near")])
def test_a_limit_search_reports_the_verdict_at_each_value_that_it_runs(
    lift, monkeypatch: pytest.MonkeyPatch, fails, shown: str
) -> None:
    state = shown.partition(":")[0]
    row = {"status": "done", "sentence": "", "use": 0.5, "limit": "hook", "limit stage": "up", "limit at [s]": None}
    monkeypatch.setattr(
        limiting, "played", lambda *_: row | {"state": state, "verdict": f"{state}: 1 of 9; worst: too near"}
    )
    lines: list[str] = []
    limiting.limits_of_all(lift, [MASS], say=lines.append, fails=fails)
    assert lines[-1].endswith(f": {shown}")


@pytest.mark.large
def test_the_error_estimate_of_a_limit_follows_from_that_of_the_governing_utilisation(lift) -> None:
    found = limiting.limits_of(load("lift", ["end=100 s"]), "block.mass=500..540 t")
    assert found.green == pytest.approx(519.5, abs=1.0)
    assert found.most["use"] <= 1.0 < found.runs[found.red]["use"]
    assert 1e-4 < found.bar < 0.01
    assert found.half == pytest.approx(found.bar * found.green, rel=0.1)  # the use is as the weight


@pytest.mark.parametrize(
    ("name", "first", "all_orders"),
    [
        ("hoist speed", "hoist 0.2 m/min until all slings taut", [0.2, 0.2, 2.0]),
        ("hoist accel", "hoist 0.3 m/min ramp 2 m/s2 until all slings taut", [0.3, 0.3, 3.0]),
    ],
)
def test_varying_the_speed_of_all_moves_of_one_kind_keeps_their_proportions(
    lift, name: str, first: str, all_orders: list[float]
) -> None:
    motion = motion_of(lift, name)
    text = motion.setting(f"2 {motion.unit}")
    assert text[0].partition("=")[2] == first
    moved = load("lift", text).plan.actions[:3]
    assert [60.0 * abs(action.orders[0].speed) for action in moved] == pytest.approx(all_orders)
    if name == "hoist accel":
        assert [action.orders[0].accel for action in moved] == [2.0] * 3


def test_a_search_for_a_speed_limit_keeps_swing_free_ramps() -> None:
    swingless = load("lift", ["actions[3].trolleys=traverse 20 m/min ramp one swing by 2 m"])
    assert motion_of(swingless, "trolley accel") is None
    (text,) = motion_of(swingless, "trolley speed").setting("10 m/min")
    assert text == "actions[3].trolleys=traverse 10 m/min ramp one swing by 2 m"


def test_a_search_for_all_limits_covers_the_speeds_and_uncertain_inputs_of_a_scene(lift) -> None:
    names = limiting.askable(lift)
    assert names[:4] == ["hoist speed", "hoist accel", "trolley speed", "trolley accel"]
    assert {"block.mass", "block.com.x", "block.com.y", "block.com.z"} < set(names)


def test_limits_found_for_several_inputs_are_in_one_table_and_on_one_page(told, lift) -> None:
    found = [told(lambda x: x < 500.0), told(lambda x: True)]
    first, second = table_text(limits_table(found)).splitlines()[1:]
    assert first.split()[:1] == second.split()[:1] == ["block.mass"]
    assert "crane.H3 hook load" in first
    assert "no value up to 900 t" in second
    page = page_of(limits_sheet(lift, found))
    assert page.count("<tr>") == 3
    assert page.count("<svg") == 1


@pytest.mark.parametrize(
    ("green", "wrong"),
    [
        (lambda x: False, "red at the start, 300 t: red: too heavy"),
        (lambda x: True, "no value up to 900 t"),
        (lambda x: x < 400.0 or x > 700.0, "but green again at"),
    ],
)
def test_a_limit_search_that_finds_no_limit_reports_why(told, green, wrong: str) -> None:
    assert wrong in told(green).wrong


def test_a_limit_search_ends_with_an_error_if_a_run_reaches_its_limit_of_wall_time(told) -> None:
    with pytest.raises(SceneError, match="cut after 60 s"):
        told(lambda x: True, cut=True)


@pytest.mark.parametrize(
    "asked", ["block.mas", "stage up/all hooks/hoist", "block.mass=3 t", "block.mass=3..3 t", "block.mass=3 t..4 kg"]
)
def test_a_limit_search_for_an_input_that_is_not_a_number_is_refused(lift, asked: str) -> None:
    with pytest.raises(SceneError, match=f"--of '{asked}'"):
        limiting.limits_of(lift, asked)
