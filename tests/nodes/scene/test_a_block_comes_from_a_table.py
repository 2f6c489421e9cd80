"""Weight, centre of mass and lugs of a block are read from tables beside the scene."""

import re
from pathlib import Path

import pytest
from heavylift.kernel import SceneError
from heavylift.nodes.scene import LoadedScene, load
from heavylift.nodes.scenes import bundled
from lifting import bare, unstated

BLOCKS = """\
block;drawing;mass [t];size x [m];size y [m];size z [m];com x [m];com y [m];com z [m]
B16;A-1;120;10;8;4;0;0;0
B17;A-2;300;20;16;8;0.25;0;-0.5
B18;A-3;480 +- 3 %;20;16;8;0;0;0
"""
LUGS = """\
block,name,x [m],y [m],z [m]
B17,P1,-8,-6,4.3
B17,P2,-4,-6,4.3
B17,Q1,4,-6,4.3
B17,Q2,8,-6,4.3
B17,R1,-2,6,4.3
B17,R2,2,6,4.3
B18,P1,0,0,4.3
"""
WRITTEN = ["block.com=[0.25 m, 0 m, -0.5 m]"]
"""What the bundled scene lacks of block B17."""


@pytest.fixture
def scene(tmp_path: Path) -> Path:
    """The bundled lift, its block and lugs in tables."""
    text = unstated(bundled()["lift"].read_text())
    before, rest = text.split("  mass: 300 t\n  size: [20 m, 16 m, 8 m]\n")
    kept, lugs = rest.split("  lugs:")
    after = lugs[lugs.index("\ncranes:") :]
    (tmp_path / "blocks.csv").write_text(BLOCKS)
    (tmp_path / "lugs.csv").write_text(LUGS)
    path = tmp_path / "lift.yaml"
    path.write_text(f"{before}  from: blocks.csv#B17\n{kept}  lugs from: lugs.csv#B17\n{after}")
    return path


def meant(scene: LoadedScene) -> str:
    """The plan without the places of its text, and without what its uncertain inputs do to its limits."""
    return re.sub(r"where='[^']*'|marks={[^}]*}|spread=[^,]*, adds=[^,]*, inputs='[^']*'", "", repr(scene.plan))


def refused(scene: Path, *settings: str) -> str:
    with pytest.raises(SceneError) as error:
        load(scene, settings)
    return str(error.value).replace(f"{scene.parent}/", "")


def test_a_scene_with_a_table_gives_the_plan_of_the_full_text(scene: Path) -> None:
    assert meant(load(scene)) == meant(bare("lift", WRITTEN))


def test_keys_stated_in_the_scene_override_those_of_the_table_row(scene: Path) -> None:
    scene.write_text(scene.read_text().replace("  from:", "  mass: 250 t\n  from:"))
    assert meant(load(scene)) == meant(bare("lift", [*WRITTEN, "block.mass=250 t"]))


def test_a_table_row_named_by_a_setting_replaces_the_row_that_the_scene_names(scene: Path) -> None:
    heavier: LoadedScene = load(scene, ["block.from=blocks.csv#B18"])
    assert heavier.scene.block is not None
    assert heavier.scene.block.mass == 480e3
    assert meant(heavier) == meant(bare("lift", ["block.mass=480 t +- 3 %"]))


def test_a_scene_that_extends_another_scene_may_name_another_row_of_the_block_table(scene: Path) -> None:
    (scene.parent / "next.yaml").write_text("extends: lift.yaml\nname: lift\nblock: {from: blocks.csv#B18}\n")
    assert meant(load(scene.parent / "next.yaml")) == meant(bare("lift", ["block.mass=480 t"]))
    scene.write_text(scene.read_text().replace("  from:", "  mass: 250 t\n  from:"))
    assert meant(load(scene.parent / "next.yaml")) == meant(bare("lift", ["block.mass=480 t"]))


def test_a_block_written_in_a_setting_replaces_the_row_of_the_block_table(scene: Path) -> None:
    given = "{from: blocks.csv#B17, mass: 250 t, at: [40 m, 75 m, 6 m], lugs from: lugs.csv#B17, supports: "
    supports = "{height: 2 m, at: [[-8 m, -6 m], [8 m, -6 m], [-8 m, 6 m], [8 m, 6 m]]}}"
    whole = load(scene, [f"block={given}{supports}"])
    assert meant(whole) == meant(bare("lift", [*WRITTEN, "block.mass=250 t"]))


def test_a_workbook_and_a_csv_table_give_the_same_block(scene: Path) -> None:
    openpyxl = pytest.importorskip("openpyxl")
    book = openpyxl.Workbook()
    for line in BLOCKS.splitlines():
        book.active.append([float(x) if x.replace(".", "").isdigit() else x for x in line.split(";")])
    book.save(scene.parent / "blocks.xlsx")
    assert meant(load(scene, ["block.from=blocks.xlsx#B17"])) == meant(load(scene))


@pytest.mark.parametrize(
    ("old", "new", "sentence"),
    [
        ("300;20", "heavy;20", "blocks.csv:3:9: error: block.mass: 'heavy' is not a valid mass"),
        ("mass [t]", "mass [m]", "blocks.csv:3:9: error: block.mass: '300 m' is not a valid mass"),
        ("size x [m]", "mass [kg]", "blocks.csv:1:24: error: block.mass: the row gives 'mass' twice"),
        ("size y [m]", "size x [m]", "block.size: the row gives 'size' twice"),
        ("com z [m]", "com [m]", "block.com: the row gives 'com' twice"),
        ("300;20", "300;5;20", "blocks.csv:3: this row has more cells than the header"),
        ("300;20", "300,5;20", "blocks.csv:3:9: error: block.mass: "),
        ("mass [t]", "mas [t]", "blocks.csv:1:15: error: block.mas: unknown key 'mas'"),
        ("0.25;0;-0.5", "0.25;;-0.5", "blocks.csv:3:26: error: block.com: the row 'B17' is empty in column 'com y'"),
        ("B17", "B71", "lift.yaml:9:9: error: block.from: blocks.csv has no row 'B17': did you mean 'B71'?"),
        ("B16", "B17", "block.from: blocks.csv has the row 'B17' 2 times, in lines 2 and 3"),
        ("A-2;300", 'A-2;"300', "block.from: blocks.csv:3: this is not a row of a table: unexpected end of data"),
    ],
)
def test_faults_in_a_table_of_blocks_are_reported_with_file_and_row_and_column(
    scene: Path, old: str, new: str, sentence: str
) -> None:
    table = scene.parent / "blocks.csv"
    table.write_text(BLOCKS.replace(old, new, 1))
    assert sentence in refused(scene)


@pytest.mark.parametrize(
    ("named", "sentence"),
    [
        (
            "../blocks.csv#B17",
            "'blocks.csv' is outside of the scene's folder, but a scene may use only files in its own folder; "
            "copy the file there",
        ),
        ("nothing.csv#B17", "there is no table 'nothing.csv' beside the scene"),
        (
            "blocks.doc#B17",
            "'blocks.doc' is not a table: name a .csv, .tsv or .xlsx file beside the scene, then # and a row",
        ),
        ("lift.xlsx#B17", "there is no table 'lift.xlsx' beside the scene"),
        ("blocks.csv", "blocks.csv has no row ''"),
        ("17", "write the table and the row, such as 'from: blocks.csv#B17'"),
    ],
)
def test_a_file_that_is_not_a_table_of_blocks_is_reported(scene: Path, named: str, sentence: str) -> None:
    assert sentence in refused(scene, f"block.from={named}")


def test_a_lug_without_a_position_is_reported_with_its_table(scene: Path) -> None:
    (scene.parent / "lugs.csv").write_text(LUGS.replace("B17,Q1,4,", "B17,Q1,four,"))
    assert "lugs.csv:4:8: error: block.lugs.Q1[0]: 'four' is not a valid length" in refused(scene)
    (scene.parent / "lugs.csv").write_text(LUGS.replace("y [m]", "v"))
    assert "block.lugs from: lugs.csv has no column y [m]" in refused(scene)
    (scene.parent / "lugs.csv").write_text(LUGS.replace("y [m]", "capacity [t]"))
    assert "lugs.csv: a lug has only the quantities x, y and z, not 'capacity'" in refused(scene)


@pytest.mark.parametrize("column", range(2, 9))
def test_an_empty_table_cell_is_an_error_even_if_the_base_scene_has_the_key(scene: Path, column: int) -> None:
    head, row = BLOCKS.splitlines()[0].split(";"), BLOCKS.splitlines()[3].split(";")
    row[0], row[column] = "B19", ""
    (scene.parent / "blocks.csv").write_text(BLOCKS + ";".join(row) + "\n")
    (scene.parent / "next.yaml").write_text("extends: lift.yaml\nname: next\nblock: {from: blocks.csv#B19}\n")
    key = head[column].partition(" [")[0]
    at = len(";".join(row[:column])) + 2
    assert f"blocks.csv:5:{at}: error: block.{key.split()[0]}: the row 'B19' is empty in column '{key}'" in refused(
        scene.parent / "next.yaml"
    )
    given = {"mass": "mass: 480 t", "size": "size: [20 m, 16 m, 8 m]", "com": "com: [0 m, 0 m, 0 m]"}[key.split()[0]]
    (scene.parent / "next.yaml").write_text(
        f"extends: lift.yaml\nname: lift\nblock: {{from: blocks.csv#B19, {given}}}\n"
    )
    assert meant(load(scene.parent / "next.yaml")) == meant(bare("lift", ["block.mass=480 t"]))


def test_a_lug_missing_in_a_table_is_not_taken_from_the_base_scene(scene: Path) -> None:
    (scene.parent / "next.yaml").write_text("extends: lift.yaml\nname: next\nblock: {lugs from: lugs.csv#B18}\n")
    message = refused(scene.parent / "next.yaml")
    assert "'P2'" in message
    assert "lift.yaml" in message
