"""Every crane type of the library lifts a block; where its numbers are published, they are those of the publication."""

from __future__ import annotations

from math import acos, cos, degrees, radians

import pytest
from heavylift.kernel import SceneError
from heavylift.nodes.scene import LoadedScene, load, parse
from heavylift.nodes.scene.keys.parts import HookKeys
from heavylift.nodes.scene.text import library, machine_type
from lifting import cranes

FOOT, POUND = 0.3048, 0.45359237
ANGLES = {  # [deg] of the boom at radii of the chart [ft], by boom length [ft]; Terex, RT665
    36: dict(zip((10, 12, 15, 20, 25, 30), (67.1, 63.6, 57.5, 48.0, 35.9, 18.0), strict=True)),
    51: dict(
        zip((10, 12, 15, 20, 25, 30, 35, 40, 45), (74.1, 71.8, 68.1, 61.9, 55.3, 48, 39.9, 29.9, 15), strict=True)
    ),
    66: dict(
        zip((15, 20, 25, 30, 35, 40, 50, 55, 60), (73.3, 68.7, 63.9, 58.9, 53.7, 48, 34.8, 26.2, 13.2), strict=True)
    ),
}
LOADS = {  # [lb] over 360 degrees
    36: {10: 130_000, 12: 106_800, 15: 85_900, 20: 62_100, 25: 47_700, 30: 37_800},
    51: {10: 80_100, 12: 80_100, 15: 78_500, 20: 63_400, 25: 48_900, 30: 39_200, 35: 32_300, 40: 27_000, 45: 21_400},
    66: {15: 62_000, 20: 54_900, 25: 49_200, 30: 39_900, 35: 33_000, 40: 27_500, 50: 18_300, 55: 15_200, 60: 12_700},
}
READ = 0.35 * FOOT  # [m] that angles in tenths of a degree and a boom's own sag leave of a radius
BLOCK = """\
heavylift: 1
name: lifted
block:
  mass: {mass} t
  size: [3 m, 2 m, 2 m]
  at: [{x} m, {y} m, 1.5 m]
  lugs: {{A: [-1 m, 0.5 m, 1 m], B: [1 m, 0.5 m, 1 m], C: [-1 m, -0.5 m, 1 m], D: [1 m, -0.5 m, 1 m]}}
  supports: {{height: 0.5 m, at: [[-1 m, -0.5 m], [1 m, -0.5 m], [-1 m, 0.5 m], [1 m, 0.5 m]]}}
cranes: {{crane: {{type: {type}{more}}}}}
rigging: {{legs: {{on: crane main, to: [A, B, C, D], length: 4 m, sling: {{EA: 60 MN, breaking: 1500 kN}}}}}}
actions:
  - crane main: hoist 1 m/min until all slings taut
  - crane main: hoist 1 m/min until lifted
  - crane main: hoist 5 m/min by 1 m
"""
LIFTS = {  # of each type: mass of the block [t], where it stands, what the crane is besides
    "crawler-250": (60, 14, 0, ", radius: 14 m"),
    "jib-60": (30, 16, 0, ", radius: 16 m"),
    "pedestal-400": (110, 27, 0, ", radius: 27 m"),
    "overhead-100": (95, 5, 12, ", at: 5 m, trolley: 12 m"),
    "rough-terrain-59": (15, 9, 0, ", radius: 9 m"),
}


def lift(name: str, mass: float | None = None, more: str = "", near: bool = False) -> LoadedScene:
    own, x, y, place = LIFTS[name] if not near else (5.0, 6, 0, ", radius: 6 m")
    return parse(BLOCK.format(mass=mass or own, x=x, y=y, type=name, more=place + more), "scene.yaml", passing=True)


@pytest.mark.parametrize("name", LIFTS)
def test_a_machine_written_part_by_part_lifts_a_block(name: str) -> None:
    scene = lift(name)
    last = scene.statics.states[-1]
    dead = next(hook.block_mass for machine in scene.plan.machines for hook in machine.hooks)
    assert not last.grounded
    assert last.tensions["crane.main"] == pytest.approx((LIFTS[name][0] * 1e3 + dead) * scene.plan.gravity, rel=1e-6)
    assert scene.statics.known


def test_every_bundled_crane_type_lifts_a_block_in_some_test() -> None:
    others = {"goliath-840", "goliath-900", "goliath-1200", "goliath-1600", "mobile-gantry-600", "twin-hook-600"}
    assert {*LIFTS, *others} == {*library()}


@pytest.mark.parametrize(
    ("name", "span", "girder", "main", "load"),
    [("goliath-1200", 154.0, 2500e3, 3740e3, 1000), ("goliath-1600", 180.0, 3400e3, 5400e3, 1400)],
)
def test_larger_goliaths_lift_nearly_their_rated_load(
    name: str, span: float, girder: float, main: float, load: float
) -> None:
    """1000 t and 1400 t on their hooks; of goliath-1200 span, girder and legs are published: 2500 + 540 + 700 t."""
    scene = parse(
        "extends: lift\nname: lift\nblock:\n"
        f"  mass: {load} t\n  size: [24 m, 16 m, 8 m]\n  supports: {{capacity: 400 t}}\n  lug capacity: 600 t\n"
        "  lugs: {P1: [-9 m, -6 m, 4.3 m], P2: [-5 m, -6 m, 4.3 m], Q1: [5 m, -6 m, 4.3 m], Q2: [9 m, -6 m, 4.3 m]}\n"
        f"cranes: {{crane: {{type: {name}}}}}\n"
        "rig:\n  sling: {breaking: 20 MN}\n  shackle: 600 t\n"
        "  loaders: {loader-1: {capacity: 900 t}, loader-2: {capacity: 900 t}, loader-3: {capacity: 900 t}}\n",
        "scene.yaml",
        passing=True,
    )
    (crane,) = cranes(scene.plan)
    body = next(body for body in crane.system.bodies if body.name == "crane.main")
    assert (2 * body.com[1], crane.girders[0].mass, body.mass) == (span, girder, main)
    assert crane.actuators[0].emergency == 0.3
    lifted = next(s for s in scene.statics.states if s.stage == "up")
    hooks = sum(lifted.tensions[hook.rope] for hook in crane.hooks) / scene.plan.gravity
    assert hooks == pytest.approx(load * 1e3 + 3 * (crane.hooks[0].block_mass + 20e3), rel=1e-4)


def test_a_mobile_gantry_lifts_a_load_and_drives_off() -> None:
    hooks = ("front-left", "front-right", "rear-left", "rear-right")
    lugs = {"front-left": (8, 4), "front-right": (8, -4), "rear-left": (-8, 4), "rear-right": (-8, -4)}
    scene = parse(
        "heavylift: 1\nname: hull\nblock:\n  mass: 480 t\n  size: [30 m, 9 m, 5 m]\n  at: [0 m, 0 m, 3.5 m]\n"
        f"  lugs: {{{', '.join(f'{h}: [{x} m, {y} m, 2.6 m]' for h, (x, y) in lugs.items())}}}\n"
        "  supports: {height: 1 m, at: [[-9 m, -3 m], [9 m, -3 m], [-9 m, 3 m], [9 m, 3 m]]}\n"
        "cranes: {lift: {type: mobile-gantry-600}}\nrigging:\n"
        + "".join(f"  s-{h}: {{on: lift {h}, to: [{h}], length: 3 m, slack: 0.1 m}}\n" for h in hooks)
        + "actions:\n  - all hooks: hoist 1 m/min until all slings taut\n  - all hooks: hoist 1 m/min until lifted\n"
        "  - all hooks: hoist 1 m/min by 0.5 m\n  - lift: travel 30 m/min by 40 m\n",
        "scene.yaml",
        passing=True,
    )
    last = scene.statics.states[-1]
    assert scene.statics.known
    assert last.poses["block"][0][0] == pytest.approx(40.0, abs=1e-3)
    for hook in hooks:
        assert last.tensions[f"lift.{hook}"] == pytest.approx((120e3 + 3e3) * scene.plan.gravity, rel=1e-3)


def test_a_goliath_crane_with_the_size_of_the_belfast_cranes_lifts_its_load() -> None:
    scene = load("lift", ["cranes.crane.type=goliath-840", "cranes.crane.upper trolley=69 m"])
    (crane,) = cranes(scene.plan)
    whole = next(cell for cell in crane.cells if cell.body == "crane.main")
    message = crane.girders[0].span, whole.capacity, crane.actuators[-1].highest
    assert message == (140.0, 840e3, 70.0)
    assert crane.girders[0].stiffness == pytest.approx(1000e3 * scene.plan.gravity / 0.3, rel=1e-3)
    lifted = next(s for s in scene.statics.states if s.stage == "up")
    assert sum(lifted.tensions[hook.rope] for hook in crane.hooks) > 300e3 * scene.plan.gravity


def rough_terrain(boom_ft: int) -> HookKeys:
    """The hook of the crane with a boom of this length, as the type makes it."""
    return with_boom(boom_ft * FOOT)


def with_boom(boom: float) -> HookKeys:
    scene = lift("rough-terrain-59", 5, f", boom: {boom!r} m", near=True)
    return scene.scene.machines["crane"].hooks["crane.main"]


@pytest.mark.parametrize("boom", LOADS)
def test_rated_loads_of_a_crawler_crane_are_those_of_its_maker_rounded_down(boom: int) -> None:
    chart = rough_terrain(boom).chart
    assert chart is not None
    assert [radius / FOOT for radius, _ in chart] == pytest.approx(list(LOADS[boom]), rel=1e-12)
    for (_, may), pounds in zip(chart, LOADS[boom].values(), strict=True):
        assert 0.0 <= pounds * POUND - may < 10.0


@pytest.mark.parametrize("boom", ANGLES)
def test_boom_angles_of_the_load_chart_give_the_radii_of_the_load_chart(boom: int) -> None:
    foot = machine_type("rough-terrain-59").data["joints"]["luffing"]["at"][0]  # type: ignore[index, call-overload]
    behind = -float(str(foot).removesuffix(" m"))
    for radius, angle in ANGLES[boom].items():
        assert boom * FOOT * cos(radians(angle)) - behind == pytest.approx(radius * FOOT, abs=READ)


@pytest.mark.parametrize(("boom", "found"), [(10.0, 10.9728), (11.0, 15.5448), (15.5448, 15.5448), (15.6, 20.1168)])
def test_for_a_boom_length_between_two_load_charts_the_chart_of_the_longer_boom_applies(
    boom: float, found: float
) -> None:
    hook = with_boom(boom)
    assert hook.chart == next(x.chart for x in hook.capacity_charts if x.boom == found)


def test_loads_beyond_all_load_charts_are_refused() -> None:
    with pytest.raises(SceneError, match="no chart for this boom length"):
        lift("rough-terrain-59", 5, ", boom: 24 m")
    with pytest.raises(SceneError, match=r"would be 19\.5 t, 108 %; 18\.1 t is allowed"):
        lift("rough-terrain-59", 19)
    assert degrees(acos((9.0 + 4 * FOOT) / (66 * FOOT))) == pytest.approx(59.47, abs=0.01)  # at 9 m: 30 ft counts


GAUGE, SHARE = 7.2, 0.75  # of crawler-250: between the edges that it tips over [m], of what tips it


@pytest.mark.parametrize("counterweight", [60e3, 100e3])
@pytest.mark.parametrize("boom", [24.0, 42.0, 60.0])
def test_the_crawler_chart_is_three_quarters_of_the_tipping_load(boom: float, counterweight: float) -> None:
    """Moments about the edge of a track: tracks, upperworks and counterweight against the boom and the load."""
    scene = lift("crawler-250", 9, f", boom: {boom:g} m, counterweight: {counterweight / 1e3:g} t")
    machine = scene.scene.machines["crane"]
    bodies = {name.removeprefix("crane."): body for name, body in machine.bodies.items()}
    edge, foot = GAUGE / 2, machine.joints["crane.luffing"].at[0]  # type: ignore[union-attr]
    holds = sum((bodies[x].mass or 0.0) * (edge - bodies[x].com[0]) for x in ("tracks", "upper", "ballast"))
    chart = machine.hooks["crane.main"].chart
    assert chart is not None
    for radius, may in chart:
        tips = (holds - (bodies["boom"].mass or 0.0) * ((foot + radius) / 2 - edge)) / (radius - edge)
        assert 0.0 <= min(SHARE * tips, 250e3) - may < 500.0 + 1e-6
