"""What planners found green on cranes other than goliaths is judged on every bundled type, by what its plan says."""

from __future__ import annotations

from pathlib import Path

import pytest
from heavylift.coordinator.ladder import play
from heavylift.kernel import SceneError
from heavylift.kernel.description import Check
from heavylift.nodes.scene import LoadedScene, new_scene_with, parse
from heavylift.nodes.scene.text import library

LARGE = ("goliath", "twin", "mobile")
TYPES = sorted(library())


def begun(crane: str, folder: Path) -> tuple[str, tuple[float, float, float]]:
    """A scene in which a crane of the type picks up a block, and half the block's length and its place in x and y."""
    mass, long, wide = (200, 30, 24) if crane.startswith(LARGE) else (10, 6, 5)
    head = "name,mass [t],size x [m],size y [m],size z [m]\n"
    (folder / "blocks.csv").write_text(f"{head}B,{mass},{long},{wide},4\n", encoding="utf-8")
    (text,) = new_scene_with("made", crane, "blocks.csv#B").values()
    x, y, _ = (float(word.split()[0]) for word in text.split("  at: [")[1].split("]")[0].split(","))
    return text, (long / 2, x, y)


@pytest.fixture(params=TYPES)
def lift(request: pytest.FixtureRequest, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Lift:
    monkeypatch.chdir(tmp_path)
    return Lift(*begun(request.param, tmp_path), tmp_path)


class Lift:
    """A lift by one crane of a type, to be changed."""

    def __init__(self, text: str, block: tuple[float, float, float], folder: Path) -> None:
        self.text, (self.half, self.x, self.y), self.name = text, block, str(folder / "made.yaml")

    def read(self, *settings: str, text: str = "") -> LoadedScene:
        return parse(text or self.text, self.name, list(settings))

    def beginning(self, then: str) -> str:
        """As far as the block hangs, and then something else."""
        return self.text[: self.text.index("  - stage: down")] + then


def red(scene: LoadedScene, word: str) -> list[Check]:
    return [c for c in scene.checks if c.state == "red" and c.quantity.startswith(word)]


def test_a_load_out_of_plumb_is_told_with_its_rope(lift: Lift) -> None:
    tight = "limits={off-lead: 0.1 deg}"
    assert not red(lift.read(tight), "off-lead")
    aside = lift.read(tight, f"block.at=[{lift.x + 0.4} m, {lift.y} m, 3 m]")
    assert red(aside, "off-lead")


def test_a_load_in_the_air_is_not_let_fall(lift: Lift) -> None:
    slings = [line.split(":")[0].strip() for line in lift.text.splitlines() if line.startswith("  legs-")]
    off = ", ".join(f"{name}: unhook" for name in slings or ["all hooks"])
    with pytest.raises(SceneError, match="would fall"):
        lift.read(text=lift.beginning(f"  - {{stage: let go, {off}}}\n"))


@pytest.mark.large(beyond=5)
def test_a_wall_beside_the_load_is_told(lift: Lift) -> None:
    wall = f"at: [{lift.x + lift.half + 0.1 + 0.5} m, {lift.y} m, 2 m]"
    scene = lift.read(f"obstacles={{wall: {{box: [1 m, 4 m, 4 m], {wall}}}}}", text=lift.beginning("  - wait: 1 s\n"))
    found = play(scene.plan).verdict.findings
    assert [f for f in found if f.severity == "red" and f.kind == "clearance" and "wall" in f.sentence]


def test_limits_of_the_scene_count_for_it(lift: Lift) -> None:
    scene = lift.read("limits={clearance: 1 m, off-lead: 2 deg, impact: 1.2, wind: 9 m/s, bridle: 50 deg}")
    rows = {x.quantity: x for x in scene.plan.limits if x.source.startswith("the scene")}
    assert {"clearance", "bridle angle", "wind", "impact"} <= rows.keys()
    assert [x for x in rows if x.startswith("off-lead")]
    assert rows["clearance"].value == 1.0
