"""A limit by another standard is added as one row of the table and used by plan, check, run and report."""

from pathlib import Path

import pytest
from heavylift.coordinator.run import run
from heavylift.kernel import SceneError
from heavylift.nodes.limits import standards
from heavylift.nodes.scene import load

OWN, FACTOR = "a works standard", 1000.0


def add(monkeypatch: pytest.MonkeyPatch, folder: Path, *row: str) -> None:
    """Add the row; scenes are kept beside those of the table as it is."""
    monkeypatch.setenv("HEAVYLIFT_CACHE", str(folder))
    monkeypatch.setattr(standards, "STRENGTHS", (*standards.STRENGTHS, standards.Strength(*row, FACTOR, OWN)))  # type: ignore[arg-type]


@pytest.mark.parametrize("name", ["lift", "spreader"])
def test_a_scene_beyond_the_limit_of_a_newly_added_standard_is_refused_with_its_name(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    add(monkeypatch, tmp_path, "sling", "sling tension")
    with pytest.raises(SceneError, match=rf"is allowed \({OWN}\)"):
        load(name)


@pytest.mark.parametrize(
    ("name", "row"),
    [
        ("lift", ("sling", "sling peak")),
        ("lift", ("hoist rope", "rope peak")),
        ("spreader", ("sling", "sling peak")),
        ("jib", ("hoist rope", "rope peak")),
    ],
)
def test_a_run_checks_peaks_against_the_limit_of_a_newly_added_standard(
    name: str, row: tuple[str, str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    add(monkeypatch, tmp_path, *row)
    scene = load(name)
    assert [x for x in scene.plan.limits if x.source == OWN]
    verdict = run(scene, tmp_path / "run.mcap", in_process=True).verdict
    assert verdict is not None
    assert any(f"({OWN}" in f.sentence for f in verdict.findings if f.state == "red")
    assert OWN in str(verdict.checks)
