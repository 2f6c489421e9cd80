"""Some random cases of each kind that `tests/full/fuzz.py` draws without end: a result or a sentence, nothing else."""

import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parents[1] / "full"))
from fuzz import fuzz
from fuzzed import KINDS

CASES = {"scenes": 15, "recordings": 3, "frames": 300, "commands": 500, "resume": 30}


@pytest.mark.parametrize("kind", KINDS)
def test_nothing_breaks(kind: str) -> None:
    result = fuzz(kind, seed=7, cpu_s=60.0, most=CASES[kind])
    assert (result.cases, dict(result.found)) == (CASES[kind], {})
    assert result.sentences or kind in ("frames", "recordings")
