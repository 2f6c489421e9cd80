"""Slewing and luffing moments: weights and rope pulls about the joint axis, plus acceleration."""

from __future__ import annotations

from math import cos, radians
from pathlib import Path
from random import Random

import numpy as np
import pytest
from heavylift.kernel.description import NOT_CHECKED
from heavylift.nodes.limits import uses_on_path
from heavylift.nodes.scene import LoadedScene, bundled, load, parse
from heavylift.nodes.scene.text import library
from heavylift.nodes.statics import world

G = 9.80665
TURNING = sorted(name for name, file in library().items() if "verb: luff" in file.read_text(encoding="utf-8"))


def lifted(crane: str, radius: float, mass: float, **more: str) -> LoadedScene:
    """A block that hangs at rest from the hook of a crane of a type, at a radius [m], after a metre of slewing."""
    high = 3.0
    own = "".join(f", {key}: {value}" for key, value in more.items())
    return parse(
        "heavylift: 1\nname: held\n"
        f"block: {{mass: {mass} t, size: [2 m, 2 m, 2 m], at: [{radius} m, 0 m, {high - 1} m], "
        "lugs: {A: [0 m, 0 m, 1.1 m]}, "
        f"supports: {{height: {high - 2} m, at: [[-1 m, -1 m], [1 m, 0 m], [-1 m, 1 m]]}}}}\n"
        f"cranes: {{c: {{type: {crane}, radius: {radius} m{own}}}}}\n"
        "rigging: {leg: {on: c main, to: [A], length: 3 m, sling: {EA: 900 MN, breaking: 90 MN}}}\n"
        "actions: [{c main: hoist 1 m/min until lifted}, {c main: hoist 3 m/min by 0.3 m}]\n"
    )


MOMENTS = ("drive moment", "brake moment")


def moments(scene: LoadedScene) -> dict[tuple[str, str], float]:
    """Used of each drive and brake of a part: `its drive moves`, `its brake holds` [N m]."""
    uses = uses_on_path(scene.plan, scene.statics.states)
    rows = (u for u in uses if u.limit.quantity in MOMENTS)
    return {(u.limit.subject, u.limit.note): u.value or 0.0 for u in rows}


@pytest.mark.parametrize("crane", TURNING)
def test_the_luffing_drive_holds_the_moment_of_boom_and_load_about_the_boom_foot(crane: str) -> None:
    """M = (m_boom g L/2 cos + T r - T/n of the rope to the drum), on every type at random radii and loads."""
    r = Random(crane)
    for _ in range(3):
        plan = lifted(crane, 15.0, 3.0).plan
        hook = plan.machines[next(i for i, m in enumerate(plan.machines) if m.hooks)].hooks[0]
        near, far = hook.chart[0][0], hook.chart[-1][0]
        radius = r.uniform(near + 0.2 * (far - near), near + 0.8 * (far - near))
        most = next(mass for x, mass in hook.chart if x >= radius)
        scene = lifted(crane, radius, r.uniform(0.2, 0.7) * most / 1e3)
        machine = next(m for m in scene.plan.machines if m.hooks)
        state, bodies = scene.statics.states[-1], {b.name: b for b in machine.system.bodies}
        joint = next(j for j in machine.system.joints if j.child == "c.boom")
        foot = np.array(state.poses["c.upper"][0]) + np.array(state.poses["c.upper"][1]) @ np.array(joint.p_PJ)
        p, R = (np.array(x) for x in state.poses["c.boom"])
        rope = next(x for x in machine.system.ropes if x.name == "c.main")

        arm = p + R @ np.array(bodies["c.boom"].com) - foot
        total = np.cross(arm, [0.0, 0.0, -bodies["c.boom"].mass * G])[1]
        for line in rope.lines:
            a, b = (world(state, end.body, end.p) for end in (line.a, line.b))
            d = np.subtract(b, a)
            total += np.cross(np.subtract(a, foot), d / np.linalg.norm(d) * line.share * state.tensions["c.main"])[1]
        found = moments(scene)
        assert found["c boom", "its brake holds"] == pytest.approx(max(abs(total), 0.0), rel=0.02)
        ramp = max(x.accel for x in machine.actuators if x.verb == "luff")
        boom = bodies["c.boom"]
        inertia = boom.mass * float(arm @ arm) + boom.inertia[1][1]
        assert found["c boom", "its drive moves"] - found["c boom", "its brake holds"] == pytest.approx(
            ramp * inertia, rel=1e-6
        )
        assert found["c upper", "its brake holds"] < 1e-4 * abs(total), "nothing turns it while all hangs plumb"


@pytest.mark.parametrize("crane", TURNING)
def test_the_drives_of_each_crane_type_can_move_the_loads_of_its_chart(crane: str) -> None:
    plan = lifted(crane, 15.0, 3.0).plan
    chart = next(hook.chart for m in plan.machines for hook in m.hooks)
    block = next(hook.block_mass for m in plan.machines for hook in m.hooks)
    for radius, mass in (chart[1], chart[len(chart) // 2], chart[-2]):
        scene = lifted(crane, radius - 0.01, 0.9 * (mass - block) / 1e3)
        for u in uses_on_path(scene.plan, scene.statics.states):
            assert u.limit.quantity not in MOMENTS or not u.beyond, (crane, radius, u)


def test_the_slewing_drive_accelerates_everything_that_turns_with_it() -> None:
    """About the axis of slewing: I of upperworks, ballast and boom times the ramp; the boom's as of a thin rod."""
    scene = load("crawler", ["actions=[{crawler: slew 0.5 deg/s by 5 deg}]", "end=200 s"])
    machine = next(m for m in scene.plan.machines if m.hooks)
    found = {n: v for (s, n), v in moments(scene).items() if s == "crawler upper"}
    boom = next(b for b in machine.system.bodies if b.name == "crawler.boom")
    reach = 42.0 * cos(next(j.q0[0] for j in machine.system.joints if j.child == "crawler.boom"))
    inertia = boom.mass * ((1.5 + reach / 2) ** 2 + reach**2 / 12.0)
    inertia += 100e3 * (5.5**2 + (2.0**2 + 6.0**2) / 12.0) + 70e3 * (1.0 + (8.0**2 + 3.5**2) / 12.0)
    assert found["its drive moves"] - found["its brake holds"] == pytest.approx(radians(0.2) * inertia, rel=1e-2)


def test_a_too_weak_drive_gives_a_red_check_and_a_drive_without_data_is_reported_by_name(tmp_path: Path) -> None:
    text = library()["jib-60"].read_text(encoding="utf-8").replace("name: jib-60", "name: own")
    for force, state in (("force: 4 MN m, brake: 20 MN m", "red"), ("brake: 20 MN m", NOT_CHECKED)):
        assert "force: 17 MN m, brake: 20 MN m" in text
        own = text.replace("force: 17 MN m, brake: 20 MN m", force)
        (tmp_path / "own.yaml").write_text(own, encoding="utf-8")
        scene = parse(
            bundled()["jib"].read_text(encoding="utf-8").replace("type: jib-60", "type: own.yaml"),
            str(tmp_path / "jib.yaml"),
        )
        (row,) = (
            x for x in scene.checks if x.quantity == "drive moment" and x.subject == "jib boom"
        )  # fmt: skip
        assert state in (row.state, row.why), row
