"""Costs and gains of processes, fewer samples and larger lookahead: every row of the table is a run."""

from heavylift.coordinator.trace import distributed
from heavylift.nodes.scene import load


def test_the_digest_of_a_run_depends_on_the_sample_rate_and_not_on_the_placement_of_its_nodes():
    rows = {row.where: row for row in distributed(load("lift", ["end=5 s"]))}
    here, two, apart = (rows[where] for where in ("one process", "two processes", "a process per node"))
    assert here.digest == two.digest == apart.digest
    fewer = rows["a process per node, a tenth of the samples"]
    assert fewer.digest != apart.digest
    assert fewer.recorded_bytes < apart.recorded_bytes
    assert apart.grants >= two.grants
    assert all(0.0 < row.cpu_s < 60.0 for row in rows.values())
