"""Two hooks hold a block at many angles; their shares follow its lugs, until the lower hook carries nothing."""

from math import cos, radians, sin
from pathlib import Path

import numpy as np
import pytest
from chain import CLOSED_FORMS, channel, happenings, play
from heavylift.recordings import Recording

FORM = CLOSED_FORMS["C10a"]
SHARE = 1e-5  # of the weight, held still
SLACK = 0.1  # [deg] of the angle at which the lower hook carries nothing

WEIGHT = FORM["given"]["W"]
LENGTH, EA = 50.0, 1870.176e6  # of a hook's rope: 20 falls
STIFF = 1e3 * EA  # so that stretching moves the block by less than 0.1 mm

BLOCK = """\
heavylift: 1
name: block
accuracy: 1e-4 %
samples: 10 Hz
end: {end} s
mechanism:
  bodies:
    block: {{mass: 300 t, inertia: [6e6 kg m2, 1.3e7 kg m2, 1.6e7 kg m2]}}
  joints:
    free: {{type: free, child: block, attitude: [0, {s!r}, 0, {c!r}]}}
  ropes:
{ropes}"""

HOOK = """\
    {name}:
      lines:
        - {{start: {{body: world, at: [{X!r} m, -3 m, {Z!r} m]}}, end: {{body: block, at: [{x} m, -3 m, {z} m]}}, share: 0.5}}
        - {{start: {{body: world, at: [{X!r} m, 3 m, {Z!r} m]}}, end: {{body: block, at: [{x} m, 3 m, {z} m]}}, share: 0.5}}
      EA: {EA!r} N
      length: {length!r} m
      damping: {damping} MN s/m
      winch: {{ramp: 0.2 mm/s2, shortest: 5 m, longest: 80 m}}
"""  # noqa: E501

Lug = tuple[float, float]


def turned(p: Lug, theta: float) -> tuple[float, float]:
    """Place x, z of a lug from the centre of gravity, the block turned by theta."""
    return p[0] * cos(theta) + p[1] * sin(theta), p[1] * cos(theta) - p[0] * sin(theta)


def statics(a: Lug, b: Lug, theta: float) -> tuple[float, float]:
    """Shares of the weight on plumb ropes."""
    x_a, x_b = turned(a, theta)[0], turned(b, theta)[0]
    return x_b / (x_b - x_a), -x_a / (x_b - x_a)


def block(theta: float, a: Lug, b: Lug, lengths: tuple[float, float], end: float, EA: float, damping: float) -> str:
    """A block at this angle below two plumb ropes of these unstretched lengths, each of two lines 6 m apart."""
    hooks = ""
    for name, lug, length in (("A", a, lengths[0]), ("B", b, lengths[1])):
        X, Z = turned(lug, theta)
        x, z = lug
        hooks += HOOK.format(name=name, X=X, Z=Z + LENGTH, x=x, z=z, length=length, EA=EA, damping=damping)
    return BLOCK.format(s=sin(theta / 2), c=cos(theta / 2), ropes=hooks, end=end)


def angles(recording: Recording) -> tuple[np.ndarray, np.ndarray]:
    """Times and angles of the block about y [rad]."""
    t, qy = channel(recording, "pose/block", "qy")
    _, qw = channel(recording, "pose/block", "qw")
    return t, 2 * np.arctan2(qy, qw)


@pytest.mark.parametrize("pose", [pose for pose in FORM["expected"] if pose.startswith("half")])
def test_the_load_share_of_each_crane_follows_from_the_angle_of_the_block(tmp_path: Path, pose: str) -> None:
    given, want = FORM["given"], FORM["expected"][pose]
    a, b = given["A"], given["B_after_rerig" if pose.startswith("half2") else "B"]
    theta = radians(float(pose.split("_")[1].removesuffix("deg")))

    recording = play(tmp_path, block(theta, a, b, (LENGTH, LENGTH), end=10, EA=STIFF, damping=30.0))

    shares = recording.signal("rope/tension").values[-1] / WEIGHT
    assert shares == pytest.approx(want, abs=2 * SHARE)  # at an angle that the stretched ropes change a little
    assert shares == pytest.approx(statics(a, b, angles(recording)[1][-1]), abs=SHARE)


def test_the_lower_hook_goes_slack_when_the_upper_hook_is_plumb_above_the_centre_of_gravity(tmp_path: Path) -> None:
    a, b = FORM["given"]["A"], FORM["given"]["B"]
    theta = radians(65)
    lengths = [LENGTH / (1 + share * WEIGHT / EA) for share in statics(a, b, theta)]
    scene = block(theta, a, b, (lengths[0], lengths[1]), end=165, EA=EA, damping=1.0)

    recording = play(tmp_path, scene + "actions:\n  - B: lower 0.3 m/min by 3 m\n")

    slack = happenings(recording, "slack")[0]
    assert slack.name == "B"
    t, angle = angles(recording)
    at_event = np.degrees(angle[np.flatnonzero(t == slack.t)[0]])
    assert at_event == pytest.approx(FORM["expected"]["theta_B_slack_deg"], abs=SLACK)
    assert np.degrees(angle[0]) == pytest.approx(65.0)
