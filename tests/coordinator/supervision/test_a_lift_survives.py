"""Every kind of node of a lift is killed in one run, the mechanics more than once and after checkpoints."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest
from heavylift.coordinator.run import run
from heavylift.coordinator.supervision import Succession
from heavylift.nodes.scene import load
from trouble import Notes, Troubled, strike, trouble

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="watches processes in /proc, which only Linux has")

VICTIMS = {12: "commander", 26: "crane", 36: "kernel", 46: "block", 56: "loader-2", 66: "kernel"}


@pytest.fixture(scope="module")
def digest(tmp_path_factory: pytest.TempPathFactory) -> str:
    return run(load("lift"), tmp_path_factory.mktemp("whole") / "lift.mcap", in_process=True).digest


@pytest.mark.parametrize("often", [False, True], ids=["told in full", "from checkpoints"])
@pytest.mark.large(beyond=1)
def test_a_lift_with_killed_processes_has_the_digest_of_the_undisturbed_run(
    tmp_path: Path, digest: str, often: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    if not often:
        monkeypatch.setattr(Succession, "keep", lambda *_: None)
    notes = Notes()
    keep = {"KEEP_s": 0.0, "KEEP_GRANTS": 3} if often else {}
    with trouble({point: strike(victim) for point, victim in VICTIMS.items()}, **keep):
        result = run(load("lift"), tmp_path / "lift.mcap", watch=notes)
    assert result.digest == digest
    assert [note.split()[1] for note in notes.notes] == list(VICTIMS.values())
    assert result.energy_error < 1e-6  # no sample counts twice
    kept = [bool(life.kept_batch) for node, life in Troubled.last._lives.items() if node == "kernel"]
    assert kept == [often]
