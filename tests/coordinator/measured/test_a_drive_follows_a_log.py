"""`heavylift run --drive`: a winch goes where a log says, in every run of the recording again."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from heavylift.coordinator.measured import driven
from heavylift.coordinator.replay import RecordedRun
from heavylift.coordinator.run import run
from heavylift.coordinator.run.verify import verify
from heavylift.kernel import HeavyliftError
from heavylift.nodes.scene import LoadedScene, load, parse
from heavylift.recordings import Recording
from small_lift import log

SCENE = """
heavylift: 1
name: hung
end: 8 s
mechanism:
  bodies: {load: {mass: 2 t}}
  joints: {guide: {type: prismatic, child: load, axis: [0, 0, 1], start: -10 m}}
  ropes:
    fall: {start: {body: world}, end: {body: load}, EA: 60 MN, length: 9.99 m, damping: 60 kN s/m,
           winch: {ramp: 0.5 m/s2, shortest: 8 m, longest: 80 m}}
"""
T = [round(0.5 * i, 1) for i in range(13)]
SPEED = [round(12.0 * np.sin(np.pi * t / 6.0) ** 2, 3) for t in T]  # [m/min], 0.6 m in all


@pytest.fixture(scope="module")
def scene() -> LoadedScene:
    return parse(SCENE, "hung.yaml")


def places(scene: LoadedScene, path: Path) -> np.ndarray:
    run(scene, path, in_process=True)
    drum = Recording(path).signal("rope/length")
    return np.interp(np.arange(0.0, 8.0, 0.5), drum.t, drum["fall"])


def test_a_drive_follows_logged_speeds_linearly_between_rows(scene: LoadedScene, tmp_path: Path) -> None:
    table = log(tmp_path / "log.csv", {"time [s]": [100.0 + t for t in T], "hoist": SPEED})
    L = places(driven(scene, [f"fall.hoist={table}:hoist [m/min] @ -100 s"]), tmp_path / "run.mcap")
    v = np.array(SPEED) / 60.0
    distance = np.concatenate([[0.0], np.cumsum(0.25 * (v[1:] + v[:-1]))])
    np.testing.assert_allclose(L[0] - L[:13], distance, atol=1e-3)
    np.testing.assert_allclose(L[0] - L[13:], distance[-1], atol=1e-3)  # where the log ends it stands
    assert verify(RecordedRun(tmp_path / "run.mcap")).same  # the table is in the recording


def test_a_drive_reaches_logged_positions_at_their_times(scene: LoadedScene, tmp_path: Path) -> None:
    x = np.cumsum(SPEED) / 120.0
    table = log(tmp_path / "log.csv", {"time [s]": T, "way [m]": x - x[0]})
    L = places(driven(scene, [f"fall.hoist={table}:way"]), tmp_path / "run.mcap")
    np.testing.assert_allclose(L[0] - L[:13], x - x[0], atol=1e-3)


@pytest.mark.parametrize(
    ("option", "what"),
    [
        ("fall.hoist", "write target, verb, file and column"),
        ("fall.hoist={}:hoist", "row 1, column 'hoist': the unit is missing"),
        ("fall.hoist={}:hoist [kN]", "row 1, column 'hoist': 'kN' is not a unit of a speed or place"),
        ("fall.hoist={}:lift [m/s]", "row 1, column 'lift': there is no such column; there are time, hoist"),
        ("fall.hoist={}:hoist [m/min] @ 3", "missing unit"),
        ("fall.hoist={}:hoist [m/min] @ -90 s", "no two rows lie within the run"),
        (
            "fall.hoist={}:hoist [m/s]",
            "row 5, column 'hoist': moves fall from 9.99 to 6.588 at 1.5 s, beyond its end",
        ),
        ("rope.hoist={}:hoist [m/min]", "rope"),
        ("guide.hoist={}:hoist [m/min]", "guide"),
    ],
)
def test_logs_that_a_drive_cannot_follow_are_refused(
    scene: LoadedScene, tmp_path: Path, option: str, what: str
) -> None:
    table = log(tmp_path / "log.csv", {"time [s]": T, "hoist": SPEED})
    with pytest.raises(HeavyliftError) as message:
        driven(scene, [option.format(table)])
    assert what in str(message.value)


def test_the_action_list_may_not_move_a_drive_that_follows_a_log(tmp_path: Path) -> None:
    table = log(tmp_path / "log.csv", {"time [s]": T, "hoist": SPEED})
    with pytest.raises(
        HeavyliftError, match=r"fall follows the log column log.csv:hoist; remove its orders from the action list"
    ):
        run(driven(load("tackle"), [f"fall.hoist={table}:hoist [m/min]"]), tmp_path / "run.mcap", in_process=True)
