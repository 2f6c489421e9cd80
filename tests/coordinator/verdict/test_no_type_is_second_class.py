"""What planners found green on cranes other than goliaths is checked on every bundled type, by what its plan says."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
import pytest
from heavylift.coordinator.record import play
from heavylift.coordinator.verdict import near_at_rest
from heavylift.kernel import ModelError, SceneError
from heavylift.kernel.description import NOT_MODELLED, UNKNOWN, WORLD, Check, Point
from heavylift.nodes.limits import governing
from heavylift.nodes.models.commander import followers
from heavylift.nodes.plan import IN_WIND, lug_places, ties_on
from heavylift.nodes.scene import LoadedScene, bundled, load
from heavylift.nodes.statics import path_findings, world
from lift_of_a_type import Lift
from lifting import unstated
from scipy.spatial.transform import Rotation

MOVES = {"travel": "3 m/min by 2 m", "traverse": "3 m/min by 2 m", "slew": "0.5 deg/s by 12 deg"}
FAST = {"travel": "15 m/min by 8 m", "traverse": "15 m/min by 8 m", "slew": "2 deg/s by 40 deg"}


def red(scene: LoadedScene, word: str) -> list[Check]:
    return [c for c in scene.checks if c.state == "red" and c.quantity.startswith(word)]


def near(scene: LoadedScene) -> list[Check]:
    return [x for x in near_at_rest(scene.plan, scene.statics) if isinstance(x, Check)]


@pytest.mark.large(beyond=3)
def test_a_load_out_of_plumb_is_reported_with_its_rope_on_every_crane_type(lift: Lift) -> None:
    tight = "limits={off-lead: 0.1 deg}", "factors.wind=0 m/s"
    assert not red(lift.read(*tight), "off-lead")
    far = 1.0 if lift.half < 5.0 else 0.4  # [m]; below a heavy hook block slings drag a light load back
    lateral = lift.read(*tight, f"block.at=[{lift.x + far} m, {lift.y} m, 3 m]")
    assert red(lateral, "off-lead")


def test_dropping_a_load_in_the_air_is_refused_on_every_crane_type(lift: Lift) -> None:
    slings = [line.split(":")[0].strip() for line in lift.text.splitlines() if line.startswith("  legs-")]
    off = ", ".join(f"{name}: unhook" for name in slings or ["all hooks"])
    with pytest.raises(SceneError, match="would fall"):
        lift.read(text=lift.beginning(f"  - {{stage: let go, {off}}}\n"))


def test_a_gravity_other_than_that_of_the_earth_gives_an_amber_check_on_every_crane_type(lift: Lift) -> None:
    assert [c for c in lift.read().checks if c.quantity == "gravity"] == []
    (check,) = (c for c in lift.read("gravity=1 m/s2").checks if c.quantity == "gravity")
    assert check.state == "amber"


def test_a_block_that_comes_down_on_its_supports_in_a_turn_gives_a_red_check_on_every_crane_type(lift: Lift) -> None:
    """Hoisted by 1 m above them, it touches them before it has turned by 15 degrees."""
    turn = "  - stage: turn\n    block: turn 20 deg/min to 15 deg\n  - wait: 1 s\n"
    if not lift.text.count("crane: {type: goliath") + lift.text.count("crane: {type: twin"):
        with pytest.raises(SceneError, match="cannot turn"):
            lift.read(text=lift.beginning(turn))
        return
    assert red(lift.read(text=lift.beginning(turn)), "landing")
    assert not red(lift.read(), "landing")


def test_a_turn_over_is_refused_on_every_crane_type_if_all_slings_pull_along_one_line(lift: Lift) -> None:
    machines = lift.read().plan.machines
    for hook in (hook for machine in machines for hook in machine.hooks):
        lugs = {tie.rope: tie.lug for tie in ties_on(machines, hook) if tie.lug}
        with pytest.raises(ModelError, match=r"pull along a single line|no drive moves"):
            followers(machines, lugs)


@pytest.mark.large(beyond=5)
def test_a_wall_too_close_to_the_load_gives_a_red_check_on_every_crane_type(lift: Lift) -> None:
    wall = f"at: [{lift.x + lift.half + 0.1 + 0.5} m, {lift.y} m, 2 m]"
    scene = lift.read(f"obstacles={{wall: {{box: [1 m, 4 m, 4 m], {wall}}}}}", text=lift.beginning("  - wait: 1 s\n"))
    found = play(scene.plan).verdict.findings
    assert [f for f in found if f.state == "red" and f.quantity == "clearance" and "wall" in f.sentence]


def test_a_newly_created_scene_is_green_because_its_checks_pass(lift: Lift) -> None:
    assert {c.state for c in lift.read().checks} <= {"green", "none"}
    bare = lift.read(text=unstated(lift.text))
    assert {"amber"} < {c.state for c in bare.checks}, "nothing is green that nobody stated"


@pytest.mark.large(beyond=4)
def test_checks_after_a_run_are_amber_only_where_their_error_is_unknown(lift: Lift) -> None:
    checks = play(lift.read().plan).verdict.checks
    stated = (IN_WIND, "wind")  # which no run changes
    others = {(c.state, c.why) for c in checks if c.quantity not in stated}
    assert others <= {("amber", UNKNOWN), ("none", ""), ("none", NOT_MODELLED)}
    assert {c.state for c in checks if c.quantity in stated} <= {"green"}


@pytest.mark.large(beyond=4)
def test_the_swing_after_an_emergency_stop_is_checked(lift: Lift) -> None:
    go = f"  - {{stage: go, {lift.moved(FAST)}}}\n  - {{stage: halt, when: after 8 s, crane: stop}}\n  - wait: 15 s\n"
    run = play(lift.read("limits={off-lead: 0.05 deg}", text=lift.beginning(go)).plan)
    found = [c for c in run.verdict.checks if c.state == "red" and c.quantity.startswith("off-lead")]
    assert found
    worst = max(found, key=lambda c: c.value or 0.0)
    (hook,) = (hook for machine in run.plan.machines for hook in machine.hooks if hook.rope == worst.subject)
    (rope,) = (r for machine in run.plan.machines for r in machine.system.ropes if r.name == worst.subject)
    past = run.past.part(0, len(run.t))
    lead = sum(ends(past.poses, line.a) - ends(past.poses, line.b) for line in rope.lines[:1])
    angle = np.arctan2(np.hypot(lead[:, 0], lead[:, 1]), np.abs(lead[:, 2]))  # type: ignore[index]
    assert hook.rope == worst.subject
    assert 0.5 * float(angle.max()) <= (worst.value or 0.0) <= 1.05 * float(angle.max())


@pytest.mark.large(beyond=3)
def test_slings_that_pass_through_a_beam_are_reported(lift: Lift) -> None:
    """A box half way up a sling as it carries."""
    scene = lift.read()
    (state,) = [x for x in scene.statics.states if x.stage == "up" and not x.grounded][-1:]
    tie = next(x for machine in scene.plan.machines for x in machine.ties if x.rope in state.hooked)
    lugs = lug_places(scene.plan.machines)
    a, b = (world(state, x.body, x.p) for x in (tie.upper, lugs[tie.lug]))
    x, y, z = ((p + q) / 2 for p, q in zip(a, b, strict=True))
    beam = lift.read(f"obstacles={{beam: {{box: [0.3 m, 0.3 m, 0.3 m], at: [{x} m, {y} m, {z} m]}}}}")
    found = [f for f in near(beam) if f.state == "red" and "beam" in f.subject]
    assert any(tie.rope in f"{f.subject} {f.sentence}" or tie.rope.split(".")[0] in f.subject for f in found)


@pytest.mark.large(beyond=3)
def test_a_block_that_is_driven_into_a_wall_is_reported(lift: Lift) -> None:
    text = lift.beginning(f"  - {{stage: go, {lift.moved(MOVES)}}}\n")
    free = lift.read(text=text)
    before, after = (next(x for x in free.statics.states if x.stage == stage) for stage in ("up", "go"))
    last = [x for x in free.statics.states if x.stage == "go"][-1]
    (p, _), (q, _) = before.poses["block"], last.poses["block"]
    axis = max((0, 1), key=lambda i: abs(q[i] - p[i]))
    size, distance = free.scene.all_blocks["block"].size, 1.0 if q[axis] > p[axis] else -1.0
    at = [p[0], p[1], 3.0]
    at[axis] += distance * (size[axis] / 2 + 0.7 + 0.5)
    box = ["4 m", "4 m", "6 m"]
    box[axis] = "1 m"
    wall = f"obstacles={{wall: {{box: [{', '.join(box)}], at: [{', '.join(f'{x} m' for x in at)}]}}}}"
    scene = lift.read(wall, text=text)
    found = [f for f in near(scene) if f.state == "red" and "wall" in f.sentence]
    assert any("touched wall, which nothing orders" in f.sentence for f in found)
    assert after.stage == "go"


@pytest.mark.large(beyond=4)
def test_a_block_that_stays_on_its_supports_has_no_impact_check_and_is_governed_by_a_load_check(lift: Lift) -> None:
    stands = f"{lift.text[: lift.text.index('actions:')]}actions:\n  - wait: 2 s\n"
    for checks in (lift.read().checks, play(lift.read(text=stands).plan).verdict.checks):
        assert [x for x in checks if x.quantity == "impact" and x.use is not None] == []
        first, *_ = governing(checks)
        assert any(first.startswith(f"governs: {x.quantity} of") for x in checks if x.unit in ("N", "kg", "N m", "Pa"))


@pytest.mark.large(beyond=4)
def test_a_block_dropped_from_a_height_of_20_mm_exceeds_its_impact_limit(lift: Lift) -> None:
    text = lift.beginning("").replace("  - stage: up\n    all hooks: hoist 1 m/min by 1 m\n", "")
    ropes = [tie.rope for machine in lift.read().plan.machines for tie in machine.ties]
    parted = ", ".join(f"{rope}: release" for rope in ropes)
    drop = f"  - all hooks: hoist 1 m/min by 20 mm\n  - wait: 5 s\n  - {{{parted}}}\n  - wait: 2 s\n"
    run = play(lift.read(text=text + drop).plan)
    (impact,) = (c for c in run.verdict.checks if c.quantity == "impact")
    assert impact.state == "red"
    assert (impact.use or 0.0) > 1.3


@pytest.mark.parametrize("name", ["lift", "turnover"])
def test_the_scenes_lift_and_turnover_are_green_because_their_checks_pass(name: str) -> None:
    assert name in bundled()
    assert {c.state for c in load(name).checks} <= {"green", "none"}


def ends(poses: Mapping[str, np.ndarray], point: Point) -> np.ndarray:
    """(n, 3) where a point of a body is [m]."""
    if point.body == WORLD:
        return np.array(point.p)[None, :]
    x, y, z, w = poses[point.body][:, 3:].T
    R = Rotation.from_quat(np.stack([x, y, z, w], axis=1))
    return poses[point.body][:, :3] + R.apply(point.p)


def test_limits_stated_in_a_scene_apply_to_every_crane_type(lift: Lift) -> None:
    scene = lift.read("limits={clearance: 1 m, off-lead: 2 deg, impact: 1.2, wind: 9 m/s, bridle: 50 deg}")
    rows = {x.quantity: x for x in scene.plan.limits if x.source.startswith("the scene")}
    assert {"clearance", "bridle angle", "wind", "impact"} <= rows.keys()
    assert [x for x in rows if x.startswith("off-lead")]
    assert rows["clearance"].value == 1.0


def test_if_the_lift_has_no_equilibrium_the_error_names_the_hook_out_of_plumb_for_every_crane_type(lift: Lift) -> None:
    scene = lift.read(f"block.at=[{lift.x + 0.5} m, {lift.y} m, 3 m]")
    path = replace(
        scene.statics, states=scene.statics.states[:1], acted=(), notes=(), cut="", why="it finds no rest: so"
    )
    (found,) = path_findings(scene.plan, path)
    assert "is 0.50 m out of plumb; move it by 0.50 m along x and " in found.sentence


def test_a_hook_inside_an_obstacle_at_the_start_is_reported_in_one_sentence_on_every_crane_type(lift: Lift) -> None:
    free = lift.read()
    hook = next(hook for machine in free.plan.machines for hook in machine.hooks)
    x, y, z = free.statics.states[0].poses[hook.eye.body][0]
    wall = f"obstacles={{shed: {{box: [4 m, 4 m, 4 m], at: [{x} m, {y} m, {z} m]}}}}"
    frames = [machine.name for machine in free.plan.machines if machine.name.startswith("loader")]
    with pytest.raises(SceneError, match=r"made\.yaml:\d+:\d+: error: [^\n]* begins \d\.\d\d m inside of 'shed'"):
        lift.read(wall)
    assert lift.read(wall, f"may touch=[{', '.join(f'[shed, {name}]' for name in ('crane', *frames))}]").plan
