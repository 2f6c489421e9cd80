"""Ropes whose mass is at their ends swing a load after a ramp as ropes of eight lumps do, below any trolley."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

sys.path.extend(str(Path(__file__).parents[2] / x) for x in ("coordinator/verdict", "nodes/fidelity"))

from heavylift.coordinator.ladder import Ladder, Measuring, choose
from heavylift.nodes.plan import MEANT, Plan, Question
from heavylift.nodes.scene import load, parse
from lift_of_a_type import TYPES, Lift, begun
from lifts_of_kinds import lift_of_kinds

SLEWING = {"crawler-250", "jib-60", "pedestal-400", "rough-terrain-59"}  # their hook ropes go on to drums
SWUNG = [88_012, 88_018, 99_012, 99_014]  # random lifts by goliaths that swing since their trolleys have moved
NEAR = 3e-3  # of swings: modes of girders and waves in ropes; without the product of speeds 7e-3 to 17e-3
LUMPS = 2  # index of ropes of eight lumps
STEPS = 4  # candidate of a level: radau5 at 1e-5


def apart(plan: Plan) -> dict[str, float]:
    """Relative differences of swings and positions between ropes with their mass at the ends and of eight lumps."""
    ladder, measuring = Ladder(plan), Measuring(("swing", "position"))
    coarse, fine = (ladder.candidates(level)[STEPS] for level in (ladder.plausible[0], ladder.whole[LUMPS]))
    assert (coarse.plan.fidelity.rope_mass, fine.plan.fidelity.lumps) == ("lumped", 8)
    return measuring.apart(coarse, fine)


@pytest.mark.parametrize("crane", sorted({*TYPES} - SLEWING))
def test_a_load_swings_below_a_moved_trolley_as_with_lumps(
    crane: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    lift = Lift(*begun(crane, tmp_path), tmp_path)
    order = lift.moved({"traverse": "20 m/min by 2 m", "travel": "20 m/min by 2 m"})
    text = lift.beginning(f"  - stage: aside\n    {order}\n  - stage: swing\n    wait: 20 s\n")
    errors = apart(lift.read(text=text).plan)
    assert any("swing of block" in name for name in errors)
    assert max(errors.values()) < NEAR


@pytest.mark.parametrize("seed", SWUNG)
def test_random_lifts_by_ropes_without_lumps_swing_as_with_lumped_ropes(seed: int) -> None:
    assert max(apart(parse(lift_of_kinds(seed).text, passing=True, followed=False).plan).values()) < NEAR


@pytest.mark.parametrize("scene", ["lift", "tandem", "emergency-stop"])
def test_for_swings_to_one_percent_the_choice_of_a_model_level_finds_ropes_without_lumps(scene: str) -> None:
    answer = choose(Ladder(load(scene).plan), Question(MEANT, 0.01), Measuring(MEANT))
    assert (answer.fidelity.ropes, answer.fidelity.rope_mass) == ("elastic", "lumped")
    assert not answer.notes
