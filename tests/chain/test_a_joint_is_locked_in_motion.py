"""A scene that locks and unlocks a turning joint by its action list: what the recording says of speeds and energy."""

from pathlib import Path

import numpy as np
from chain import channel, play

SCENE = """\
heavylift: 1
name: turntable
accuracy: 1e-4 %
samples: 50 Hz
end: 6 s
gravity: 0 m/s2
mechanism:
  bodies:
    table: {mass: 1 t, inertia: [400 kg m2, 400 kg m2, 600 kg m2]}
    wheel: {mass: 1 t, inertia: [400 kg m2, 400 kg m2, 600 kg m2]}
  joints:
    king: {type: revolute, child: table, axis: [0, 0, 1]}
    hub: {type: cylindrical, parent: table, child: wheel, axis: [0, 0, 1], speed: [0.1 m/s, 2 rad/s]}
  locks:
    bolt: {joint: hub}
actions:
  - wait 2 s
  - bolt: lock
  - wait 2 s
  - bolt: unlock
"""


def test_two_discs_share_their_angular_momentum(tmp_path: Path) -> None:
    """Equal discs: both turn at half the speed; half of the spin's energy and all of the slide's become heat."""
    one, many = (play(tmp_path, SCENE, in_process=here) for here in (True, False))
    assert one.result["digest"] == many.result["digest"]
    t, king = channel(one, "joint/velocity", "king.rate")
    hub, slide = (channel(one, "joint/velocity", f"hub.{x}")[1] for x in ("rate", "speed"))
    before, after = t < 2.0, t > 2.01
    assert np.abs(king[before]).max() < 1e-12
    assert np.abs(king[after] - 1.0).max() < 1e-12
    assert np.all(hub[after] == 0.0)
    assert np.all(slide[after] == 0.0)
    _, heat = channel(one, "account", "bolt.heat")
    assert abs(heat[-1] - (0.5 * 600.0 * 2.0**2 / 2.0 + 0.5 * 1000.0 * 0.1**2)) < 1e-9
