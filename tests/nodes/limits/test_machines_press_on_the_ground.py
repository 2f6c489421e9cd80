"""Tracks, outriggers and wheels against closed forms, to 1e-9; and each bundled type against the sum of its weights."""

from __future__ import annotations

from functools import cache
from math import cos, radians, sin
from pathlib import Path

import numpy as np
import pytest
from heavylift.kernel import SceneError
from heavylift.kernel.description import Point, ScalarSignal, merge
from heavylift.kernel.model import FormulaContext, base_force, carried_group, scalar
from heavylift.nodes.limits import CORNERS, TRACKS, SignalColumns, place, read, signals_of
from heavylift.nodes.plan import Mechanism, Plan
from heavylift.nodes.scene import load, new_scene_with, parse
from heavylift.nodes.scene.text import library
from lifting import bare

EXACT = 1e-9
BASE = 7.2, 6.4  # length and width [m]


def pressed(kind: str, own: tuple[float, ...], V: float, x: float, y: float) -> float:
    """A signal of a base, of the given own numbers, under one weight V at x, y from its middle."""
    places = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [x, y, 3.0]]
    return float(scalar(ScalarSignal(kind), places, (1.0, 0.0, *BASE, *own, V), ()))  # type: ignore[arg-type]


def corners(V: float, x: float, y: float) -> dict[str, float]:
    return {name: pressed("corner load", (*corner, 1.0, 0.0), V, x, y) for name, corner in CORNERS.items()}


def tipping(x: float, y: float, *, lifts: bool) -> float:
    return pressed("tipping", (float(lifts),), 1e6, x, y)


def force_on_base(plan: Plan, machine: Mechanism, signals: SignalColumns) -> tuple[np.ndarray, ...]:
    """V [N] at x, y [m] from the middle of the base of a machine, at each instant."""
    assert machine.footing is not None
    system = merge((m.system for m in plan.machines), plan.gravity)
    x = ScalarSignal("tipping", point=Point(machine.footing.body, machine.footing.at))
    group = carried_group(x, system)
    places = [p.T for point in group.points if (p := place(signals, point)) is not None]
    tensions, lines = [signals.tensions[name] for name in group.ropes], [*map(len, group.ropes.values())]
    return base_force(FormulaContext(places, (1.0, 0.0, *group.numbers), tensions, lines), 2)


def test_each_of_four_outriggers_carries_a_quarter_of_the_weight_plus_the_share_of_the_moments() -> None:
    """V/4 +- Mx/(2b) +- My/(2a) of a rigid base on equal springs."""
    V, Mx, My = 800e3, 560e3, 480e3
    found = corners(V, My / V, Mx / V)
    for name, (along, across) in CORNERS.items():
        message = V / 4 + along * My / (2 * BASE[0]) + across * Mx / (2 * BASE[1])
        assert found[name] == pytest.approx(message, rel=EXACT)


@pytest.mark.parametrize("seed", range(40))
def test_if_one_outrigger_would_lift_off_the_other_three_carry_the_crane(seed: int) -> None:
    """Three supports follow from forces and moments alone, here by a linear system; none of them is pulled."""
    random = np.random.default_rng(seed)
    V, u, v = 1e6 * random.uniform(0.5, 2.0), random.uniform(-1, 1), random.uniform(-1, 1)
    if abs(u) + abs(v) <= 1.0:
        u, v = (np.sign(u) - u, np.sign(v) - v)  # the same place beyond the line on which one lifts
    x, y = u * BASE[0] / 2, v * BASE[1] / 2
    lifted = next(k for k, (a, b) in CORNERS.items() if a * u < 0 and b * v < 0)
    three = [k for k in CORNERS if k != lifted]
    rows = [[1.0] * 3, [CORNERS[k][0] * BASE[0] / 2 for k in three], [CORNERS[k][1] * BASE[1] / 2 for k in three]]
    message = dict(zip(three, np.linalg.solve(rows, [V, V * x, V * y]), strict=True))
    found = corners(V, x, y)
    assert found[lifted] == 0.0
    for name in three:
        assert found[name] == pytest.approx(message[name], rel=EXACT, abs=EXACT * V)


def test_a_resultant_force_outside_the_base_is_reported_as_tipping() -> None:
    assert tipping(3.6, 0.0, lifts=False) == pytest.approx(1.0, rel=EXACT)
    assert tipping(1.8, -1.6, lifts=False) == pytest.approx(0.5, rel=EXACT)
    assert tipping(1.8, -1.6, lifts=True) == pytest.approx(1.0, rel=EXACT)  # a corner is free
    assert min(corners(1e6, 1.8, -1.6).values()) == pytest.approx(0.0, abs=EXACT * 1e6)


@pytest.mark.parametrize("e", [0.0, 0.4, 7.2 / 6, 2.0, 3.0])
def test_ground_pressure_below_a_track_is_a_trapezoid_and_beyond_the_middle_third_a_triangle(e: float) -> None:
    """p = V/(b L) (1 + 6e/L) for e <= L/6, else 2V / (3 b (L/2 - e)); the load of a track by the lever."""
    V, y, (length, apart), breadth = 2.4e6, 0.9, BASE, 1.2
    for sign in TRACKS.values():
        own = V * (0.5 + sign * y / apart)
        message = own / (breadth * length) * (1 + 6 * e / length)
        if e > length / 6:
            message = 2 * own / (3 * breadth * (length / 2 - e))
        assert pressed("track pressure", (breadth, sign, 1.0, 0.0), V, -e, y) == pytest.approx(message, rel=EXACT)
    assert pressed("track pressure", (breadth, 1.0, 1.0, 0.0), V, 3.9, 0.0) == np.inf


@cache
def lift(crane: str, folder: str, setting: str = "") -> tuple[Plan, Mechanism, SignalColumns]:
    """A lift by a crane of a type, at rest along its list."""
    head = "name,mass [t],size x [m],size y [m],size z [m]\n"
    long, wide = (30, 24) if crane.startswith(("goliath", "twin", "mobile")) else (6, 5)
    (Path(folder) / "blocks.csv").write_text(f"{head}B,10,{long},{wide},4\n", encoding="utf-8")
    (text,) = new_scene_with("made", crane, "blocks.csv#B").values()
    scene = parse(text.replace(f"type: {crane}", f"type: {crane}{setting}"), str(Path(folder) / "made.yaml"))
    (machine,) = (m for m in scene.plan.machines if m.name == "crane")
    return scene.plan, machine, signals_of(scene.states)


@pytest.mark.parametrize("crane", sorted(library()))
def test_ground_pressure_of_every_crane_type_includes_its_own_weights_and_its_load(
    crane: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """V = g sum(m) and the place sum(m x) / sum(m), with the weight of block, rigging and hook blocks below the hooks:
    equal to all that is there, once it hangs free."""
    monkeypatch.chdir(tmp_path)
    plan, machine, signals = lift(crane, str(tmp_path))
    if machine.footing is None:
        assert [x.note for x in plan.limits if x.quantity == "ground pressure"] == ["it stands on a foundation"]
        return
    found = force_on_base(plan, machine, signals)
    bodies = {body.name: body for m in plan.machines for body in m.system.bodies if body.mass}
    free = [k for k in range(len(signals.t)) if "up" in signals.named[k]]
    assert free
    p0, R0 = (x[free[-1]] for x in signals.poses[machine.footing.body])
    middle = p0 + R0 @ np.array(machine.footing.at)
    mass, first = 0.0, np.zeros(3)
    for name, body in bodies.items():
        p, R = (x[free[-1]] for x in signals.poses[name])
        mass += body.mass
        first += body.mass * (p + R @ np.array(body.com))
    x, y, _ = R0.T @ (first / mass - middle)
    V, ex, ey = (column[free[-1]] for column in found)
    size = machine.footing.length + machine.footing.width
    assert pytest.approx(mass * plan.gravity, rel=1e-7) == V  # of the tensions of the path
    assert [ex, ey] == pytest.approx([x, y], abs=1e-6 * size)


def test_ground_pressure_of_a_slewing_crane_is_checked_at_the_most_loaded_corner() -> None:
    """A crawler's worst track: over 100 degrees of slewing the load passes the side, where its lever is longest."""
    scene = load("crawler")
    (machine,) = (m for m in scene.plan.machines if m.name == "crawler")
    path = signals_of(scene.states)
    found = force_on_base(scene.plan, machine, path)
    k = path.named.index("slew")
    V, x, y = (float(column[k]) for column in found)
    e = (x * x + y * y) ** 0.5
    use = next(u for u in scene.uses if (u.limit.quantity, u.limit.over) == ("ground pressure", "left"))
    footing = machine.footing
    assert footing is not None
    every = [e * f(radians(a)) for f in (cos, sin) for a in np.linspace(0.0, 100.0, 2001)]
    weigh = ScalarSignal("track pressure")
    most = [
        float(scalar(weigh, [[0, 0, 0], [1, 0, 0], [0, 1, 0], [x, y, 0]], (1, 0, 7.8, 7.2, 1.2, 1, 1, 0, V), ()))
        for x, y in zip(every[:2001], every[2001:], strict=True)
    ]
    assert use.stage == "slew"
    assert use.value == pytest.approx(max(most), rel=2e-3)  # it is looked at each 100 / 24 degrees
    assert read(scene.plan, use.limit, SignalColumns(path.t[-1:], {}, {})) is None
    assert max(most) > 1.05 * max(most[0], most[-1])


def test_mats_spread_the_load_and_add_their_weight() -> None:
    plain = {u.limit.over: u for u in load("crawler").uses if u.limit.quantity == "ground pressure"}
    laid = load("crawler", ["ground={bearing: 300 kPa, mats: {crawler: {area: 20 m2, mass: 6 t}}}"])
    for use in (u for u in laid.uses if u.limit.quantity == "ground pressure"):
        message = ((plain[use.limit.over].value or 0.0) * 1.2 * 7.8 + 6e3 * 9.80665) / 20.0
        assert use.value == pytest.approx(message, rel=EXACT)
        assert use.limit.value == 300e3
    with pytest.raises(SceneError, match=r"mats are not smaller than what stands on each of them, 9\.36 m2"):
        load("crawler", ["ground={mats: {crawler: {area: 9 m2}}}"])
    with pytest.raises(SceneError, match="'hall' stands on no tracks and no outriggers"):
        load("hall", ["ground={mats: {hall: {area: 9 m2}}}"])
    with pytest.raises(SceneError, match="there is no crane 'other'"):
        load("crawler", ["ground={mats: {other: {area: 9 m2}}}"])


def states(scene: str, quantity: str, *settings: str) -> set[str]:
    return {c.state for c in bare(scene, settings).checks if c.quantity == quantity}


def test_ground_pressure_is_green_only_if_the_bearing_capacity_of_the_ground_is_stated() -> None:
    assert states("crawler", "ground pressure") == {"amber"}
    message = next(c.sentence for c in bare("crawler").checks if c.quantity == "ground pressure")
    assert "write 'ground: {bearing: 200 kPa}'" in message
    assert states("crawler", "ground pressure", "ground={bearing: 500 kPa}") == {"green"}
    assert states("crawler", "ground pressure", "ground={bearing: 100 kPa}") == {"red"}
    assert states("hall", "wheel load") == {"green"}
    assert states("jib", "ground pressure") == {"none"}


WIND = "wind={speed: %s m/s, direction: [1, 0, 0]}"


@pytest.mark.parametrize(("scene", "most"), [("crawler", 12.0), ("jib", 20.0), ("hall", 20.0)])
def test_each_crane_type_has_its_own_wind_limit(scene: str, most: float) -> None:
    assert states(scene, "wind") == {"none"}
    assert states(scene, "wind", WIND % (most - 0.1)) == {"green"}
    assert states(scene, "wind", WIND % (most + 0.1)) == {"red"}
    assert states(scene, "wind", WIND % (most - 0.1), f"limits={{wind: {most - 1} m/s}}") == {"green", "red"}


@pytest.mark.parametrize(("crane", "charts"), [("crawler-250", 6), ("rough-terrain-59", 3)])
def test_no_load_that_a_bundled_load_chart_allows_tips_its_crane(crane: str, charts: int, tmp_path: Path) -> None:
    """Boom and chart of each, at each radius: the sum of moments about the edge of the base over 360 degrees."""
    kind = library()[crane].read_text(encoding="utf-8")
    text = f"heavylift: 1\nname: a\nend: 1 s\ncranes: {{a: {{type: {crane}%s}}}}\n"
    import yaml

    found = yaml.safe_load(kind)["hooks"]["main"]["capacity charts"]
    assert len(found) == charts
    for chart in found:
        set_up = "".join(f", {key}: {chart[key]}" for key in ("boom", "counterweight") if key in chart)
        for radius, most in chart["chart"]:
            plan = parse(text % f"{set_up}, radius: {radius}", str(tmp_path / "a.yaml"), passing=True).plan
            (machine,) = plan.machines
            footing, bodies = machine.footing, {b.name: b for b in machine.system.bodies}
            assert footing is not None
            boom, upper = bodies["a.boom"], bodies["a.upper"]
            r, load_ = float(radius.split()[0]), float(most.split()[0]) * 1e3
            foot = next(j for j in machine.system.joints if j.child == "a.boom").p_PJ[0]
            parts = [(boom.mass, foot + (r - foot) / 2), (upper.mass, upper.com[0]), (load_, r)]
            parts += [(b.mass, b.com[0]) for n, b in bodies.items() if n in ("a.ballast", "a.tracks", "a.carrier")]
            e = sum(m * x for m, x in parts) / sum(m for m, _ in parts)
            assert e < min(footing.length, footing.width) / 2, (chart, radius)
