"""Without any one action of `turnover` the scene is refused, or the run ends with an error or another result.

Elsewhere or at another time: the block's last pose, or the end of the list.
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest
from heavylift.coordinator.run import run
from heavylift.kernel import HeavyliftError
from heavylift.nodes.scene import bundled, parse

sys.path.append(str(Path(__file__).parents[1] / "turnover"))

from stock_reader import Array, Reading

ELSEWHERE = 1e-3  # [m] of the block's last place, [1] of its quaternion
LATER = 1.0  # [s]
HEAD, *ACTIONS = bundled()["turnover"].read_text().split("\n  - ")


def last(actions: list[str], folder: Path) -> tuple[float, Array]:
    """When the list ends [s], and the block's pose then."""
    scene = parse("\n  - ".join([HEAD, *actions]), "turnover.yaml")
    result = run(scene, folder / "other.mcap", in_process=True)
    return result.sim_s, Reading(folder / "other.mcap").pose["block"][-1]


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> tuple[float, Array]:
    return last(ACTIONS, tmp_path_factory.mktemp("whole"))


@pytest.mark.parametrize("number", range(len(ACTIONS)))
def test_removing_any_action_from_the_scene_turnover_changes_its_result(
    tmp_path: Path, whole: tuple[float, Array], number: int
) -> None:
    try:
        end, pose = last([a for i, a in enumerate(ACTIONS) if i != number], tmp_path)
    except HeavyliftError:  # refused, or ended with a sentence
        return
    assert abs(end - whole[0]) > LATER or np.abs(pose - whole[1]).max() > ELSEWHERE, ACTIONS[number]
