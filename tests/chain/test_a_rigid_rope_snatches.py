"""A rigid rope from a scene file to the recording: it slackens, snaps taut, and its winch is stopped."""

from math import sqrt
from pathlib import Path

import numpy as np
import pytest
from chain import G, channel, happenings, near, play, the_only

MASS, FALL = 1000.0, 2.0
LOCATED = 1e-6  # [s]
EXACT = 1e-9

SCENE = f"""\
heavylift: 1
name: snatch
accuracy: 1e-6 %
samples: 100 Hz
end: 8 s
mechanism:
  bodies:
    load: {{mass: 1 t}}
  joints:
    guide: {{type: prismatic, child: load, axis: [0, 0, 1], start: {FALL - 20.0} m}}
  ropes:
    fall:
      start: {{body: world}}
      end: {{body: load}}
      length: 20 m
      rigid: true
      winch: {{ramp: 1 m/s2, shortest: 5 m, longest: 80 m}}
actions:
  - when: fall taut
    fall: hoist 0.5 m/s by 10 m or until tension of fall >= 10.5 kN
  - fall: hoist 0.5 m/s by 10 m or until length of fall <= 19 m
"""


@pytest.mark.parametrize("in_process", [True, False], ids=["one process", "processes"])
def test_a_falling_load_is_caught_by_its_rigid_rope_and_then_hoisted(tmp_path: Path, in_process: bool) -> None:
    recording = play(tmp_path, SCENE, in_process=in_process)

    snatch = the_only(happenings(recording, "taut", "fall"))
    assert snatch.t == pytest.approx(sqrt(2.0 * FALL / G), abs=LOCATED)
    assert near(snatch.value, MASS * sqrt(2.0 * G * FALL), EXACT), "the impulse [N s]"
    t, tension = channel(recording, "rope/tension")
    assert tension[t < snatch.t - 0.01].max() == 0.0
    _, peak = channel(recording, "rope/peak")
    assert near(peak.max(), MASS * (G + 1.0), EXACT), "of the winch's ramp"
    _, length = channel(recording, "rope/length")
    z = channel(recording, "joint/position")[1]
    assert np.abs(length + z)[t > snatch.t + 0.01].max() < EXACT
    assert length[-1] == pytest.approx(19.0 - 0.5**2 / 2.0, abs=LOCATED), "stopped by its ramp behind 19 m"
