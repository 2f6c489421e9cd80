"""Linear models of a hanging load under every crane type equal differences of the compiled equations."""

from pathlib import Path

import numpy as np
import pytest
from heavylift.coordinator.participants import at_rest
from heavylift.kernel.analysis import Poses, linear_model
from heavylift.nodes.scene import new_scene_with, parse
from heavylift.nodes.scene.text import library

TABLE = "block,mass [t],size x [m],size y [m],size z [m]\nsmall,4,4,3,2\nlarge,60,24,16,3\n"
LARGE = ("goliath", "mobile", "twin")  # by the first word of a type; others lift the small one
STEP = 1e-6  # [m, rad, m/s, rad/s] of the differences
SAME = 1e-8  # relative to the largest number: rounding of differences


@pytest.mark.parametrize("crane", library())
def test_the_linear_model_of_every_crane_type_agrees_with_finite_differences(
    crane: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "blocks.csv").write_text(TABLE)
    row = "large" if crane.startswith(LARGE) else "small"
    (text,) = new_scene_with("mine", crane, f"blocks.csv#{row}").values()
    there = at_rest(parse(text, str(tmp_path / "mine.yaml")), None, "up")[1]
    found, poses = linear_model(there, [], ["joint/velocity/*"]), Poses(there)
    n, q = len(found.A) // 2, there.state[: there.program.nq].copy()

    def rates(x: np.ndarray) -> np.ndarray:
        return poses.accelerations(poses.unit(poses.moved(q, x[:n])), x[n:])

    differences = np.array([(rates(STEP * e) - rates(-STEP * e)) / (2.0 * STEP) for e in np.eye(2 * n)]).T
    assert n >= 12
    assert found.A[n:] == pytest.approx(differences, abs=SAME * np.abs(differences).max())
    assert found.A[:n] == pytest.approx(np.eye(2 * n)[n:], abs=SAME)
