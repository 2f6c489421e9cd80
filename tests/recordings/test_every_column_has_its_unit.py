"""Places and angles that stand side by side in one signal: each column is reported in its own unit, whatever the
joint."""

import pytest
from heavylift.kernel.description import JOINTS
from heavylift.recordings.format import POSE_UNIT, unit_of

PLACES = {"travel", "x", "y", "z"}
SPEEDS = {"speed", "vx", "vy", "vz"}
NUMBERS = {"qx", "qy", "qz", "qw"}


@pytest.mark.parametrize("kind", JOINTS)
def test_the_unit_of_a_joint_coordinate_is_metre_or_radian_or_none(kind: str) -> None:
    for name in JOINTS[kind].coordinates:
        expected = "m" if name in PLACES else "1" if name in NUMBERS else "rad"
        assert unit_of("m or rad", f"crane.boom.{name}") == expected
    for name in JOINTS[kind].velocities:
        assert unit_of("m/s or rad/s", f"crane.boom.{name}") == ("m/s" if name in SPEEDS else "rad/s")


def test_a_recorded_position_has_units_of_length_and_a_quaternion_has_none() -> None:
    assert [unit_of(POSE_UNIT, x) for x in ("x", "y", "block.z", "qx", "block.qw")] == ["m", "m", "m", "1", "1"]


def test_if_a_signal_has_one_unit_each_of_its_columns_has_that_unit() -> None:
    assert unit_of("N", "tension of w.angle") == "N"
    assert unit_of("N or m", "east.angle") == "N or m"
