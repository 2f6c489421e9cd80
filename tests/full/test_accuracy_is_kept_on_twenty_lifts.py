"""`accuracy: 1 %` on twenty lifts at random: kept in nineteen at least, nowhere missed by more than three times."""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1] / "nodes/fidelity"))

from kept import judged

SEEDS = range(200, 220)
ACCURACY, KEPT, NEVER = 0.01, 0.95, 3.0


def test_one_percent_is_one_percent():
    found = [judged(seed, ACCURACY, against=False) for seed in SEEDS]
    assert [j for j in found if j.worst > NEVER] == []
    assert sum(j.worst <= 1.0 for j in found) >= KEPT * len(found), [j for j in found if j.worst > 1.0]
