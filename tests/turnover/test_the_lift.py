"""The stages of the scene `turnover`: take up, load, hoist, travel, turn, re-rig, turn on, set down.

Every stage waits for a state of the load or for the end of a move, never for a time on the clock.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from heavylift.coordinator.run import run
from heavylift.nodes.scene import load
from independent_mechanics import Mechanics
from stock_reader import Reading
from the_run import Stage

UPSIDE_DOWN = np.radians(0.1)  # how far the former top face may lean at the end [rad]
WEIGHT = 1e-6  # of the weight, by which the supports may miss it
CREEP = 0.3 / 60  # speed at which slack is taken up [m/s]
A = {f"loader-{i}.sling-{k}" for i in (1, 2, 4, 5) for k in (1, 2)}
B = {f"loader-{i}.sling-{k}" for i in (3, 6) for k in (1, 2)}


def test_stages_of_the_scene_turnover_come_in_the_order_of_the_scene(reading: Reading) -> None:
    message = [e["value"]["name"] for e in reading.said("commander", "stage")]
    assert message == [a["stage"] for a in reading.scene["actions"] if a.get("stage")]
    milestones = ["take up slack", "load", "hoist", "travel", "turn to 90 degrees", "slacken B", "unhook B"]
    milestones += ["re-rig, pass beneath", "hook C", "take up C", "turn to 180 degrees", "lower", "set down", "rest"]
    assert [name for name in message if name in milestones] == milestones
    assert reading.said("commander", "finished")[-1]["t_ns"] == max(e["t_ns"] for e in reading.events)


def test_loading_begins_at_the_instant_when_the_last_sling_is_taut(reading: Reading) -> None:
    begin = _begin(reading, "load")
    assert {state for _, state in _sling_states(reading, begin)} == {"taut"}
    assert _last_change(reading, begin) == (begin, "taut")
    assert len(list(_sling_states(reading, begin))) == 12


def test_the_hoisting_stage_waits_until_the_block_has_left_its_supports(reading: Reading) -> None:
    lifted = [e["t_ns"] for e in reading.said("block", "report", "Lifted")]
    assert _begin(reading, "load") < lifted[0] < _begin(reading, "hoist")
    assert max(_halts(reading, lifted[0])) == lifted[0]  # the creeping hoists are reported to stop at once


def test_the_block_is_unhooked_from_crane_b_only_after_all_slings_of_crane_b_are_slack(reading: Reading) -> None:
    begin = _begin(reading, "settle on A")
    assert {state for name, state in _sling_states(reading, begin) if name in B} == {"slack"}
    assert begin < _begin(reading, "unhook B")
    off = [e for loader in ("loader-3", "loader-6") for e in reading.said(loader, "report", "Unhooked")]
    assert {e["value"]["actor"] for e in off} == B
    assert {e["t_ns"] for e in off} == {_begin(reading, "unhook B")}


def test_the_lower_trolleys_pass_below_the_upper_trolleys(reading: Reading, stages: dict[str, Stage]) -> None:
    before, after = stages["re-rig, pass beneath"].samples[0], stages["re-rig, pass beneath"].samples[-1]
    for crane in ("west", "east"):
        upper, lower = (reading.pose[f"{crane}.{trolley}"][:, 1] for trolley in ("upper", "lower"))
        assert lower[before] - upper[before] == pytest.approx(5.6, abs=0.02)
        assert lower[after] - upper[after] == pytest.approx(-5.6, abs=0.02)


def test_the_slings_of_crane_b_are_taut_at_their_new_lugs_before_the_turn_continues(reading: Reading) -> None:
    hooked = [e for loader in ("loader-3", "loader-6") for e in reading.said(loader, "report", "Hooked")]
    assert {e["value"]["actor"]: e["value"]["lug"] for e in hooked} == {
        "loader-3.sling-1": "C1", "loader-3.sling-2": "C2", "loader-6.sling-1": "C3", "loader-6.sling-2": "C4"
    }  # fmt: skip
    begin = _begin(reading, "take up C to length")
    assert {state for name, state in _sling_states(reading, begin) if name in B} == {"taut"}


def test_the_block_has_turned_upside_down_at_the_end_of_the_scene_turnover(
    mechanics: Mechanics, stages: dict[str, Stage]
) -> None:
    up = mechanics.bodies["block"].R[:, 2, 2]  # of the block's axis w in the world
    assert up[0] == pytest.approx(1.0, abs=1e-9)
    assert np.all(-up[stages["rest"].samples] > np.cos(UPSIDE_DOWN))


def test_the_supports_carry_the_whole_weight_at_the_end_of_the_scene_turnover(
    reading: Reading, mechanics: Mechanics, stages: dict[str, Stage]
) -> None:
    last = reading.values["/support/force"][stages["rest"].last(20.0)]
    weight = mechanics.bodies["block"].mass * mechanics.g
    upper = [i for i, name in enumerate(reading.names["/support/force"]) if name.startswith("block.upper")]
    assert np.max(np.abs(last[:, upper].sum(axis=1) / weight - 1.0)) < WEIGHT


def test_at_the_end_of_the_scene_turnover_all_slings_are_slack(reading: Reading, stages: dict[str, Stage]) -> None:
    end = reading.events[-1]["t_ns"]
    assert {state for _, state in _sling_states(reading, end)} == {"slack"}
    for sling in A | B:
        assert np.all(reading.column("/rope/tension", sling)[stages["rest"].last(20.0)] == 0.0), sling


def test_ropes_of_the_scene_turnover_never_push_and_hook_ropes_never_go_slack(reading: Reading) -> None:
    assert reading.values["/rope/tension"].min() >= 0.0
    assert reading.values["/rope/peak"].min() >= 0.0
    assert reading.values["/hook/load"].min() > 0.0


def test_supports_of_the_scene_turnover_never_pull_and_carry_nothing_while_the_block_hangs(
    reading: Reading, stages: dict[str, Stage]
) -> None:
    force = reading.values["/support/force"]
    assert force.min() >= 0.0
    air = slice(stages["travel"].samples[0], stages["lower"].samples[0])
    assert force[air].max() == 0.0


def test_additional_sling_slack_delays_the_loading_stage_by_its_take_up_time(tmp_path: Path) -> None:
    """With 0.1 m more slack the same list loads 20 s later, to the nanosecond of the longer creep."""
    begins = []
    for slack in ("0.3 m", "0.4 m"):
        scene = load("turnover", [f"rig.slack={slack}", "end=100 s"])
        run(scene, tmp_path / f"{slack}.mcap", in_process=True)
        begins.append(_begin(Reading(tmp_path / f"{slack}.mcap"), "load"))
    assert (begins[1] - begins[0]) * 1e-9 == pytest.approx(0.1 / CREEP, abs=0.05)


def _begin(reading: Reading, stage: str) -> int:
    """When a stage begins [ns]."""
    return next(int(e["t_ns"]) for e in reading.said("commander", "stage") if e["value"]["name"] == stage)


def _reports(reading: Reading, until_ns: int) -> Iterator[dict[str, Any]]:
    for loader in (m for m in reading.scene["machines"] if m.get("latches")):
        yield from (e for e in reading.said(loader["name"], "report", "RopeState") if e["t_ns"] <= until_ns)


def _sling_states(reading: Reading, until_ns: int) -> Iterator[tuple[str, str]]:
    """Each sling's state at this time as its loader has reported it."""
    yield from {e["value"]["actor"]: e["value"]["state"] for e in _reports(reading, until_ns)}.items()


def _last_change(reading: Reading, until_ns: int) -> tuple[int, str]:
    last = max(_reports(reading, until_ns), key=lambda e: int(e["t_ns"]))
    return last["t_ns"], last["value"]["state"]


def _halts(reading: Reading, until_ns: int) -> list[int]:
    orders = [e for crane in ("west", "east") for e in reading.said("commander", f"order_{crane}", "Order")]
    ends = [e for e in orders if e["value"]["what"] == {"type": "end"}]
    return [e["t_ns"] for e in ends if e["t_ns"] <= until_ns]
