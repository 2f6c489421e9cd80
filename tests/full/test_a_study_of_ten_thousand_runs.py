"""Ten thousand variants on two workers: each runs exactly once, and no worker grows in memory."""

from __future__ import annotations

from collections import Counter
from pathlib import Path

import pytest
from heavylift.coordinator.sweeps import sweep
from pyarrow import parquet

COUNT, EARLY = 10_000, 1_000
LARGEST_MB = 200.0  # of a worker
GROWTH_MB = 4.0  # from the thousandth run to the last: pages that the allocator has not given back


def resident(process: int) -> float:
    """Memory of a process [MB]."""
    status = Path(f"/proc/{process}/status").read_text()
    return next(float(line.split()[1]) / 1024.0 for line in status.splitlines() if line.startswith("VmRSS"))


@pytest.mark.large
def test_a_study_of_ten_thousand_runs_does_not_grow_in_memory(tmp_path: Path) -> None:
    early: dict[int, float] = {}
    late: dict[int, float] = {}
    seen = Counter[int]()

    def watch(study, row) -> None:
        if row is None:
            return
        seen[row["number"]] += 1
        found = early if EARLY <= len(seen) < 2 * EARLY else late if len(seen) > COUNT - EARLY else None
        if found is not None:
            found[row["process"]] = max(found.get(row["process"], 0.0), resident(row["process"]))

    vary = [f"mechanism.bodies.load.mass=1..{COUNT} kg by 1 kg"]
    study = sweep("pendulum", [*vary, "end={0.2 s}"], into=tmp_path / "study", workers=2, watch=watch)
    assert (len(seen), set(seen.values())) == (COUNT, {1})
    assert Counter(row["status"] for row in study.rows.values()) == {"done": COUNT}
    table = parquet.read_table(tmp_path / "study" / "rows.parquet", columns=["number", "digest"]).to_pydict()
    assert table["number"] == list(range(COUNT))
    assert len(set(table["digest"])) == COUNT
    assert set(early) == set(late)
    assert max(late.values()) < LARGEST_MB
    assert max(late[process] - early[process] for process in late) < GROWTH_MB
