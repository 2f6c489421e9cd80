"""Lifts of goliaths among `lifts:`: each moves as it does alone, at its place, with its own rig, block and limits."""

from __future__ import annotations

import re
from pathlib import Path

import msgspec
import pytest
from heavylift.coordinator.run import run
from heavylift.coordinator.transport import Placement
from heavylift.nodes.models import KERNEL, build, couplings
from heavylift.nodes.plan import plan
from heavylift.nodes.scene import LoadedScene, check, load, parse
from heavylift.recordings import Recording

SETS = ["accuracy=0.1 %", "samples=2 Hz", "end=30 s"]
TEXT = """\
heavylift: 1
name: two
lifts:
  a: {extends: lift}
  b: {extends: lift, at: [30 m, 400 m], start: 2 s}
"""


@pytest.fixture(scope="module")
def two() -> LoadedScene:
    """Two lifts."""
    return parse(TEXT, overrides=SETS)


@pytest.fixture(scope="module")
def runs(two: LoadedScene, tmp_path_factory: pytest.TempPathFactory) -> dict[str, Recording]:
    """Both in one run, and the first alone."""
    folder: Path = tmp_path_factory.mktemp("runs")
    run(two, folder / "two.mcap", in_process=True)
    run(load("lift", SETS), folder / "one.mcap", in_process=True)
    return {name: Recording(folder / f"{name}.mcap") for name in ("one", "two")}


def test_names_in_the_plan_of_two_lifts_are_unique(two: LoadedScene) -> None:
    machines = [machine.name for machine in two.plan.machines]
    own = ["crane", "loader-1", "loader-2", "loader-3", "block"]
    assert sorted(machines) == sorted(f"{lift}-{name}" for lift in "ab" for name in own)
    assert [(x.name, [*x.machines]) for x in two.plan.lists] == [
        (lift, [f"{lift}-{name}" for name in own]) for lift in "ab"
    ]
    assert plan.decode(plan.encode(two.plan)) == two.plan
    wires = couplings(two.plan)
    assert ("commander", "order_b-crane", "b-crane", "order") in wires
    assert ("b-loader-3", "report", "commander", "report_b") in wires


def test_each_of_several_cranes_has_the_model_that_the_scene_describes_for_it(two: LoadedScene) -> None:
    a, b = two.plan.lists
    bending = msgspec.structs.replace(b, fidelity=plan.Fidelity(girder="elastic"))
    models = build(msgspec.structs.replace(two.plan, lists=(a, bending)))
    bodies = {name: {body.name for body in models[f"{name}-crane"].declare().bodies} for name in "ab"}
    assert bodies["a"] == {"a-crane.main", "a-crane.upper", "a-crane.lower"}
    assert bodies["b"] == {f"b-crane.{x}" for x in ("main", "girder", "upper", "lower")}
    ropes = {rope.name for model in models.values() for rope in model.declare().ropes}
    assert {"a-crane.H1", "b-crane.H3", "a-loader-1.sling-1", "b-loader-3.sling-2"} < ropes
    assert len(ropes) == 18


def test_the_first_of_two_cranes_moves_exactly_as_if_it_were_alone(runs: dict[str, Recording]) -> None:
    alone, other = runs["one"], runs["two"]
    for name in ("rope/tension/{}crane.H3", "rope/tension/{}loader-2.sling-1", "pose/{}block/z"):
        own, found = (
            dict(zip(x.t.tolist(), x.values[:, 0].tolist(), strict=True))
            for x in (alone[name.format("")], other[name.format("a-")])
        )
        times = sorted({*own} & {*found})
        assert len(times) >= 60
        assert [found[t] for t in times] == [own[t] for t in times]


def test_the_second_of_two_cranes_stands_at_its_stated_place(runs: dict[str, Recording]) -> None:
    other = runs["two"]
    for part in ("block", "crane.upper", "loader-2.lower"):
        first, there = (other[f"pose/{x}-{part}"].values[0, :3] for x in "ab")
        assert there - first == pytest.approx((30.0, 400.0, 0.0), abs=1e-9)
    assert {name for _, name in other.stages()} >= {"a: lift off", "b: lift off"}


def test_the_digest_of_a_run_with_two_lifts_is_equal_for_any_placement_of_nodes(
    two: LoadedScene, runs: dict[str, Recording], tmp_path: Path
) -> None:
    placement = Placement.spread([*build(two.plan), KERNEL], 4)
    found = run(two, tmp_path / "apart.mcap", placement=placement)
    assert found.digest == runs["two"].result["digest"]


def test_position_limits_of_a_crane_are_relative_to_the_origin_of_its_lift(two: LoadedScene) -> None:
    """The lower trolley goes to y = 83 m of its girder, the crane stands at x = 40 m of its rails."""
    most = {(use.limit.subject, use.limit.quantity): use.value for use in two.uses}
    for lift in "ab":
        assert most[f"{lift}-crane lower", "girder"] == pytest.approx(83.0, abs=0.01)
        assert most[f"{lift}-crane", "rails"] == pytest.approx(40.0, abs=1e-3)
        assert most[f"{lift}-loader-1.sling-1", "bridle angle"] == pytest.approx(0.0, abs=1e-3)
    assert re.search(r"hook load +a-crane.H3 \(of 6\)", str(check(two)))


BETWEEN = """\
heavylift: 1
name: two
lifts:
  a: {extends: lift}
  b: {extends: lift, at: [60 m, 0 m], start: ordered}
interlocks:
  apart: {when: gap a-crane b-crane <= 3 m, stops: [travel]}
actions:
  - when: a-block lifted and height of a-block >= 7 m and angle of a-block <= 1 deg
    wait: 1 s
  - when: tension of a-crane.H1 >= 500 kN and position of a-crane.lower-slide >= 82 m and load of a-crane.H3 >= 10 t
    b: begin
"""


def test_conditions_and_interlocks_of_one_lift_may_refer_to_parts_of_other_lifts() -> None:
    plan = parse(BETWEEN).plan
    stops = [(x.machine, [stop.actuator for stop in x.stops]) for x in plan.interlocks]
    assert stops == [(f"{lift}-crane", [f"{lift}-crane.gantry.drive"]) for lift in "ab"]
    _, _, own = plan.lists
    terms = [term for action in plan.actions[own.first :] for term in action.when.all]
    assert [term.model for term in terms] == ["a-block"] * 3 + ["a-crane"] * 3
    watched = {x.name for name in ("a-block", "a-crane") for x in build(plan)[name].declare().thresholds}
    assert {term.threshold.name for term in terms[1:]} < watched
