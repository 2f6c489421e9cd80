"""Random lifts, by goliaths and by other cranes: what is answered to an accuracy is within it of the finest level."""

from __future__ import annotations

import sys
from collections.abc import Callable
from pathlib import Path

import msgspec
import pytest

sys.path.insert(0, str(Path(__file__).parents[2] / "nodes/fidelity"))

from heavylift.coordinator.ladder import Ladder, Measuring, ModelLevel, at_level, choose, largest
from heavylift.nodes.plan import MEANT, Fidelity, Question
from heavylift.nodes.scene import load, parse
from lifts_of_kinds import Drawn, lift_of_kinds
from lifts_of_the_world import lift_of_the_world

Draw = Callable[[int], Drawn]
SMALL = 30_008  # by one hook
TRUE = 1e-7  # tolerance of the reference
FINER = {"ropes": ("rigid", "elastic", "massive"), "girder": ("rigid", "elastic"), "slings": ("rigid", "elastic")}


@pytest.mark.parametrize(
    ("draw", "seed", "accuracy"),
    [(lift_of_kinds, SMALL, 0.1), (lift_of_the_world, 30_002, 0.1), (lift_of_the_world, 30_002, 0.01)],
)
def test_random_lifts_are_within_the_requested_accuracy(draw: Draw, seed: int, accuracy: float) -> None:
    plan = parse(draw(seed).text, passing=True, followed=False).plan
    ladder, measuring = Ladder(plan), Measuring(MEANT)
    answer = choose(ladder, Question(MEANT, accuracy), measuring)
    assert not answer.notes
    assert max(answer.errors.values()) <= accuracy
    own = msgspec.structs.replace(at_level(plan, answer.fidelity), method=answer.method, tolerance=answer.tolerance)
    finest = msgspec.structs.replace(ladder.rungs(ladder.full[-1])[0].plan, tolerance=TRUE)
    assert largest(measuring.apart(ModelLevel(own), ModelLevel(finest))) <= accuracy


@pytest.mark.parametrize("scene", ["lift", "tandem", "hall", "pendulum", "floating"])
@pytest.mark.parametrize(
    "named", [{}, {"girder": "rigid"}, {"ropes": "rigid", "slings": "rigid"}, {"rope_mass": "none"}]
)
def test_a_reference_run_restores_all_that_a_level_omits(scene: str, named: dict[str, str]) -> None:
    plan = load(scene).plan
    ladder = Ladder(at_level(plan, Fidelity(**named)), list(named))  # type: ignore[arg-type]
    for level in ladder.levels:
        witnesses = ladder.witnesses(level)
        assert witnesses or level == ladder.full[-1] or len(ladder.full) == 1
        assert level not in witnesses
        for witness in witnesses:
            for key, order in FINER.items():
                assert order.index(getattr(witness, key)) >= order.index(getattr(level, key))
                assert len(ladder.full) == 1 or getattr(witness, key) == order[-1], "nothing is left out by both"


def test_an_answer_that_does_not_converge_reports_its_spread() -> None:
    plan = load("lift", ["end=40 s"]).plan
    answer = choose(Ladder(plan, ["ropes", "girder"]), Question(MEANT, 1e-3), Measuring(MEANT))
    assert answer.notes[0].startswith("not converged: asked to 0.1 %, what was run differs by ")
    assert max(answer.errors.values()) > 1e-3
    assert answer.fidelity.ropes == "elastic"
