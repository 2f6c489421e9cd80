"""A block is let go on its ropes and comes to rest; the ropes share its weight as statics says."""

from math import sqrt
from pathlib import Path

import numpy as np
import pytest
from chain import CLOSED_FORMS, G, play

SHARE = 1e-6  # of each tension, at rest
REST = 1e-8  # [m/s, rad/s] of heave and tilt, which the ropes damp; the sway of some micrometres goes on for ever

LENGTH, STIFFNESS = 50.0, CLOSED_FORMS["C08b"]["given"]["k"]


def block(mass: float, lugs: list[list[float]], cg: list[float]) -> str:
    """A block in the plane of its lugs, below vertical ropes that do not carry yet."""
    damping = 0.4 * sqrt(STIFFNESS * mass / len(lugs))
    ropes = "".join(
        f"""\
    rope-{i}:
      start: {{body: world, at: [{x} m, {y} m, {LENGTH} m]}}
      end: {{body: block, at: [{x} m, {y} m, 0]}}
      EA: {STIFFNESS * LENGTH!r} N
      length: {LENGTH} m
      damping: {damping!r} N s/m
"""
        for i, (x, y) in enumerate(lugs, 1)
    )
    return f"""\
heavylift: 1
name: shares
accuracy: 1e-6 %
samples: 1 Hz
end: 30 s
mechanism:
  bodies:
    block: {{mass: {mass!r} kg, com: [{cg[0]} m, {cg[1]} m, 0], inertia: [2.4e7 kg m2, 3e7 kg m2, 5.2e7 kg m2]}}
  joints:
    free: {{type: free, child: block}}
  ropes:
{ropes}"""


@pytest.mark.parametrize("which", ["C08a", "C08b"])
def test_load_shares_of_ropes_at_rest_agree_with_statics(tmp_path: Path, which: str) -> None:
    form = CLOSED_FORMS[which]
    given, want = form["given"], np.array(form["expected"]["T"])

    recording = play(tmp_path, block(given["W"] / G, given["lugs"], given["cg"]))

    tension = recording.signal("rope/tension").values
    assert tension[0].max() == 0.0
    velocity = recording.signal("joint/velocity")
    damped = [velocity.names.index(f"free.{component}") for component in ("vz", "wx", "wy")]
    assert np.abs(velocity.values[-1, damped]).max() < REST
    assert np.abs(tension[-1] / want - 1).max() < SHARE
