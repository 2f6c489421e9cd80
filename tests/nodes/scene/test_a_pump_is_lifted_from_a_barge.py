"""The scene `floating`: the tip of a boom moves as its vessel's responses say, and the pump swings below it as three
links of a linear pendulum do."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from heavylift.coordinator.run import run
from heavylift.nodes.scene import load
from heavylift.recordings import Recording

G, W, K = 9.80665, 2.0 * np.pi / 8.0, (2.0 * np.pi / 8.0) ** 2 / 9.80665
RESPONSES = {  # per metre of wave amplitude [m, deg], and phase [deg]
    "surge": (0.25, 90), "sway": (0.15, -90), "heave": (0.45, 10), "roll": (1.1, -70), "pitch": (0.5, 95),
    "yaw": (0.2, 180),
}  # fmt: skip
HOOK, PUMP, SLEWED = 12e3, 180e3, np.radians(25.0)  # masses [kg], and where the boom points in the end


@pytest.fixture(scope="module")
def recording(tmp_path_factory: pytest.TempPathFactory) -> Recording:
    path: Path = tmp_path_factory.mktemp("floating") / "floating.mcap"
    run(load("floating"), path, in_process=True)
    return Recording(path)


def tip(t: float, slew: float = SLEWED) -> np.ndarray:
    """Of the boom of 60 m, 26 m out, by the formulas of the responses, after the wave has grown."""
    q = {name: 0.75 * size * np.cos(W * t + np.radians(phase)) for name, (size, phase) in RESPONSES.items()}
    rise = np.sqrt(60.0**2 - 23.0**2)
    p = np.array([26.0 * np.cos(slew), 26.0 * np.sin(slew), 4.0 + 14.0 + 2.0 + rise])
    for (i, j), name in (((1, 2), "roll"), ((2, 0), "pitch"), ((0, 1), "yaw")):
        c, s = np.cos(np.radians(q[name])), np.sin(np.radians(q[name]))
        p[i], p[j] = c * p[i] - s * p[j], s * p[i] + c * p[j]
    return p + np.array([q["surge"], q["sway"], q["heave"]])


def test_the_crane_tip_moves_by_the_responses_of_the_barge(recording: Recording) -> None:
    """To rounding, at all samples before and after the boom is slewed."""
    boom, begun = recording["pose/crane.boom"], dict((name, t) for t, name in recording.stages())
    for t, (*p, x, y, z, w) in zip(boom.t, boom.values, strict=True):
        along = np.array([1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y + z * w), 2.0 * (x * z - y * w)])
        if 20.0 <= t < begun["slew"] or t > begun["hanging"]:
            slew = 0.0 if t < begun["slew"] else SLEWED
            assert np.array(p) + 60.0 * along == pytest.approx(tip(t, slew), abs=1e-8)


def test_the_pump_of_the_example_scene_swings_as_a_triple_pendulum_below_the_crane_tip(recording: Recording) -> None:
    """Rope, hook block and pump along the boom, linear: the answer to the tip and three free motions of any size
    are what was recorded for 30 s."""
    begun = dict((name, t) for t, name in recording.stages())
    pump, hook = recording["pose/block"], recording["pose/crane.main"]
    inside = np.flatnonzero(
        (pump.t > begun["hanging"]) & (pump.t < begun["down"]) & (np.diff(pump.t, append=1e9) > 0.0)
    )
    t, ahead = pump.t[inside], np.array([np.cos(SLEWED), np.sin(SLEWED)])
    swing = pump.values[inside, :2] @ ahead
    L = np.mean([tip(x)[2] for x in t]) - hook.values[inside, 2].mean()
    d = np.sqrt(12.0**2 - 5.0**2 - 3.0**2) + 2.6
    arms = np.array([[L, 1.0, 0.0], [L, 2.0, d]])  # of the middles of hook block and pump
    own = np.diag([0.0, HOOK * (1.0 + 4.0) / 12.0, PUMP * (12.0**2 + 5.0**2) / 12.0])
    masses = np.array([HOOK, PUMP])
    M = arms.T @ np.diag(masses) @ arms + own
    C = G * np.diag([(HOOK + PUMP) * L, HOOK + 2.0 * PUMP, PUMP * d])

    frequencies = np.sqrt(np.linalg.eigvals(np.linalg.solve(M, C)).real)
    distance = np.array([tip(x)[:2] @ ahead for x in np.arange(0.0, 8.0, 0.25)])
    led = distance @ np.exp(-1j * W * np.arange(0.0, 8.0, 0.25)) / 16.0
    forced = led * (1.0 + arms[1] @ np.linalg.solve(C - W * W * M, arms.T @ masses * W * W))
    steady = distance.mean() + (forced * np.exp(1j * W * t)).real
    free = np.array([f(w * t) for w in frequencies for f in (np.cos, np.sin)]).T
    off = swing - steady - free @ np.linalg.lstsq(free, swing - steady, rcond=None)[0]
    assert np.abs(off).max() < 0.05 * np.ptp(swing)


def test_the_pump_is_landed_on_the_deck_again(recording: Recording) -> None:
    """Half its height above the supports on a deck that lies 4 m above the waterline, 26 m out at 25 degrees."""
    barge, pump = recording["pose/barge"].values[-1], recording["pose/block"].values[-1]
    assert pump[2] - barge[2] == pytest.approx(7.0, abs=0.35)
    assert np.hypot(*(pump[:2] - barge[:2])) == pytest.approx(26.0, abs=1.5)
    assert not recording.fact("verdict", {})["red"]
