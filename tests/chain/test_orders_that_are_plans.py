"""Orders that stand for several moves: moves together, moves to above lugs, levelling of a block."""

from __future__ import annotations

from math import asin, atan2, cos, degrees, hypot, pi, sin
from pathlib import Path

import numpy as np
import pytest
from heavylift.coordinator.run import run
from heavylift.kernel import SceneError
from heavylift.nodes.scene import LoadedScene, parse
from heavylift.nodes.scene.construction import apart
from heavylift.recordings import Recording
from scenes_with_orders import assert_refused, scene

WAIT = "{when: moves stopped, wait: 20 s}"
UP = (
    "all hooks: hoist 0.3 m/min until all slings taut",
    "all hooks: hoist 0.3 m/min until lifted",
    "all hooks: hoist 3 m/min by 1 m",
)


def said(rec: Recording, kind: str) -> list[dict[str, object]]:
    return [e.value for e in rec.events() if e.type == kind]


# together


@pytest.mark.parametrize(("first", "trips"), [("west", 44.0), ("east", 80.0)])
@pytest.mark.large(beyond=1)
def test_cranes_that_travel_together_stop_together(tmp_path: Path, first: str, trips: float) -> None:
    """An interlock of one crane trips where it stands; the other one stops with it, as fast, and their gap stays."""
    limit = f"interlocks: {{end: {{when: position of {first} >= {trips} m, stops: [travel forward], on: {first}}}}}\n"
    more = f"{limit}cranes: {{{first}: {{emergency: 0.2 m/s2}}}}\n"
    made = scene("tandem", *UP, "cranes: travel 20 m/min ramp 0.1 m/s2 by 15 m together", WAIT, more=more)
    run(made, tmp_path / "run.mcap", in_process=True)
    rec = Recording(tmp_path / "run.mcap")
    west, east = (rec[f"pose/{name}.main"].values[:, 0] for name in ("west", "east"))
    assert np.ptp(east - west) < 5e-3, "servos of two drives that are moved alike"
    distance = (20 / 60) ** 2 / (2 * 0.2)
    assert west[-1] - west[0] == pytest.approx(4.0 + distance, abs=0.02)
    assert [v["actor"] for v in said(rec, "Limit")] == [f"{first}.gantry.drive"]


# above


def test_a_trolley_travels_to_the_point_above_the_middle_of_the_lugs() -> None:
    away, back = (f"crane lower trolley: traverse 20 m/min {to}" for to in ("by 3 m", "to above [R1, R2]"))
    made = scene("lift", "crane H3: unhook", away, back, more="end: 200 s\n")
    ends = {s.action: s.poses["crane.lower"][0][1] for s in made.statics.states}
    assert ends[2] == pytest.approx(84.0)
    assert ends[3] == pytest.approx(75.0 + 6.0, abs=2e-5)


@pytest.mark.parametrize("lugs", [("N1",), ("N1", "N3"), ("N2", "N4"), ("N1", "N2", "N3", "N4")])
def test_a_boom_slews_and_luffs_to_a_point_above_the_lugs(lugs: tuple[str, ...]) -> None:
    """After both, the hook hangs above the middle: its azimuth and its radius are those of the lugs."""
    listed = ", ".join(lugs)
    made = scene(
        "jib", "legs: unhook", "jib main: hoist 10 m/min by 20 m", "jib: slew 2 deg/s by -60 deg",
        f"jib: slew 2 deg/s to above [{listed}]", f"jib: luff 1 deg/s to above [{listed}]",
    )  # fmt: skip
    places = {"N1": (-2.5, 1.5), "N2": (2.5, 1.5), "N3": (-2.5, -1.5), "N4": (2.5, -1.5)}
    x, y = (20.0 * (i == 0) + sum(places[lug][i] for lug in lugs) / len(lugs) for i in (0, 1))
    hook = made.statics.states[-1].poses["jib.main"][0]
    assert atan2(hook[1], hook[0]) == pytest.approx(atan2(y, x), abs=2e-5)
    assert hypot(hook[0], hook[1]) == pytest.approx(hypot(x, y), abs=1e-3)


# level


def tilt(made: LoadedScene, action: int) -> float:
    """About the rails, of the rest in which an action ends [deg]."""
    state = next(s for s in reversed(made.statics.states) if s.action <= action)
    return degrees(asin(state.poses["block"][1][1][2]))


@pytest.mark.parametrize(("verb", "hook"), [("hoist", "H3"), ("lower", "H3"), ("hoist", "H1"), ("lower", "H1")])
def test_an_order_to_level_a_block_hoists_the_hook_of_its_low_side(verb: str, hook: str) -> None:
    hooks = ["crane H3"] if hook == "H3" else ["crane H1", "crane H2"]
    level = f"block: level 0.3 m/min within 0.1 deg with {', '.join(hooks)}"
    off = "{" + ", ".join(f"{each}: {verb} 1 m/min by 0.4 m" for each in hooks) + "}"
    made = scene("lift", *UP, off, level, "wait: 1 s", more="end: 200 s\n")
    assert abs(tilt(made, 4)) > 1.0
    assert abs(tilt(made, 7)) <= 0.1
    assert not [f for f in made.findings if f.state == "red"]


TURNED = (
    "all hooks: hoist 0.3 m/min until all slings taut", "all hooks: hoist 0.3 m/min until lifted",
    "{A hooks: hoist 3 m/min to 61 m of rope, B hooks: hoist 3 m/min to 19.4 m of rope}",
    "block: turn 0.18 deg/s to 60 deg",
)  # fmt: skip


@pytest.mark.parametrize(("at", "angle"), [("", 60.0), (" at 58.5 deg", 58.5)])
def test_an_order_to_level_a_block_works_for_a_turned_block(at: str, angle: float) -> None:
    """It holds the angle of the turn, or the one that is written; the block comes to where that is allowed."""
    level = f"block: level 0.3 m/min within 0.1 deg{at} with crane H3"
    made = scene("single-turn", *TURNED, "B hooks: hoist 1 m/min by 0.4 m", level, "wait: 1 s")
    assert lean(made, 4) == pytest.approx(60.1, abs=0.1), "the turn ends with plumb ropes, whose stretch is left"
    assert lean(made, 5) < 58.9
    away = 0.1 if angle > 58.87 else -0.1
    assert lean(made, 8) == pytest.approx(angle - away, abs=1e-3)


def lean(made: LoadedScene, action: int) -> float:
    """Of the block's height towards +y, in the rest in which an action ends [deg]."""
    w = [row[2] for row in next(s for s in reversed(made.statics.states) if s.action <= action).poses["block"][1]]
    return degrees(atan2(w[1], w[2]))


WEST = 16.0 / 12.0  # a spreader's end rises by so much of what its hook does, 4 m farther in; the other one sinks
FRONT, REAR = {"F1": (-10.0, 8.0), "F2": (10.0, 8.0)}, {"R1": (-4.0, -8.0), "R2": (4.0, -8.0)}
RISES = {
    "crane H1": {"F1": WEST, "F2": 1.0 - WEST, "R1": 0.0, "R2": 0.0},
    "crane H2": {"F1": 1.0 - WEST, "F2": WEST, "R1": 0.0, "R2": 0.0},
    "crane H3": {"F1": 0.0, "F2": 0.0, "R1": 1.0, "R2": 1.0},
}


@pytest.mark.parametrize(("hook", "verb"), [("crane H3", "hoist"), ("crane H1", "lower"), ("crane H2", "hoist")])
def test_an_order_to_level_a_block_works_through_a_spreader(hook: str, verb: str) -> None:
    """Along the way from what stays to what rises with it: by its lever on the spreader, or with its equalised pair."""
    up = ("all hooks: hoist 0.5 m/min until all slings taut", "all hooks: hoist 0.5 m/min until lifted")
    level, off = f"block: level 0.3 m/min within 0.1 deg with {hook}", f"{hook}: {verb} 1 m/min by 0.5 m"
    made = scene("spreader", *up, "all hooks: hoist 3 m/min by 2 m", off, level, "wait: 1 s")
    lugs, rises = {**FRONT, **REAR}, RISES[hook]
    own, others = (
        sum(np.array(lugs[x]) * w for x, w in part.items()) / sum(part.values())
        for part in (rises, {x: 1.0 - w for x, w in rises.items()})
    )
    before, after = (next(s for s in reversed(made.statics.states) if s.action <= n) for n in (4, 7))
    along = (own - others) / np.linalg.norm(own - others)
    tilts = [degrees(asin(np.dot(state.poses["block"][1][2][:2], along))) for state in (before, after)]
    assert abs(tilts[0]) > 1.0
    assert abs(tilts[1]) == pytest.approx(0.1, abs=3e-3), "less what the winch still runs as it stops"


def test_an_order_to_level_a_block_can_name_one_of_several_blocks() -> None:
    """Its own slings are what counts; the other one stands where it stood."""
    lugs = "lugs: {A: [-6 m, 0 m, 2 m], B: [6 m, 0 m, 2 m]}"
    supports = "supports: {height: 1 m, at: [[-6 m, -2 m], [6 m, -2 m], [-6 m, 2 m], [6 m, 2 m]]}"
    text = f"""\
heavylift: 1
name: two
blocks:
  first: {{mass: 60 t, size: [14 m, 5 m, 4 m], at: [0 m, 65 m, 3 m], {lugs}, {supports}}}
  second: {{mass: 80 t, size: [14 m, 5 m, 4 m], at: [0 m, 45 m, 3 m], {lugs}, {supports}}}
cranes: {{crane: {{type: twin-hook-600, upper: 45 m, lower: 20 m}}}}
rigging: {{legs: {{on: [crane H1, crane H2], to: [second.A, second.B], length: 5 m, sling: {{EA: 120 MN}}}}}}
actions:
  - {{crane H1: hoist 0.5 m/min until second lifted, crane H2: hoist 0.5 m/min until second lifted}}
  - crane H2: hoist 1 m/min by 1 m
  - NAME: level 0.3 m/min within 0.2 deg with crane H1
"""
    states = parse(text.replace("NAME", "second"), "scene.yaml", passing=True).statics.states
    tilts = [degrees(asin(x.poses["second"][1][2][0])) for x in states if x.action >= 2]
    assert max(tilts) > 3.0
    assert tilts[-1] == pytest.approx(0.2, abs=3e-3)
    with pytest.raises(SceneError, match="crane H1 cannot level the block: name hooks that hold it beside others"):
        parse(text.replace("NAME", "first"), passing=True)


@pytest.mark.parametrize("seed", range(20))
def test_an_order_to_level_a_block_measures_the_tilt_of_the_named_block(seed: int) -> None:
    """However the block is turned and slews, the places differ in height by the sine of its tilt."""
    rng = np.random.default_rng(seed)
    u, v, turned, slews, tilt = (*rng.uniform(2.0, 9.0, 2), *rng.uniform(-pi, pi, 2), rng.uniform(-0.3, 0.3))
    places = apart([((u, 1.0, 4.0), 1.0), ((u, 3.0, 5.0), 1.0), ((-2.0, -v, 4.0), 0.0)], turned)
    assert places
    R0 = np.array([[1, 0, 0], [0, cos(turned), sin(turned)], [0, -sin(turned), cos(turned)]])
    distance = np.subtract(*places)
    level = R0 @ distance
    assert level[2] == pytest.approx(0.0, abs=1e-12), "level at the angle of the turn"
    x, y, _ = level / np.linalg.norm(level)
    across, slewing = (np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]]) for c, s in ((x, y), (cos(slews), sin(slews))))
    tilted = across @ np.array([[cos(tilt), 0, -sin(tilt)], [0, 1, 0], [sin(tilt), 0, cos(tilt)]]) @ across.T @ R0
    assert (slewing @ tilted @ distance)[2] == pytest.approx(np.linalg.norm(distance) * sin(tilt), abs=1e-12)


@pytest.mark.parametrize(
    ("order", "told"),
    [
        ("block: level 0.3 m/min within 0.1 deg with crane H9", "crane H9 cannot level the block"),
        ("block: level 0.3 m/min with crane H3", "after the speed 'within' must follow"),
        ("block: level 0.3 m/min within 1 m with crane H3", "'1 m' is not a valid angle"),
        ("crane H3: level 1 m/min within 1 deg with crane H3", "'crane H3' cannot level"),
        ("crane: travel 10 m/min by 1 m together", "several drives or winches move together"),
        ("trolleys: traverse 10 m/min to 70 m together", "several drives or winches move together"),
        ("crane: travel 10 m/min to above [X9]", "the block has no lug 'X9'"),
        ("crane H1: hoist 10 m/min to above [P1]", "'above' is not a valid length"),
        ("crane: travel 10 m/min to above P1", "after 'above' '[' must follow"),
    ],
)
def test_an_invalid_order_to_level_a_block_is_reported(order: str, told: str) -> None:
    assert_refused("lift", order, told)


def test_an_order_to_move_above_lugs_out_of_reach_of_the_hook_is_reported() -> None:
    with pytest.raises(SceneError, match=r"jib\.luffer does not come above N2"):
        scene(
            "jib",
            "jib: luff 1 deg/s to above [N2]",
            more="block: {at: [18.5 m, 0 m, 2 m], lugs: {N2: [2.9 m, 1.5 m, 1.6 m]}}\n"
            "cranes: {jib: {boom: 19 m, radius: 18.5 m}}\n",
        )


# hold


def test_a_drive_that_holds_its_position_stops_before_its_brake_engages() -> None:
    """A cart that runs stops with its emergency deceleration; the brake closes when it stands."""
    text = """\
heavylift: 1
name: cart
end: 30 s
mechanism:
  bodies: {cart: {mass: 4 t}}
  joints: {rail: {type: prismatic, child: cart, axis: [1, 0, 0]}}
  drives: {motor: {joint: rail, type: prescribed, ramp: 0.1 m/s2, emergency: 0.5 m/s2}}
  brakes: {parking: {joint: rail, holds: 10 kN, stiffness: 1 MN/m, damping: 10 kN s/m}}
actions:
  - motor: drive 1 m/s by 20 m
  - {when: after 12 s, motor: hold}
  - wait: 1 s
"""
    made = parse(text, "scene.yaml", passing=True)
    assert [type(order).__name__ for action in made.plan.actions for order in action.orders] == [
        "Move", "StopOrder", "BrakeOrder", "Wait",
    ]  # fmt: skip
    last = made.statics.states[-1]
    assert last.coordinates["rail"] == pytest.approx(1.0 / (2 * 0.1) + 2.0 + 1.0 / (2 * 0.5), abs=1e-6)
    brake = next(acted.t for i, acted in enumerate(made.statics.acted) if i == 2)
    assert brake == pytest.approx(12.0 + 1.0 / 0.5, abs=1e-6)
