"""Ten lifts of many kinds at 1 %: what is promised is kept, or missed in one by less than half as much again."""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1] / "nodes/fidelity"))

from promised import judged

SEEDS = range(2000, 2010)
ACCURACY, UNSAFE = 0.01, 1.5


def test_one_percent_is_one_percent_on_lifts_of_every_kind():
    found = [j for seed in SEEDS for j in judged(seed, (ACCURACY,)) if not j.notes]
    missed = [j for j in found if j.worst > 1.0]
    assert len(found) >= 8
    assert len(missed) <= 1, missed
    assert [j for j in missed if j.worst > UNSAFE] == []
