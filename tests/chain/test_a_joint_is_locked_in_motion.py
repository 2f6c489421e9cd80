"""A scene locks and unlocks a turning joint by its action list: recorded speeds and energies."""

from pathlib import Path

import numpy as np
import pytest
from chain import Happening, channel, happenings, play, the_only
from heavylift.coordinator.run import Progress, run
from heavylift.nodes.scene import load

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

LOST = 0.5 * 600.0 * 2.0**2 / 2.0 + 0.5 * 1000.0 * 0.1**2  # half of the spin's energy, all of the slide's [J]


def test_two_discs_locked_together_share_their_angular_momentum(tmp_path: Path) -> None:
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
    assert abs(heat[-1] - LOST) < 1e-9


def test_the_energy_lost_by_locking_a_moving_joint_is_reported_and_recorded(tmp_path: Path) -> None:
    """The kernel answers the command at the next microstep; without motion there is nothing to lose."""
    again = SCENE + "  - bolt: lock\n"
    one, many = (play(tmp_path, again, in_process=here) for here in (True, False))
    assert one.result["digest"] == many.result["digest"]
    locked, standing = happenings(one, "locked", "bolt")
    assert (locked.t, standing.t) == (2.0, 4.0)
    assert abs(locked.value - LOST) < 1e-9
    assert standing.value < 1e-20
    assert the_only(happenings(one, "freed")) == Happening(4.0, "bolt", "freed", 0.0)
    message = [e for e in one.events(source="kernel") if e.t_ns == 2_000_000_000]
    asked = [e for e in one.events() if e.type == "SetLock" and e.t_ns == 2_000_000_000]
    assert [e.microstep for e in message] == [asked[0].microstep + 1]
    assert message[0].port == "state_mechanism"


def test_the_energy_lost_by_locking_a_joint_is_printed_in_the_table_of_stages(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """One line with the time, the lock and what has become heat."""
    scene = tmp_path / "scene.yaml"
    scene.write_text(SCENE)
    loaded = load(scene)
    run(loaded, tmp_path / "run.mcap", in_process=True, watch=Progress(loaded.plan))
    assert "2.0 s  bolt locked, 605 J became heat" in capsys.readouterr().err
