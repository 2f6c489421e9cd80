"""A row of a sweep searches no more clearances than it tells: its verdict and its smallest one are those of `run`."""

from __future__ import annotations

import pytest
from heavylift.coordinator.run.in_memory import play
from heavylift.nodes.scene import load


@pytest.mark.parametrize("limit", [0.5, 7.2, 30.0])
def test_one_smallest_clearance_is_enough(limit: float) -> None:
    run = play(load("lift", ["end=30 s", f"limits.clearance={limit} m"]).plan)
    verdict, uses = run.judging(smallest=1)
    full = run.verdict
    assert (verdict.line, verdict.red, verdict.findings) == (full.line, full.red, full.findings)
    assert list(uses) == list(run.uses)
    red = [c for c in full.clearances if c.distance < limit]
    assert list(verdict.clearances) == (red or list(full.clearances[:1]))
    assert len(full.clearances) >= 10
