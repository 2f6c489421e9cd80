"""The plan and the checks of a scene are cached: an unchanged scene is read from the cache, a changed one anew."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from hashlib import sha256
from pathlib import Path

import pytest
from heavylift.nodes.plan import decode, encode
from heavylift.nodes.scene import load

LOAD = """
import sys
from hashlib import sha256
from heavylift.nodes.scene import load
scene = load(sys.argv[1], sys.argv[2:])
print(sha256(repr(scene.plan).encode()).hexdigest(), "heavylift.nodes.scene.building" in sys.modules)
"""


def loaded(cache: Path, *arguments: str) -> tuple[str, bool]:
    """The plan's hash as a fresh process loads it, and whether it has built it."""
    found = subprocess.run(
        [sys.executable, "-c", LOAD, *arguments],
        env={**os.environ, "HEAVYLIFT_CACHE": str(cache)},
        check=True,
        capture_output=True,
        text=True,
    )
    plan, built = found.stdout.split()
    return plan, built == "True"


def test_loading_an_unchanged_scene_again_returns_the_plan_in_the_cache(tmp_path: Path) -> None:
    settings = ["block.mass=310 t", "ask=[rope tension]", "accuracy=5 %"]
    plan = sha256(repr(load("lift", settings).plan).encode()).hexdigest()
    assert loaded(tmp_path / "cache", "lift", *settings) == (plan, True)
    assert loaded(tmp_path / "cache", "lift", *settings) == (plan, False)
    assert loaded(tmp_path / "cache", "lift", *settings[1:])[1]  # other settings are another lift


@pytest.mark.parametrize("name", ["lift", "in-turn"])  # of one lift, of several
def test_a_scene_loaded_again_from_the_cache_has_the_same_plan_and_findings_and_static_states(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("HEAVYLIFT_CACHE", str(tmp_path / "cache"))
    first, again = load(name), load(name)
    assert (again.plan, again.facts, again.settings) == (first.plan, first.facts, first.settings)
    assert again.scene == first.scene
    assert again.findings == first.findings
    assert len(again.states) == len(first.states) > 0


def test_a_scene_of_several_files_is_read_again_when_one_changes(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("HEAVYLIFT_CACHE", str(tmp_path / "cache"))
    base, scene = tmp_path / "base.yaml", tmp_path / "scene.yaml"
    base.write_text("extends: lift\nsamples: 5 Hz\n")
    scene.write_text("extends: base.yaml\nseed: 7\n")
    assert load(scene).plan.samples_hz == 5.0
    (plan, built), again = loaded(tmp_path / "other", str(scene)), loaded(tmp_path / "other", str(scene))
    assert (built, again) == (True, (plan, False))
    base.write_text("extends: lift\nsamples: 4 Hz\n")
    assert load(scene).plan.samples_hz == 4.0
    assert loaded(tmp_path / "other", str(scene))[1]


def test_equal_scene_files_in_two_folders_each_extend_the_base_file_in_their_own_folder(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("HEAVYLIFT_CACHE", str(tmp_path / "cache"))
    for rate in (5.0, 4.0):
        folder = tmp_path / f"{rate:g}"
        folder.mkdir()
        monkeypatch.chdir(folder)
        Path("base.yaml").write_text(f"extends: lift\nsamples: {rate:g} Hz\n")
        Path("scene.yaml").write_text("extends: base.yaml\nseed: 7\n")
        assert load("scene.yaml").plan.samples_hz == rate


def test_plans_recorded_by_older_versions_are_read_without_removed_parts() -> None:
    plan = load("lift").plan
    older = json.loads(encode(plan))
    for machine in older["machines"]:
        machine["levels"] = True
    assert decode(json.dumps(older).encode()) == plan
