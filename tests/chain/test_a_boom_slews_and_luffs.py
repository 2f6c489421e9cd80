"""Cranes made of parts by their type files: a boom that slews and luffs, a bridge crane in a hall."""

from __future__ import annotations

from math import acos, cos, hypot, pi, radians, sin, sqrt
from pathlib import Path

import numpy as np
import pytest
from chain import G
from heavylift.coordinator.run import run
from heavylift.kernel import SceneError
from heavylift.nodes.scene import LoadedScene, load, parse
from heavylift.recordings import Recording

FOOT, BOOM, RING, FALLS, DRUM = 2.0, 40.0, 20.0, 8, (-2.0, 3.0)  # of jib-60: lengths and where its drum is [m]
HOOK, MODULE, EA = 2e3, 20e3, FALLS * 28.1e6
ANGLE = acos((20.0 - FOOT) / BOOM)  # of the boom at the start
MOVE, STILL = ("through the hall", "still"), ("still", "down")  # stages of the hall
STOPPED = 2e-3  # what swings after ramps without swing, of 40 m [m]
REST = 1e-6  # of the exact rest
LINEAR = 2e-3  # of the linear theory of small swings


def jib(*actions: str, more: str = "") -> LoadedScene:
    """The bundled jib with another action list."""
    listed = "".join(f"  - {action}\n" for action in actions)
    return parse(f"extends: jib\nname: jib\n{more}actions:\n{listed}", "scene.yaml", passing=True)


def tip(angle: float) -> tuple[float, float]:
    """Radius and height of the boom's tip [m]."""
    return FOOT + BOOM * cos(angle), RING + 2.0 + BOOM * sin(angle)


def drum_way(angle: float) -> float:
    """From the tip to the drum [m]."""
    r, z = tip(angle)
    return hypot(r - DRUM[0], z - RING - DRUM[1])


def refused(*actions: str) -> str:
    with pytest.raises(SceneError) as error:
        jib(*actions)
    return str(error.value)


@pytest.mark.parametrize("way", [-25.0, -10.0, 8.0])
def test_luffing_moves_the_hook_by_the_change_of_rope_length_between_boom_tip_and_drum(way: float) -> None:
    """L0 (1 + T / EA) = falls below the tip + way to the drum / falls, whatever the angle."""
    scene = jib("legs: unhook", "jib main: hoist 10 m/min by 10 m", f"jib: luff 1 deg/s by {way} deg")
    first, last = scene.statics.states[0], scene.statics.states[-1]
    angle = ANGLE + radians(way)
    stretched = last.references["jib.main"] * (1.0 + HOOK * G / EA)
    r, z = tip(angle)
    assert last.poses["jib.main"][0] == pytest.approx((r, 0.0, z - (stretched - drum_way(angle) / FALLS)), abs=1e-6)
    assert first.references["jib.main"] - last.references["jib.main"] == pytest.approx(10.0)


def test_at_rest_the_hoist_rope_carries_the_weight_and_the_slings_share_it() -> None:
    scene = load("jib")
    hanging = next(s for s in scene.statics.states if s.stage == "slew" and not s.grounded)
    assert hanging.tensions["jib.main"] == pytest.approx((MODULE + HOOK) * G, rel=REST)
    length = 8.0
    for _ in range(5):  # stretched, the slings are steeper
        tension = MODULE * G / 4 * length / sqrt(length**2 - 2.5**2 - 1.5**2)
        length = 8.0 * (1.0 + tension / 60e6)
    for i in range(1, 5):
        assert hanging.tensions[f"legs.sling-{i}"] == pytest.approx(tension, rel=REST)


def test_slewing_leaves_the_residual_swing_given_by_duhamels_integral(tmp_path: Path) -> None:
    """w'' + w0^2 w = -s'' for small swings, s the path of the tip; what is left turns both ways."""
    rate, ramp, distance = radians(1.0), radians(0.2), radians(40.0)
    freed = ("legs: unhook", "jib main: hoist 10 m/min by 10 m")
    scene = jib(*freed, "jib: slew 1 deg/s by 40 deg", "wait: 60 s", more="samples: 20 Hz\n")
    run(scene, tmp_path / "jib.mcap", in_process=True)
    recording = Recording(tmp_path / "jib.mcap")
    angle = recording["joint/position/jib.slewing.angle"]
    begun = angle.t[np.flatnonzero(angle.values[:, 0] > 1e-12)[0]]
    pose = recording["pose/jib.main"]
    after = pose.t > begun + distance / rate + rate / ramp + 1.0
    R = tip(ANGLE)[0]
    swung = pose.values[after, :2] - R * np.array([cos(distance), sin(distance)])

    length = tip(ANGLE)[1] - float(np.mean(pose.values[after, 2])) + 1.0 + (2.0**2 + 1.0**2) / 12.0 / 20.0
    w0 = sqrt(G / length)  # the block swings about its ropes' ends: reduced to its centre of mass, 1 m below
    t = np.linspace(0.0, distance / rate + rate / ramp, 200_001)
    speed = np.minimum(np.minimum(ramp * t, rate), ramp * (t[-1] - t))
    phi = np.concatenate([[0.0], np.cumsum((speed[1:] + speed[:-1]) / 2 * np.diff(t))])
    pulled = np.gradient(1j * speed * R * np.exp(1j * phi), t)
    parts = [abs(np.trapezoid(pulled * np.exp(sign * 1j * w0 * t), t)) / (2 * w0) for sign in (1, -1)]
    far = np.hypot(*swung.T) * length / (length - 1.0)
    assert far.max() == pytest.approx(sum(parts), rel=LINEAR)
    assert far.min() == pytest.approx(abs(parts[0] - parts[1]), abs=LINEAR * far.max())


def test_a_radius_beyond_the_load_chart_is_refused_with_its_line_in_the_scene() -> None:
    """22 t hang on the hook, and 0.25 t of slings: 24 t may at 30 m, 20 t at 34 m, and between them 20 t."""
    up = ("jib main: hoist 1 m/min until all slings taut", "jib main: hoist 1 m/min until lifted")
    out = [degrees_at(r) for r in (29.9, 30.1)]
    allowed = jib(*up, "jib main: hoist 10 m/min by 25 m", f"jib: luff 1 deg/s to {out[0]!r} deg")
    assert not [f for f in allowed.findings if f.state == "red"]
    message = refused(*up, "jib main: hoist 10 m/min by 25 m", f"jib: luff 1 deg/s to {out[1]!r} deg")
    assert "scene.yaml:7:5: error" in message
    assert "hook load of jib.main would be 22.3 t, 111 %; 20.0 t is allowed" in message


def degrees_at(radius: float) -> float:
    return acos((radius - FOOT) / BOOM) * 180 / pi


@pytest.mark.parametrize(
    ("order", "told"),
    [
        ("jib: slew 5 deg/s by 10 deg", "'jib.slewer' can slew at 3 deg/s at most"),
        ("jib: travel 10 m/min by 1 m", "'jib' cannot travel"),
        ("jib luffer: slew 1 deg/s by 1 deg", "it can: luff, drive"),
        ("jib: slew 1 m/min by 1 m", "'1 m/min' is not a valid angular rate"),
        ("jib mian: hoist 1 m/min by 1 m", "did you mean 'jib main'?"),
        ("leg: unhook", "did you mean 'legs'?"),
        ("block: turn 1 deg/s to 30 deg", "'block' cannot turn"),
    ],
)
def test_orders_beyond_the_capability_of_a_crane_are_refused(order: str, told: str) -> None:
    assert told in refused(order)


def test_the_upper_limit_switch_stops_hoisting_with_its_own_stated_deceleration(tmp_path: Path) -> None:
    """The hook of the hall's crane comes to rest v^2 / 2a above the switch; orders have ramps of 0.1 m/s2."""
    text = "extends: hall\nname: hall\nactions: [{hall: hoist 5 m/min ramp 0.1 m/s2 until after 300 s}]\n"
    scene = parse(text.replace("[{hall", "[{legs: unhook}, {hall"), "scene.yaml", passing=True)
    run(scene, tmp_path / "hall.mcap", in_process=True)
    recording = Recording(tmp_path / "hall.mcap")
    z = recording["pose/hall.main"].values[-1, 2]
    assert z == pytest.approx(17.0 + (5 / 60) ** 2 / (2 * 0.5), abs=2e-3)


def test_a_hall_crane_carries_its_load_across_the_hall_without_residual_swing(tmp_path: Path) -> None:
    run(load("hall"), tmp_path / "hall.mcap", in_process=True)
    recording = Recording(tmp_path / "hall.mcap")
    begun = {name: t for t, name in recording.stages()}
    pose = recording["pose/block"]
    moves, still = ((pose.t > begun[a]) & (pose.t < begun[b]) for a, b in (MOVE, STILL))
    assert np.ptp(pose.values[moves, :2], axis=0) == pytest.approx([40.0, 12.0], abs=0.01)
    assert np.ptp(pose.values[still, :2], axis=0).max() < STOPPED
