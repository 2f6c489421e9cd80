"""Each of the ten models of the lift receives and sends events; smaller lifts cause the events missing in it."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable
from dataclasses import replace
from math import pi
from pathlib import Path
from typing import Any

import pytest
from heavylift.coordinator.run import run
from heavylift.nodes.plan import Mechanism, Plan
from heavylift.nodes.scene import load
from lifting import pose
from msgspec.structs import replace as changed
from stock_reader import Reading

G = 9.80665
CRANES, LOADERS = ("west", "east"), tuple(f"loader-{i}" for i in range(1, 7))
SENT = {
    **{crane: {"Done", "SetProfile", "SetFollow", "Watch"} for crane in CRANES},
    **{loader: {"RopeState", "Watch"} for loader in LOADERS},
    **{
        loader: {"RopeState", "Watch", "Hook", "Unhook", "Hooked", "Unhooked", "SetBrake", "BrakeState", "Done"}
        for loader in ("loader-3", "loader-6")
    },
    "block": {"Lifted", "Touched", "Landed", "Attitude", "Watch"},
    "commander": {"Stage", "Finished", "motion", "end", "follow", "hook", "unhook", "SetProfile"},
}
HEARD = {
    **{crane: {"motion", "end", "follow"} for crane in CRANES},
    **{loader: {"StateEvent"} for loader in LOADERS},
    **{loader: {"StateEvent", "hook", "unhook"} for loader in ("loader-3", "loader-6")},
    "block": {"StateEvent"},
    "commander": {"Done", "RopeState", "Hooked", "Unhooked", "Lifted", "Landed"},
}


def _kind(e: dict[str, Any]) -> str:
    """The type of an event; of an order its kind."""
    return str(e["value"]["what"]["type"] if e["type"] == "Order" else e["type"])


@pytest.fixture(scope="session")
def sent(reading: Reading) -> dict[str, Counter[str]]:
    """Events by source and type."""
    found: dict[str, Counter[str]] = {}
    for e in reading.events:
        found.setdefault(e["source"], Counter())[_kind(e)] += 1
    return found


def test_the_scene_turnover_consists_of_ten_models_and_the_kernel(
    reading: Reading, sent: dict[str, Counter[str]]
) -> None:
    assert set(sent) == {*SENT, "kernel"}
    assert len(SENT) == 10


@pytest.mark.parametrize("model", SENT)
def test_each_model_of_the_scene_turnover_sends_events_during_the_run(
    sent: dict[str, Counter[str]], model: str
) -> None:
    assert set(sent[model]) >= SENT[model]


@pytest.mark.parametrize("model", HEARD)
def test_each_model_of_the_scene_turnover_receives_events(reading: Reading, model: str) -> None:
    ports = {f"order_{model}", f"state_{model}", *({"report"} if model == "commander" else ())}
    assert {_kind(e) for e in reading.events if e["port"] in ports} >= HEARD[model]


def test_every_order_in_the_scene_turnover_is_answered_exactly_once(reading: Reading) -> None:
    """An order with an id of its own that moves, hooks or unhooks has one Done; an actor gets each but once."""
    for model in (*CRANES, "loader-3", "loader-6"):
        orders = reading.said("commander", f"order_{model}")
        asked = [e["value"]["id"] for e in orders if _kind(e) in ("motion", "hook", "unhook")]
        done = [e["value"]["id"] for e in reading.said(model, "report", "Done")]
        assert sorted(asked) == sorted(done)
        assert len(set(asked)) == len(asked)


def test_the_block_reports_its_attitude_every_thirty_degrees(reading: Reading) -> None:
    message = [round(e["value"]["angle"] * 180 / pi, 6) for e in reading.said("block", "report", "Attitude")]
    assert list(dict.fromkeys(message))[:5] == [30.0, 60.0, 90.0, 120.0, 150.0]


def test_the_hinge_of_a_lifting_beam_is_locked_while_no_sling_is_hooked(reading: Reading) -> None:
    for loader in ("loader-3", "loader-6"):
        states = [(e["t_ns"], e["value"]["engaged"]) for e in reading.said(loader, "report", "BrakeState")]
        unhooked = {e["t_ns"] for e in reading.said(loader, "report", "Unhooked")}
        hooked = {e["t_ns"] for e in reading.said(loader, "report", "Hooked")}
        assert states == [(max(unhooked), True), (min(hooked), False)]


Story = Callable[[Callable[[Plan], Plan]], Reading]


@pytest.fixture
def smaller(tmp_path: Path) -> Story:
    """Run `lift` with a changed plan."""

    def go(change: Callable[[Plan], Plan]) -> Reading:
        scene = load("lift", ["end=60 s"])
        run(replace(scene, plan=change(scene.plan)), tmp_path / "lift.mcap", in_process=True)
        return Reading(tmp_path / "lift.mcap")

    return go


def with_cells(plan: Plan, name: str, rated: float) -> Plan:
    """The load cells of machines whose names begin so with another rated value [N]."""

    def one(machine: Mechanism) -> Mechanism:
        cells = tuple(changed(cell, rated=rated) for cell in machine.cells if cell.body != "crane.upper")
        return changed(machine, cells=cells) if machine.name.startswith(name) else machine

    return changed(plan, machines=tuple(map(one, plan.machines)))


def test_a_crane_with_too_low_a_rating_reports_an_overload(smaller: Story) -> None:
    """360 t and three hook blocks of 25 t, against 300 t, three loaders of 45 t and the jerk of the lift-off."""
    rated = (360e3 + 3 * 25e3) * G
    reading = smaller(lambda p: with_cells(p, "crane", rated))
    message = reading.said("crane", "report", "Overload")[0]["value"]
    assert message == {"actor": "crane.main.load", "tension": rated, "rated": rated, "over": True}


def test_a_lifting_beam_with_too_low_a_rating_reports_an_overload(smaller: Story) -> None:
    reading = smaller(lambda p: with_cells(p, "loader", 1.1e6))
    message = [(e["source"], e["value"]["over"]) for e in reading.events if e["type"] == "Overload"]
    assert message == [("loader-3", True)]  # the others carry 1.0 MN each


def test_a_trolley_stops_at_its_end_position(smaller: Story) -> None:
    def change(p: Plan) -> Plan:
        crane, *others = p.machines
        short = [changed(x, upper=x.start + 1.0) if x.name == "crane.upper-slide.drive" else x for x in crane.actuators]
        return changed(p, machines=(changed(crane, actuators=tuple(short)), *others))

    message = [e["value"] for e in smaller(change).said("crane", "report", "Limit")]
    assert message == [{"actor": "crane.upper-slide.drive", "limit": "travel limit", "position": 70.0}]


def test_a_hook_stops_at_its_upper_limit_switch(smaller: Story) -> None:
    def change(p: Plan) -> Plan:
        crane, *others = p.machines
        top = pose(p, "loader-1.upper")[2] + 0.5
        low = tuple(changed(x, highest=top) if x.highest else x for x in crane.actuators)
        return changed(p, machines=(changed(crane, actuators=low), *others))

    reading = smaller(change)
    tripped = {e["value"]["name"]: e["t_ns"] for e in reading.said("kernel", "state_crane")}
    stopped = {e["value"]["actor"]: e["t_ns"] for e in reading.said("crane", "report", "Limit")}
    assert set(stopped) == {"crane.H1", "crane.H2", "crane.H3"}
    for hook, t in stopped.items():
        assert t == tripped[f"{hook}.highest"] + 1_000_000_000  # 3 m/min ramped down with 0.05 m/s2
