"""Clearances of recorded lifts: against a brute search over all samples, and what they must not call trouble."""

from __future__ import annotations

from itertools import combinations
from pathlib import Path

import msgspec
import numpy as np
import pytest
from heavylift.coordinator.run import run
from heavylift.coordinator.verdict import BLOCK, SHARP, Conduct, History, Moving, conduct_findings, history_of, seen
from heavylift.coordinator.verdict.clearances import clearances
from heavylift.coordinator.verdict.moving import moving
from heavylift.nodes.plan import Plan, Shapes, Solid
from heavylift.nodes.scene import load
from heavylift.recordings import Recording
from heavylift.recordings.format import Rig
from numpy.typing import NDArray
from scipy.optimize import lsq_linear
from scipy.spatial.transform import Rotation

BETWEEN = 0.02  # [m] that a lift in calm moves between samples, and what bounds leave
RUN = "run.mcap"
SEEDS = (3, 4)
SLOW = 3e-3  # [m] from sample to sample


def kept(plan: Plan, distance: float) -> Plan:
    """The plan with another clearance."""
    limits = (msgspec.structs.replace(x, value=distance) if x.quantity == "clearance" else x for x in plan.limits)
    return msgspec.structs.replace(plan, limits=tuple(limits))


def apart(a: Moving, b: Moving) -> float:
    """The least distance of two shapes over all samples, by bounded least squares."""
    found = np.inf
    for k in range(len(a.t)):
        (A, half), (B, other) = (x.at(k, 0.0)[1:] for x in (a, b))
        both = np.concatenate([half, other]) + 1e-12
        M, d = np.hstack([A, -B]), b.centre[k] - a.centre[k]
        found = min(found, float(np.linalg.norm(M @ lsq_linear(M, d, (-both, both), method="bvls").x - d)))
    return found - a.radius - b.radius


def test_clearances_agree_with_a_brute_force_search(tmp_path: Path) -> None:
    scene = load("lift", ["end=30 s"])
    run(scene, tmp_path / RUN, in_process=True)
    history = history_of(Recording(tmp_path / RUN)).part(0, BLOCK)
    found = clearances(scene.plan, history)
    shapes = moving(Shapes(scene.plan), history)
    assert len(found) == 10
    assert [c.distance for c in found] == sorted(c.distance for c in found)
    for c in (found[1], found[2], found[-1]):  # the first is to the ground
        pairs = [(a, b) for a in shapes for b in shapes if (a.shape.thing, b.shape.thing) == (c.a, c.b)]
        least = min(apart(a, b) for a, b in pairs)
        assert least - BETWEEN < c.distance <= least + 1e-3, (c.a, c.b)
        gap = np.linalg.norm(np.array(c.p_WA) - np.array(c.p_WB))
        assert gap == pytest.approx(c.distance, abs=BETWEEN), "the points are those that are so near"


def ways(history: History, draw: np.random.Generator) -> History:
    """Every body goes its own way high above the ground: straight and turning, with a bend each 20 samples."""
    n = 70
    rest = np.arange(n) % 20 == 0

    def distance(size: int, scale: float) -> NDArray[np.float64]:
        steps = draw.normal(0.0, scale, (n, size))
        bends = np.maximum.accumulate(np.where(rest, np.arange(n), 0))
        return np.cumsum(steps[bends], axis=0)

    poses = {}
    for body in history.poses:
        place = draw.normal((0.0, 0.0, 300.0), 30.0) + distance(3, SLOW)
        turns = Rotation.from_rotvec(draw.normal(0.0, 1.0, 3)) * Rotation.from_rotvec(distance(3, SLOW / 30))
        poses[body] = np.hstack([place, turns.as_quat()])
    tensions = {rope: np.full(n, 1e5) for rope in history.tensions}
    return History(np.arange(n) * 0.5, poses, tensions, {}, history.rigs[:1])


def test_the_branch_and_bound_search_finds_the_clearances_of_an_exhaustive_search(tmp_path: Path) -> None:
    """Random ways: each pair of shapes at each sample exactly, but for those whose balls are
    farther apart."""
    plan = load("lift").plan
    run(load("lift", ["end=1 s"]), tmp_path / RUN, in_process=True)
    recorded = history_of(Recording(tmp_path / RUN)).part(0, BLOCK)
    for seed in SEEDS:
        nothing_is_lost(plan, ways(recorded, np.random.default_rng(seed)))


def nothing_is_lost(plan: Plan, history: History) -> None:
    found = clearances(plan, history)
    least: dict[frozenset[str], float] = {}
    known = Shapes(plan)
    shapes = moving(known, history)
    for a, b in combinations(shapes, 2):
        both = frozenset((a.shape.thing, b.shape.thing))
        still = all(isinstance(s.shape, Solid) and s.shape.body == "world" for s in (a, b))
        if still or len(both) == 1 or (means := known.relation(a.shape, b.shape)) == "joined":
            continue
        balls = np.linalg.norm(a.centre - b.centre, axis=1).min() - a.reach - b.reach - a.radius - b.radius
        if balls > found[-1].distance + BETWEEN:
            continue
        each = min(x.least for x in seen([(a, b, k) for k in range(len(history.t))]))
        if means == "apart" or each < -0.01:
            least[both] = min(least.get(both, np.inf), each)
    nearest = sorted(least.values())
    assert len({frozenset((c.a, c.b)) for c in found}) == len(found)
    assert len(found) == max(10, sum(x < 0.5 for x in nearest))
    for x, c in zip(nearest, found, strict=False):
        assert c.distance == pytest.approx(x, abs=BETWEEN)
    for c in found:
        expected = least[frozenset((c.a, c.b))]
        assert expected - BETWEEN < c.distance <= expected + SHARP, (c.a, c.b)
        assert np.linalg.norm(np.array(c.p_WA) - np.array(c.p_WB)) == pytest.approx(abs(c.distance), abs=BETWEEN)


def test_clearances_are_checked_against_the_required_clearance_of_the_scene(tmp_path: Path) -> None:
    scene = load("lift", ["end=20 s"])
    run(scene, tmp_path / RUN, in_process=True)
    history = history_of(Recording(tmp_path / RUN)).part(0, BLOCK)
    assert all(c.distance > 0.5 for c in clearances(scene.plan, history))
    near = clearances(kept(scene.plan, 12.0), history)
    assert len(near) > 10, "all that are below the limit, not ten"
    assert all(c.distance < 12.0 for c in near)


def test_hoisting_a_hook_into_its_upper_limit_is_reported_as_two_blocking(tmp_path: Path) -> None:
    up = 'actions=[{crane H1: "unhook"}, {crane H1: "hoist 10 m/min until tension of crane.H1 >= 5 MN"}]'
    result = run(load("lift", [up, "cranes.crane.highest_hook=24 m", "end=20 s"]), tmp_path / RUN, in_process=True)
    assert result.verdict is not None
    (found,) = [f for f in result.verdict.findings if f.quantity == "hook height"]
    assert (found.word, found.subject) == ("red", "crane.H1"), "told once"
    text = Conduct(stopped=[(3.0, "crane.H1", "upper limit"), (4.0, "crane.lower-slide.drive", "travel limit")])
    switch, end = conduct_findings(load("lift").plan, text)
    assert (switch.word, switch.t) == ("red", 3.0)
    assert switch.sentence == "the hook H1 of crane was two-blocked: its upper limit switch stopped it"
    assert (end.word, end.sentence) == (
        "warning",
        "the lower trolley of crane was stopped by its limit 'travel limit'",
    )


def test_connected_bodies_have_no_clearance_check_and_adjacent_parts_are_checked_only_for_penetration() -> None:
    known = Shapes(load("turnover").plan)
    shapes = {(s.thing, s.part): s for s in known.solids}
    ropes = known.strands
    block, beam = shapes["block", ""], shapes["loader-3", "beam"]
    leg = shapes["portal of west", "leg"]
    assert known.relation(block, shapes["supports", "block.lower-1"]) == "joined"
    assert known.relation(beam, ropes["loader-3.sling-1"]) == "joined"
    assert known.relation(beam, ropes["west.H3"]) == "joined"
    assert known.relation(leg, shapes["upper trolley of west", ""]) == "joined"
    assert known.relation(block, ropes["loader-3.sling-1"]) == "through"
    assert known.relation(beam, block) == "apart"
    assert known.relation(leg, block) == "apart"
    assert known.relation(leg, shapes["portal of east", "leg"]) == "apart"
    assert known.relation(beam, ropes["west.H1"]) == "apart"


def test_the_clearance_of_a_slack_sling_accounts_for_its_sag(tmp_path: Path) -> None:
    """Its chord may pass through the block; only a taut one does."""
    scene = load("lift", ["end=12 s"])
    run(scene, tmp_path / RUN, in_process=True)
    history = history_of(Recording(tmp_path / RUN)).part(0, BLOCK)
    line = next(x for x in history.rigs[0].lines if x.rope == "loader-1.sling-1")
    below = type(line)(line.rope, line.a_body, line.a, line.b_body, (line.b[0], line.b[1], -4.3))
    for tension, red in ((0.0, 0), (1e5, 1)):
        given = History(
            history.t, history.poses, {**history.tensions, line.rope: np.full(len(history.t), tension)}, {},
            [Rig(0, [below])],
        )  # fmt: skip
        found = [c for c in clearances(scene.plan, given) if c.a == line.rope and c.b == "block"]
        assert len(found) == red
