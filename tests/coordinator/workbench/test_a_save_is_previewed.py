"""A preview: start pose, path at rest and checks of a text, or its faults at their places."""

from __future__ import annotations

import time
from pathlib import Path

import msgspec
import pytest
from heavylift.coordinator.verdict import near_at_rest, with_worst_clearances
from heavylift.coordinator.workbench import OpenScene, previewed, version_of
from heavylift.nodes.scene import bundled, check, load

PATIENCE_s = 60.0
RAIL = """heavylift: 1
name: rail
end: 1 s
mechanism:
  bodies:
    car: {mass: 2 t, inertia: [1 t*m2, 1 t*m2, 1 t*m2]}
  joints:
    rail: {type: prismatic, child: car, axis: [1, 0, 0], speed: 1 m/s}
  forces:
    own: {type: law, function: "mine.py:push", joint: rail, parameters: [1000]}
"""


def steps(name: str, *changes: tuple[str, str]) -> list[tuple[str, dict[str, object]]]:
    """Messages of the preview of a bundled scene."""
    path = bundled()[name]
    text = path.read_text()
    for old, new in changes:
        assert old in text
        text = text.replace(old, new)
    return [(kind, data) for kind, data, _ in previewed(path, text)]


def test_a_preview_of_a_scene_shows_the_start_pose_first_and_then_the_path_with_its_checks() -> None:
    kinds, data = zip(*steps("lift"), strict=True)
    assert kinds == ("picture", "faults", "picture", "checks")
    start, _, path, checks = data
    assert (start["what"], path["what"]) == ("start", "path")
    assert [x["title"].partition(",")[0] for x in start["drawings"]] == ["Plan", "Elevation", "Elevation"]  # type: ignore[attr-defined]
    assert "20.00" in start["drawings"][0]["svg"], "the length of the block is a dimension of the plan"  # type: ignore[index]
    stages = list(dict.fromkeys(x["stage"] for x in path["states"]))  # type: ignore[attr-defined]
    assert stages[:4] == ["at the start", "take up slack", "lift off", "up"]
    scene = with_worst_clearances(load("lift"))
    report = check(scene, near_at_rest(scene.plan, scene.statics))
    assert (checks["line"], checks["state"]) == (report.line, report.state)
    assert len(checks["checks"]) == len(report.checks)  # type: ignore[arg-type]
    msgspec.json.encode(data)


@pytest.mark.parametrize("name", ["crawler", "pendulum", "in-turn", "floating"])
def test_scenes_of_all_kinds_are_drawn_in_the_preview(name: str) -> None:
    found = steps(name)
    assert [data["faults"] for kind, data in found if kind == "faults"] == [[]]
    assert next(kind for kind, _ in found) == "picture"
    assert found[-1][0] == "checks"


def test_the_preview_of_a_faulty_scene_shows_the_faults_with_their_lines_and_raises_no_error() -> None:
    ((kind, data),) = steps("lift", ("mass: 300 t", "mass: 300 bananas"), ("crane H2", "crane H7"))
    assert kind == "faults"
    lines = bundled()["lift"].read_text().splitlines()
    for fault in data["faults"]:  # type: ignore[attr-defined]
        assert fault["file"] == "lift.yaml"
        assert lines[fault["line"] - 1].strip().startswith(("mass", "loader-2"))


def test_the_preview_of_a_scene_with_impossible_orders_shows_the_start_pose_and_the_faults() -> None:
    found = steps("lift", ("traverse 20 m/min by 2 m", "traverse 20 m/min by 200 m"))
    assert [kind for kind, _ in found][:2] == ["picture", "faults"]
    (fault,) = found[1][1]["faults"]  # type: ignore[misc]
    assert fault["line"] == 1 + [*map(str.strip, bundled()["lift"].read_text().splitlines())].index("- stage: sideways")
    assert "checks" not in [kind for kind, _ in found]


def test_the_preview_runs_no_untrusted_code(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("XDG_CONFIG_HOME", str(tmp_path / "configuration"))
    ran = tmp_path / "ran"
    (tmp_path / "mine.py").write_text(f"open({str(ran)!r}, 'w')\ndef push(x): return 0.0\n")
    path = tmp_path / "rail.yaml"
    path.write_text(RAIL)
    (found,) = previewed(path, RAIL)
    assert found.kind == "faults"
    assert "not trusted" in found.data["faults"][0]["sentence"]
    assert not ran.exists()


def last(opened: OpenScene, kind: str, version: str) -> dict[str, object]:
    """The message of a kind about a version of the text, when it has come."""
    deadline = time.monotonic() + PATIENCE_s
    while time.monotonic() < deadline:
        for message in opened.since(0):
            data = msgspec.json.decode(message.data)
            if message.kind == kind and data["version"] == version:
                return dict(data)
        time.sleep(0.02)
    raise AssertionError(f"no {kind} of {version}; {[(m.kind, m.data[:200]) for m in opened.since(0)]}")


def test_a_scene_saved_by_any_editor_is_checked_and_shown_on_all_pages(folder: Path) -> None:
    scene = folder / "my-lift.yaml"
    with OpenScene(folder, scene) as opened:
        text = scene.read_text()
        last(opened, "checks", version_of(text))
        good = text.replace("300 t\n", "280 t\n", 1)
        for changed in (good, text.replace("300 t\n", "300 x\n", 1)):
            scene.write_text(changed)
            faults = last(opened, "faults", version_of(changed))["faults"]
            assert bool(faults) == ("300 x" in changed)
            last(opened, "checks", version_of(good))  # those of the last good text stay
        number, picture = opened.picture or (0, None)
        assert picture is not None
        assert opened.drawings(number, 3)
        assert opened.drawings(number - 1, 3) is None
        assert opened.drawings(number, len(picture.states)) is None


def test_scenes_in_folders_created_while_the_workbench_runs_are_listed(folder: Path) -> None:
    with OpenScene(folder, folder / "my-lift.yaml") as opened:
        last(opened, "checks", version_of((folder / "my-lift.yaml").read_text()))
        deep = folder / "yard" / "north"
        deep.mkdir(parents=True)
        (deep / "other.yaml").write_text((folder / "my-lift.yaml").read_text())
        deadline = time.monotonic() + PATIENCE_s
        while not any(m.kind == "scene" and b"yard/north/other.yaml" in m.data for m in opened.since(0)):
            assert time.monotonic() < deadline
            time.sleep(0.02)
