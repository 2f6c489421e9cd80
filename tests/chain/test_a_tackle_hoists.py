"""A tackle with lossy sheaves under orders, from its scene to its recording: C14's part loads."""

from pathlib import Path

import numpy as np
import pytest
from chain import CLOSED_FORMS, channel, happenings, play

FORM = CLOSED_FORMS["C14"]
PART = 1e-4  # of the tension: the load still swings a little
FALLS, MASS, G = 4, 1000.0, 9.80665

SCENE = """\
heavylift: 1
name: tackle
accuracy: 1e-3 %
samples: 20 Hz
end: 10 s
mechanism:
  bodies:
    load: {mass: 1 t}
  joints:
    guide: {type: prismatic, child: load, axis: [0, 0, 1], start: -10 m}
  ropes:
    fall:
      start: {body: world}
      over: [{body: load, efficiency: 98.5 %}, {body: world, efficiency: 98.5 %}, {body: load, efficiency: 98.5 %}]
      end: {body: world}
      EA: 5 MN
      length: 39.98 m
      damping: 4 kN s/m
      winch: {ramp: 1 m/s2, shortest: 5 m, longest: 80 m}
actions:
  - fall: hoist 0.4 m/s by 6 m or until tension of fall >= 2.5 kN
  - fall: hoist 0.2 m/s by 3 m
"""


def test_the_lead_part_of_a_tackle_carries_more_than_its_dead_end(tmp_path: Path) -> None:
    recording = play(tmp_path, SCENE)
    eta = FORM["given"]["eta"]
    t, lead = channel(recording, "reeving/tension", "fall.1")
    _, dead = channel(recording, "reeving/tension", "fall.4")
    assert happenings(recording, "reached"), "2.5 kN end the first hoist"
    assert lead[-1] == pytest.approx(MASS * G * (1 - eta) / (1 - eta**FALLS), rel=PART)
    assert dead[-1] == pytest.approx(lead[-1] * eta**3, rel=PART)
    _, energy = channel(recording, "energy", "heat")
    assert np.all(np.diff(energy) > -1e-6)
    assert t[-1] == pytest.approx(10.0)
