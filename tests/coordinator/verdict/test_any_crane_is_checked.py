"""Cranes of all types are checked alike: by their own shapes, ropes, slings and loads, against closed forms."""

from __future__ import annotations

import json
from collections.abc import Callable
from functools import cache
from math import asin, atan2, degrees, hypot
from pathlib import Path
from typing import get_args

import pytest
from heavylift.coordinator.record import Played, play
from heavylift.kernel import SceneError
from heavylift.kernel.description import NOT_CHECKED
from heavylift.nodes.plan import Plan, Quantity, Shapes, carried_hooks, frames_on_hooks, is_root
from heavylift.nodes.scene import bundled, load, new_scene_with, parse
from heavylift.nodes.scene.text import library

STORED = Path(__file__).parents[2] / "data" / "checks_by_type.json"
G = 9.80665
STEEP = ["rigging.legs.length=3.9 m", "rigging.legs.slack=20 mm", "block.mass=30 t"]
UP_IN_HALL = 'actions: [{hall: "hoist 0.5 m/min until lifted"}, {hall: "hoist 3 m/min by 0.5 m"}]\n'
UP = 'actions=[{crawler main: "hoist 1 m/min until lifted"}, {crawler main: "hoist 6 m/min by 24 m"}]'


@cache
def played(name: str, *settings: str) -> Played:
    return play(load(name, list(settings)).plan)


def red(run: Played, kind: str) -> list[str]:
    return [f.sentence for f in run.verdict.findings if f.state == "red" and f.quantity == kind]


def test_a_block_that_is_hoisted_into_the_boom_is_reported_with_the_boom() -> None:
    """42 m of boom at a radius of 14 m: 24 m up, a block 6 m wide reaches 3 m towards it."""
    run = played("crawler", "block.mass=30 t", UP, "end=300 s")
    assert any(x.startswith("the block went") and "into crawler.boom" in x for x in red(run, "clearance"))
    near = next(c for c in run.verdict.clearances if (c.a, c.b) == ("block", "crawler.boom"))
    assert near.distance < -0.1
    assert not [c for c in played("crawler").verdict.clearances if c.distance < c.limit]


def test_the_angle_of_steep_bridle_slings_is_computed_and_gives_a_red_check() -> None:
    """Lugs at +-3 m and +-2 m from the middle, slings of 3.9 m: asin(3.606 / 3.9) but for stretch."""
    run = played("crawler", *STEEP, 'actions=[{crawler main: "hoist 1 m/min until lifted"}, {wait: 1 s}]')
    use = next(u for u in run.uses if u.limit.quantity == "bridle angle")
    assert degrees(use.value or 0.0) == pytest.approx(degrees(asin(hypot(3.0, 2.0) / 3.9)), abs=0.3)
    assert len(red(run, "bridle angle")) == 4


def test_a_load_hoisted_out_of_plumb_gives_a_red_check() -> None:
    """The hook hangs plumb at x = 14 m, the lugs lie 3 m aside: the rope leads there from the tip of the boom."""
    lugs = {f"N{i}": [f"{x} m", f"{y} m", "1.6 m"] for i, (x, y) in enumerate([(-3, 2), (3, 2), (-3, -2), (3, -2)], 1)}
    lateral = ["block.at=[17 m, 0 m, 2 m]", f"block.lugs={json.dumps(lugs)}", "block.mass=20 t"]
    lateral.append('actions=[{crawler main: "hoist 1 m/min until lifted"}, {wait: 1 s}]')
    use = next(u for u in load("crawler", lateral).uses if u.limit.quantity == "off-lead")
    tip = (42.0**2 - 12.5**2) ** 0.5 + 2.5  # its height [m]
    near, far = (degrees(atan2(x, tip - 3.6)) for x in (3.0, 6.0))  # to the middle of the lugs, and to the farther two
    assert near < degrees(use.value or 0.0) < far
    assert len(red(played("crawler", *lateral), "off-lead")) == 1


def test_two_cranes_that_share_a_load_are_derated() -> None:
    """By their charts over 1.20, or what the scene says, is the row of the pair."""
    crane = "{type: jib-60, at: [%s, 0 m, 0 m]}"
    text = (
        "heavylift: 1\nname: pair\nend: 1 s\n"
        "block: {mass: 20 t, size: [20 m, 4 m, 2 m], at: [20 m, 0 m, 2 m], lugs: {A: [-10 m, 0, 1.1 m], "
        "B: [10 m, 0, 1.1 m]}, supports: {height: 1 m, at: [[-8 m, 0], [8 m, 1 m], [8 m, -1 m]]}}\n"
        f"cranes: {{one: {crane % '-10 m'}, two: {crane % '10 m'}}}\n"
        "rigging: {a: {on: one main, to: [A], length: 20 m}, b: {on: two main, to: [B], length: 20 m}}\n"
        "actions: [{wait: 1 s}]\n"
    )
    for given, factor in (([], 1.20), (["factors={tandem: 1.5}"], 1.5)):
        limits = {(x.subject, x.quantity): x for x in parse(text, "pair.yaml", given).plan.limits}
        for hook in ("one.main", "two.main"):
            alone, pair = limits[hook, "hook load"], limits[hook, "tandem load"]
            assert pair.chart == tuple((radius, mass / factor) for radius, mass in alone.chart)
            assert "2 cranes lift together" in pair.note
            assert ("assumed" in pair.source) != bool(given)
    assert not [x for x in load("crawler").plan.limits if x.quantity == "tandem load"]


def test_unhooking_a_load_in_the_air_is_refused() -> None:
    up = '{crawler main: "hoist 1 m/min until lifted"}, {crawler main: "hoist 6 m/min by 2 m"}'
    with pytest.raises(SceneError, match="no taut sling is left: the block would fall"):
        load("crawler", [f"actions=[{up}, {{stage: let go, legs: unhook}}]"])


def test_unhooking_a_frame_from_its_load_in_the_air_is_refused() -> None:
    up = '{all hooks: "hoist 0.5 m/min until lifted"}, {all hooks: "hoist 3 m/min by 2 m"}'
    with pytest.raises(SceneError, match="no taut sling is left: the block would fall"):
        load("spreader", [f"actions=[{up}, {{stage: let go, front: unhook, rear: unhook}}]"])


def test_dragging_a_load_on_its_supports_is_refused() -> None:
    taut = '{hall main: "hoist 1 m/min until all slings taut"}, {hall main: "hoist 0.1 m/min by 2 mm"}'
    message = r"hall would traverse while the block is on its supports and legs\.sling-\d taut"
    with pytest.raises(SceneError, match=message):
        load("hall", [f'actions=[{taut}, {{hall: "traverse 5 m/min by 1 m"}}]'])


WALL = "obstacles={{wall: {{box: [1 m, 30 m, 30 m], at: [{:g} m, 20 m, 15 m]}}}}"


@pytest.mark.parametrize("gap", [0.2, 0.8])
def test_a_load_that_comes_near_an_obstacle_is_reported(gap: float) -> None:
    """A block 6 m long about x = -20 m ends at -17 m, a wall 1 m thick begins so far from it."""
    run = played("hall", WALL.format(-17.0 + gap + 0.5), 'actions=[{hall: "hoist 1 m/min until lifted"}]')
    found = next(c for c in run.verdict.clearances if (c.a, c.b) == ("block", "wall"))
    assert found.distance == pytest.approx(gap, abs=0.05)
    assert bool(red(run, "clearance")) == (gap < 0.5)


def test_an_obstacle_that_overlaps_a_block_at_the_start_is_refused() -> None:
    with pytest.raises(SceneError, match=r"obstacles\.wall: 'block' begins 0\.3 m inside of 'wall'"):
        load("hall", [WALL.format(-16.8)])


def _drives(plan: Plan, kind: str, axis: tuple[float, float, float] | None = None, *, ends: bool = False) -> bool:
    """Whether a drive moves a joint of a kind, along an axis, between ends."""
    known = {a.name: a for machine in plan.machines for a in machine.actuators}
    joints = {j.name: j for machine in plan.machines for j in machine.system.joints}
    found = [(joints[d.joint], known[d.name]) for m in plan.machines for d in m.system.drives if d.name in known]
    return any(j.kind == kind and axis in (None, j.axis) and (a.upper is not None or not ends) for j, a in found)


def _footing(plan: Plan) -> str:
    return next((m.footing.kind for m in plan.machines if m.footing), "foundation")


def _hung(plan: Plan) -> list[int]:
    """How many hooks each body carries that is itself carried."""
    bodies = ((m, b.name) for m in plan.machines for b in m.system.bodies if m.hooks and not is_root(m, b.name))
    return [len(carried_hooks(m, body)) for m, body in bodies]


ALONG, ACROSS = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0)
OF_THE_SCENE = "the scene has none"
NONE: dict[str, tuple[str, Callable[[Plan], bool]]] = {  # why a check has no row, and whether that is so
    "trolley load": ("no part carries several hooks", lambda plan: max(_hung(plan), default=0) < 2),
    "crane load": ("it has one hook", lambda plan: [len(m.hooks) for m in plan.machines if m.hooks] == [1]),
    "tandem load": ("one crane lifts", lambda plan: sum(bool(m.hooks) for m in plan.machines) == 1),
    "loader load": ("no frame hangs on a hook", lambda plan: not frames_on_hooks(plan.machines)),
    "frame load": (OF_THE_SCENE, lambda plan: True),
    "assembly load": ("its legs are rated singly", lambda plan: True),
    "sharing": ("its legs are rated singly", lambda plan: True),
    "heavy sling": (OF_THE_SCENE, lambda plan: True),
    "inputs": (OF_THE_SCENE, lambda plan: True),
    "factor": (OF_THE_SCENE, lambda plan: True),
    "signal": (OF_THE_SCENE, lambda plan: True),
    **dict.fromkeys(("relative heave", "slack sling", "splash load"), (OF_THE_SCENE, lambda plan: True)),
    "off-lead": ("along and across have limits of their own", lambda plan: True),
    "off-lead in wind": (OF_THE_SCENE, lambda plan: True),
    **{f"off-lead {way}": ("one limit holds in any direction", lambda plan: True) for way in ("along", "across")},
    "side force": ("nothing slides", lambda plan: not _drives(plan, "prismatic")),
    "drive moment": ("nothing turns", lambda plan: not _drives(plan, "revolute")),
    "brake moment": ("nothing turns", lambda plan: not _drives(plan, "revolute")),
    "rails": ("nothing slides along x between ends", lambda plan: not _drives(plan, "prismatic", ALONG, ends=True)),
    "girder": ("nothing slides along y between ends", lambda plan: not _drives(plan, "prismatic", ACROSS, ends=True)),
    "hook height": ("the shortest rope is its end", lambda plan: not any(
        a.highest for m in plan.machines for a in m.actuators
    )),
    "interlock": ("its type has none", lambda plan: not plan.interlocks),
    "ground pressure": ("it stands on wheels", lambda plan: _footing(plan) == "wheels"),
    "wheel load": ("it stands on no wheels", lambda plan: _footing(plan) != "wheels"),
    "uplift": ("it stands on a foundation", lambda plan: _footing(plan) == "foundation"),
}  # fmt: skip


def checks(crane: str, folder: Path) -> dict[str, str]:
    """Of a lift by a crane of a type: each quantity of limits with the source of its value, or why there is none; and
    what no clearance is known of."""
    head = "name,mass [t],size x [m],size y [m],size z [m]\n"
    long, wide = (30, 24) if crane.startswith(("goliath", "twin", "mobile")) else (6, 5)
    (folder / "blocks.csv").write_text(f"{head}B,10,{long},{wide},4\n", encoding="utf-8")
    (text,) = new_scene_with("made", crane, "blocks.csv#B").values()
    scene = parse(text, str(folder / "made.yaml"))
    plan = scene.plan
    found = {x.quantity: f"by {x.source}" for x in plan.limits if x.known}
    missing: dict[str, list[str]] = {}
    for c in scene.checks:
        if c.why == NOT_CHECKED and c.basis and c.basis not in missing.setdefault(c.quantity, []):
            missing[c.quantity].append(c.basis)
    found |= {quantity: f"not checked; {', '.join(message)}" for quantity, message in missing.items()}
    found |= {c.quantity: "cannot occur" for c in scene.checks if c.state == "none" and not c.why}
    for quantity in (quantity for quantity in get_args(Quantity) if quantity not in found):
        why, holds = NONE[quantity]
        assert holds(plan), f"{crane} has no row of {quantity}, though not {why}"
        found[quantity] = f"cannot occur: {why}"
    return (
        found
        | {f"clearance of {x.thing}": "judged" for x in Shapes(plan).solids}
        | dict.fromkeys(Shapes(plan).not_modelled, "not modelled")
    )


def test_each_check_of_each_crane_type_has_a_value_or_is_listed_as_not_checked(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The matrix of bundled types and checks; what a change adds or takes away is seen in its file."""
    monkeypatch.chdir(tmp_path)
    found = {crane: checks(crane, tmp_path) for crane in sorted(library())}
    assert found == json.loads(STORED.read_text(encoding="utf-8"))
    for crane, own in found.items():
        assert {"hook load", "sling tension", "sling peak", "bridle angle", "clearance"} <= own.keys(), crane
        assert {x.split()[0] for x in own if x.startswith("off-lead")}, crane


def test_drives_brakes_and_drum_pull_of_a_crane_type_are_checked(tmp_path: Path) -> None:
    """A pick 0.5 m aside, which the ropes lead to: T d / |d| along x, on the drive and on its brake."""
    text = library()["overhead-100"].read_text(encoding="utf-8").replace("overhead-100", "own")
    text = text.replace("force: 40 kN, brake: 60 kN", "force: 8 kN, brake: 80 kN")
    assert "drum pull: 105 kN" in text
    text = text.replace("drum pull: 105 kN", "drum pull: 90 kN")
    (tmp_path / "own.yaml").write_text(text, encoding="utf-8")
    scene = bundled()["hall"].read_text(encoding="utf-8").replace("overhead-100, at: -20 m", "own.yaml, at: -20.5 m")
    run = play(parse(scene[: scene.index("actions:")] + UP_IN_HALL, str(tmp_path / "hall.yaml")).plan)
    uses = {(u.limit.quantity, u.limit.subject, u.limit.note.partition(",")[0]): u for u in run.uses}
    drive, brake = (uses["side force", "hall", f"its {what}"] for what in ("drive moves", "brake holds"))
    assert drive.value == brake.value
    assert 8e3 < (drive.value or 0.0) < 80e3
    assert [f.subject for f in run.verdict.findings if f.quantity == "side force"] == ["hall"]
    pull = uses["drum pull", "hall.main", "12 falls"]
    assert (80e3 + 2.5e3) * G / 12 < (pull.value or 0.0) < 1.2 * (80e3 + 2.5e3) * G / 12
    rails, girder = (next(u for u in run.uses if u.limit.quantity == x) for x in ("rails", "girder"))
    assert (rails.value, girder.value) == (pytest.approx(-20.5), pytest.approx(8.0))
