"""A girder written in a scene file bends under what sits on it, swings, and carries a trolley along."""

from pathlib import Path

import numpy as np
from chain import CLOSED_FORMS, channel, near, play

SAG, FREQUENCY = 0.005, 0.01  # accepted in C18
GIRDER = """\
heavylift: 1
name: girder
accuracy: 1e-4 %
samples: 100 Hz
end: {end}
mechanism:
  bodies:
    girder:
      beam:
        length: 150 m
        mass: 2500 t
        E: 210 GPa
        section: {{Iy: 19.700859375 m4}}
        frame: simply supported
        modes: 3
        damping: {damping}
    trolley: {{mass: 900 t}}
    mark: {{mass: 1 kg}}
  joints:
    legs: {{type: fixed, child: girder, at: [0, 0, 90 m]}}
    rail: {{type: slider, parent: girder, child: trolley, start: 75 m}}
    spot: {{type: fixed, parent: girder, child: mark, at: 75 m}}
  drives:
    drive: {{joint: rail, type: prescribed, ramp: 0.2 m/s2, range: [10 m, 140 m]}}
actions:
{actions}
"""
WAIT = "  - wait: 1 s"
DRIVE = "  - drive: drive 60 m/min to 30 m"


def test_a_loaded_girder_oscillates_about_its_static_sag_at_its_natural_frequency(tmp_path: Path) -> None:
    form = CLOSED_FORMS["C18"]
    given, want = form["given"], form["expected"]

    recording = play(tmp_path, GIRDER.format(end="10 s", damping="0", actions=WAIT))

    t, z = channel(recording, "pose/mark", "z")
    once = np.concatenate(([True], np.diff(t) > 0.0))
    t, z = t[once], z[once]
    own = 5 * given["m_b"] * 9.80665 * given["L"] ** 3 / (384 * given["EI"])
    mean = (z.max() + z.min()) / 2
    assert near(90.0 - mean, want["d"] + own, 2 * SAG)  # of the envelope of two modes
    falls = t[:-1][(z[:-1] >= mean) & (z[1:] < mean)]
    assert near((len(falls) - 1) / (falls[-1] - falls[0]), want["f_loaded"], FREQUENCY)
    names = recording.signal("joint/position").names
    assert [n for n in names if n.startswith("girder")] == ["girder.mode1", "girder.mode2", "girder.mode3"]


def test_a_trolley_is_lowered_by_the_sag_of_its_girder(tmp_path: Path) -> None:
    """After the drive to 30 m the midspan sags by P b (3 L^2 - 4 b^2)/48 EI, b = 30 m, and by the girder's own."""
    given = CLOSED_FORMS["C18"]["given"]

    recording = play(tmp_path, GIRDER.format(end="90 s", damping="10 %", actions=DRIVE))

    _, x = channel(recording, "joint/position", "rail.travel")
    assert near(x[-1], 30.0, 1e-9)
    _, z = channel(recording, "pose/mark", "z")
    b, L = 30.0, given["L"]
    own = 5 * given["m_b"] * 9.80665 * L**3 / (384 * given["EI"])
    sag = 9.0e5 * 9.80665 * b * (3 * L**2 - 4 * b**2) / (48 * given["EI"]) + own
    assert near(90.0 - z[-1], sag, SAG)
    _, energy = channel(recording, "account", "girder.heat")
    assert energy[-1] > 0.0, "the modes' damping is an account of its own"
