"""`heavylift new --crane TYPE --blocks table.csv`: a scene for each row, that can be checked at once."""

from __future__ import annotations

from pathlib import Path

import pytest
from heavylift.coordinator.commands import app
from heavylift.kernel import SceneError
from heavylift.nodes.scene import load, new_scene_with
from heavylift.nodes.scene.text import library
from typer.testing import CliRunner

TABLE = """\
block,drawing,mass [t],size x [m],size y [m],size z [m]
small,A-1,4,4,3,2
large,A-2,60 +- 3 %,24,16,3
"""
ROWS = {
    "goliath": "large",
    "mobile": "large",
    "twin": "large",
}  # by the first word of a type; others lift the small one


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "blocks.csv").write_text(TABLE)
    return tmp_path


@pytest.mark.parametrize("crane", library())
def test_each_crane_type_lifts_a_block_of_the_table(folder: Path, crane: str) -> None:
    row = ROWS.get(crane.split("-")[0], "small")
    ((name, text),) = new_scene_with("mine", crane, f"blocks.csv#{row}").items()
    (folder / "mine.yaml").write_text(text)
    scene = load(folder / "mine.yaml")
    assert (name, scene.plan.name) == ("mine", "mine")
    assert scene.statics.known
    assert any(not state.grounded for state in scene.statics.states)
    assert scene.statics.states[-1].grounded
    assert not [f for f in scene.findings if f.state == "red"]


def test_the_new_command_writes_a_scene_for_each_row_of_the_table(folder: Path) -> None:
    message = CliRunner().invoke(app, ["new", "yard", "--crane", "jib-60", "--blocks", "blocks.csv"])
    assert message.exit_code == 0
    assert message.stdout.startswith("wrote yard-small.yaml\nwrote yard-large.yaml\n")
    assert (folder / "yard-large.yaml").read_text().startswith("# A lift to start from: jib-60 picks up large.")


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (("--crane", "jib-60"), "--crane and --blocks belong together"),
        (("--crane", "jib-60", "--blocks", "blocks.csv#big"), "blocks.csv has no row 'big'"),
        (("--crane", "jib-6", "--blocks", "blocks.csv#small"), "there is no machine type 'jib-6'"),
        (("--crane", "jib-60", "--blocks", "block.csv"), "there is no table 'block.csv' beside the scene"),
        (
            ("--crane", "mobile-gantry-600", "--blocks", "blocks.csv#small"),
            "further apart than the block",
        ),
        (("--crane", "jib-60", "--blocks", "bare.csv#a"), "the row gives no size"),
    ],
)
def test_scene_files_that_cannot_be_created_are_reported(folder: Path, words: tuple[str, ...], told: str) -> None:
    (folder / "bare.csv").write_text("block,mass [t]\na,3\n")
    with pytest.raises(SceneError, match=told):
        CliRunner().invoke(app, ["new", "mine", *words], catch_exceptions=False)


def test_a_crane_that_is_too_low_for_its_slings_is_reported(folder: Path) -> None:
    (text,) = new_scene_with("mine", "overhead-100", "blocks.csv#large").values()
    (folder / "mine.yaml").write_text(text)
    with pytest.raises(SceneError, match="shorten them, or take a higher crane"):
        load(folder / "mine.yaml")
