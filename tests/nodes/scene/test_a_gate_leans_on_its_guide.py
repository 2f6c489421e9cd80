"""The scene `dock`: contacts keep a gate between its guides, and it leans on one as the statics of three links say."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from heavylift.coordinator.run import run
from heavylift.nodes.scene import load
from heavylift.recordings import Recording

G, GATE, BLOCK = 9.80665, 60e3, 2.5e3  # masses of the gate and of the hook block [kg]
TIP, FACE, HALF = 12.3, 14.55, 2.5  # y of the trolley, of the guide's face, of the gate's from its middle [m]
EXIT, HOOK, DEPTH = 20.0, 2.0, 2.0  # where the ropes leave, height of the hook block, gate below its middle [m]


@pytest.fixture(scope="module")
def recording(tmp_path_factory: pytest.TempPathFactory) -> Recording:
    path: Path = tmp_path_factory.mktemp("dock") / "dock.mcap"
    run(load("dock"), path, in_process=True)
    return Recording(path)


def test_a_gate_leans_on_the_far_one_of_its_two_guides_only(recording: Recording) -> None:
    """Rope, hook block and gate hang as three links, and N at the lower edge makes each lean by its moment over that of
    the weights: N / W, 2 N / (2 W_gate + W_block), N c / (W_gate d).  Nothing rubs, so the gate bounces and does so on
    average; what impacts give it is seen by the rope alone.
    """
    begun = dict((name, t) for t, name in recording.stages())["set down"]
    force, gate, hook = (recording[name] for name in ("contact/force", "pose/block", "pose/hall.main"))
    landed = begun + 90.0
    inside = (force.t > begun) & (force.t < landed)
    z, eye = (np.interp(force.t[inside], x.t, x.values[:, 2]) for x in (gate, hook))
    L, d = EXIT - eye, eye - HOOK - z
    c = d + DEPTH
    leans = L / (GATE + BLOCK), HOOK * HOOK / (HOOK * GATE + 0.5 * HOOK * BLOCK), c * c / (GATE * d)
    statics = (TIP + HALF - FACE) * G / sum(leans)
    pressed = dict(zip(recording.columns("contact/force"), force.values[inside].T, strict=True))
    lateral = np.interp(force.t[inside], hook.t, hook.values[:, 1])
    drawn = (GATE + BLOCK) * G * (TIP - lateral) / L
    assert np.mean(drawn) == pytest.approx(np.mean(statics), rel=0.03)
    far = [force for name, force in pressed.items() if name.startswith("block-far-") and "head" not in name]
    assert np.mean(sum(far)) == pytest.approx(np.mean(drawn), rel=0.1)
    assert not any(force.any() for name, force in pressed.items() if "near" in name or "head" in name)


def test_a_gate_stays_between_its_guides_and_stands_upright(recording: Recording) -> None:
    """The lower corners never come behind the faces, and the verdict is green with what the interlock tells."""
    corner = recording["pose/block"]
    y, qx = corner.values[:, 1], corner.values[:, 3]
    below = corner.values[:, 2] < 2.0 + 4.0
    assert (y + HALF + 2.0 * qx * DEPTH)[below].max() < FACE + 2e-3
    assert corner.values[-1, 2] == pytest.approx(2.5, abs=6e-3)
    verdict = recording.fact("verdict", {})
    assert not verdict["red"]
    assert "the gate comes near its near guide" in str(verdict)
