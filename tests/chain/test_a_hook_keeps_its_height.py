"""Level luffing: a winch that holds the height of its hook as its boom luffs, by the law of tip and drum."""

from __future__ import annotations

from math import cos, hypot, radians, sin
from pathlib import Path

import numpy as np
import pytest
from heavylift.coordinator.run import run
from heavylift.kernel.islands import islands_of
from heavylift.nodes.models import system
from heavylift.nodes.scene import LoadedScene, load, parse
from heavylift.nodes.scene.construction import follow
from heavylift.recordings import Recording
from scenes_with_orders import assert_refused, scene

UP = tuple(f"jib main: hoist {x}" for x in ("1 m/min until all slings taut", "1 m/min until lifted", "10 m/min by 5 m"))
STRETCH = 20e3 + 2e3, 8 * 28.1e6  # mass on the rope of jib-60 [kg], its stiffness [N]
FIT = 1e-4  # [m] of the law


def rests(made: LoadedScene, hook: str) -> dict[int, tuple[float, float]]:
    """Height of a hook and unstretched length of its rope [m], in the rest in which each action ends."""
    assert not made.statics.why
    return {s.action: (s.poses[hook][0][2], s.references[hook]) for s in made.statics.states}


def test_except_for_rope_stretch_the_hook_keeps_its_height_while_its_boom_luffs() -> None:
    """The tip comes down by 5.2 m; what the winch takes in lacks only its stretch."""
    made = scene(
        "jib", *UP, "{jib: luff 0.3 deg/s to 49.46 deg, jib main: hold height}", "jib main: lower 5 m/min by 1 m"
    )
    at = rests(made, "jib.main")
    (before, long), (after, short), (down, _) = at[3], at[4], at[5]
    strain = STRETCH[0] * 9.80665 / STRETCH[1]
    assert long - short > 5.0
    assert after - before == pytest.approx(strain * (long - short), abs=FIT)
    assert after - down == pytest.approx(1.0 + strain, abs=FIT), "it obeys again"


@pytest.mark.parametrize(("base", "machine", "boom", "foot", "drum", "falls"), [
    ("jib", "jib", 40.0, (2.0, 2.0), (-2.0, 3.0), 8),
    ("crawler", "crawler", 42.0, (1.5, 0.7), (-1.0, 2.0), 16),
])  # fmt: skip
def test_the_rope_speed_of_height_compensation_follows_the_geometry_of_boom_tip_and_drum(
    base: str, machine: str, boom: float, foot: tuple[float, float], drum: tuple[float, float], falls: int
) -> None:
    """Over the whole range of a boom, by the plane geometry of its type file."""
    text = f"actions: [{{{machine}: luff 0.3 deg/s by -3 deg, {machine} main: hold height}}]\n"
    plan = parse(f"extends: {base}\nname: made\n{text}", "scene.yaml", passing=True).plan
    (move,) = plan.actions[0].orders
    (kept,) = move.keeps
    k1, kc, ks = kept.law
    actuator = next(x for m in plan.machines for x in m.actuators if x.name == f"{machine}.luffer")
    off = []
    for s in np.linspace(actuator.lower, actuator.upper, 50):
        x, z = foot[0] + boom * cos(s), foot[1] + boom * sin(s)
        off.append(z + hypot(x - drum[0], z - drum[1]) / falls - (k1 * s + kc * cos(s) + ks * sin(s)))
    assert np.ptp(off) < 2 * FIT


def test_a_luffing_move_stopped_halfway_leaves_the_hook_at_the_same_height() -> None:
    """Winch and boom stop together, and the next order to either is obeyed."""
    luff = "{jib: luff 0.3 deg/s to 49.46 deg, jib main: hold height}"
    stop = "{when: after 20 s, jib: stop}"
    made = scene("jib", *UP, luff, stop, "wait: 10 s", "jib: luff 0.3 deg/s by 1 deg", "jib main: hoist 5 m/min by 1 m")
    at = rests(made, "jib.main")
    assert at[6][0] == pytest.approx(at[3][0], abs=3e-3)
    assert at[3][1] - at[6][1] > 1.5, "of some twenty seconds"
    rise = 40.0 * (sin(radians(58.26)) - sin(radians(57.26)))
    assert at[7][0] - at[6][0] == pytest.approx(rise, rel=0.1), "it follows no more"
    assert at[8][0] - at[7][0] == pytest.approx(1.0, abs=2e-3)


def test_luffing_stopped_by_a_load_chart_interlock_keeps_the_hook_height(tmp_path: Path) -> None:
    """The load moment limiter stops the boom; the winch has followed to there, and lowers afterwards."""
    more = "block: {at: [17 m, 0 m, 2 m]}\ncranes: {crawler: {radius: 17 m}}\nsamples: 5 Hz\n"
    made = scene(
        "crawler", "crawler main: hoist 1 m/min until lifted", "crawler main: hoist 4 m/min by 1 m",
        "{crawler: luff 0.3 deg/s by -3 deg, crawler main: hold height}",
        "{when: luff stopped, crawler main: lower 1 m/min by 0.5 m}", more=more,
    )  # fmt: skip
    run(made, tmp_path / "run.mcap", in_process=True)
    rec = Recording(tmp_path / "run.mcap")
    (trip, *_) = [e.t_ns * 1e-9 for e in rec.events() if e.type == "Tripped"]
    pose, boom = rec["pose/crawler.main"], rec["joint/position/crawler.luffing.angle"]
    start = next(a for a, (q, *_) in zip(boom.t, boom.values[1:], strict=False) if abs(q - boom.values[0, 0]) > 1e-6)
    z = [float(np.interp(t, pose.t, pose.values[:, 2])) for t in (start, trip, pose.t[-1])]
    assert z[1] == pytest.approx(z[0], abs=0.02), "beside what the load swings"
    assert z[0] - z[2] == pytest.approx(0.5, abs=0.02)


def test_each_instance_of_a_crane_type_keeps_its_own_hook_height_during_luffing(tmp_path: Path) -> None:
    """Each winch follows the boom of its own crane; nothing ties the lifts, which stay islands."""
    (tmp_path / "one.yaml").write_text(
        "extends: jib\nname: one\nactions: [{jib: luff 0.3 deg/s by -3 deg, jib main: hold height}]\n"
    )
    (tmp_path / "two.yaml").write_text(
        "heavylift: 1\nname: two\nlifts: {a: {extends: one.yaml}, b: {extends: one.yaml, at: [0 m, 99 m]}}\n"
    )
    plan = load(tmp_path / "two.yaml").plan
    assert [x.master for action in plan.actions for move in action.orders for x in move.keeps] == [
        "a-jib.luffing.angle", "b-jib.luffing.angle"
    ]  # fmt: skip
    assert [(x.name, x.followers) for m in plan.machines for x in m.system.measured] == [
        ("a-jib.luffing.angle", ("a-jib.main",)), ("b-jib.luffing.angle", ("b-jib.main",))
    ]  # fmt: skip
    assert len(islands_of(system(plan))) == 2


@pytest.mark.parametrize(
    ("order", "told"),
    [
        ("jib main: hold height", "'jib.main' holds its height while its boom luffs: let it luff in the same action"),
        ("{jib: slew 1 deg/s by 3 deg, jib main: hold height}", "let it luff in the same action"),
        ("{jib: luff 1 deg/s by 3 deg, jib main: hold high}", "nothing can follow 'hold': remove 'high'"),
    ],
)
def test_an_invalid_order_to_hold_a_hook_height_is_reported(order: str, told: str) -> None:
    assert_refused("jib", order, told)


def test_an_order_to_hold_the_height_of_a_hook_on_another_boom_is_refused() -> None:
    plan = load("jib").plan
    move = next(x for action in plan.actions for x in action.orders if x.verb == "slew")
    assert follow(plan.machines, move, "jib.main", "") == "'jib.main' does not hang from what 'jib.slewer' luffs"
