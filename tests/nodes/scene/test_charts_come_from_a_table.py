"""Charts of a hook from a table: radius down, length of boom across, counterweight and base in columns of their own."""

from __future__ import annotations

from pathlib import Path

import pytest
from heavylift.kernel import SceneError
from heavylift.nodes.plan import Plan
from heavylift.nodes.scene import load
from heavylift.nodes.scene.text import library

TABLE = """\
radius [m],counterweight [t],outriggers [m],boom 20 m [t],boom 30 m [t],remark
4,10,7,40,30,front
8,10,7,20,15,front
4,20,7,50,38,
8,20,7,25,19,
4,20,5,22,,half out
6,20,5,12,,
"""


def plan_of(folder: Path, boom: str, heavy: str, wide: str, table: str = TABLE, name: str = "charts.csv") -> Plan:
    kind = library()["rough-terrain-59"].read_text(encoding="utf-8")
    begin, _, rest = kind.partition("    capacity charts:")
    own = f"    counterweight: {heavy}\n    outriggers: {wide}\n    charts from: {name}\n    fall EA"
    (folder / "mine.yaml").write_text(begin + own + rest.partition("    fall EA")[2], encoding="utf-8")
    if name.endswith(".csv"):
        (folder / name).write_text(table, encoding="utf-8")
    text = f"heavylift: 1\nname: a\nend: 1 s\ncranes: {{a: {{type: mine.yaml, boom: {boom}, radius: 6 m}}}}\n"
    (folder / "a.yaml").write_text(text, encoding="utf-8")
    return load(folder / "a.yaml").plan


def test_boom_counterweight_and_base_select_the_load_chart(tmp_path: Path) -> None:
    def chart(boom: str, heavy: str, wide: str) -> list[tuple[float, float]]:
        (machine,) = plan_of(tmp_path, boom, heavy, wide).machines
        return list(machine.hooks[0].chart)

    assert chart("20 m", "10 t", "7 m") == [(4.0, 40e3), (8.0, 20e3)]
    assert chart("20 m", "25 t", "7.3 m") == [(4.0, 50e3), (8.0, 25e3)]
    assert chart("20 m", "25 t", "6.9 m") == [(4.0, 22e3), (6.0, 12e3)]
    assert chart("22 m", "20 t", "7 m") == [(4.0, 38e3), (8.0, 19e3)]
    with pytest.raises(SceneError, match="no chart for this boom length"):
        chart("20 m", "25 t", "4 m")


def test_the_configuration_of_a_machine_lists_boom_counterweight_outriggers_falls_and_base(tmp_path: Path) -> None:
    (machine,) = plan_of(tmp_path, "20 m", "20 t", "7 m").machines
    message = {"boom": "20 m", "counterweight": "20 t", "outriggers": "7 m", "falls": "10"}
    assert machine.configuration == {**message, "base": "outriggers 7.32 m long, 7.32 m apart"}


def test_a_workbook_and_a_csv_file_give_the_same_load_chart(tmp_path: Path) -> None:
    openpyxl = pytest.importorskip("openpyxl")
    book = openpyxl.Workbook()
    for row in TABLE.splitlines():
        book.active.append(row.split(","))
    book.save(tmp_path / "charts.xlsx")
    (machine,) = plan_of(tmp_path, "20 m", "10 t", "7 m", name="charts.xlsx").machines
    assert list(machine.hooks[0].chart) == [(4.0, 40e3), (8.0, 20e3)]


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        ("8,10,7,20", "8,10,7,twenty", r"charts\.csv:3:8"),
        ("8,10,7,20", "x,10,7,20", r"charts\.csv:3:1"),
        ("8,20,7,25", "8,heavy,7,25", r"heavy"),
        ("radius [m]", "reach [m]", r"charts\.csv:1: the header of a chart cannot have 'reach'"),
        (
            "boom 20 m [t],boom 30 m [t]",
            "a,b",
            r"charts\.csv:1: the header of a chart needs 'radius \[m\]' and columns",
        ),
    ],
)
def test_faults_in_a_load_chart_file_are_reported_with_file_and_row_and_column(
    tmp_path: Path, old: str, new: str, told: str
) -> None:
    with pytest.raises(SceneError, match=told):
        plan_of(tmp_path, "20 m", "10 t", "7 m", TABLE.replace(old, new))


def test_a_missing_load_chart_file_is_reported(tmp_path: Path) -> None:
    with pytest.raises(SceneError, match=r"there is no table 'other\.xlsx' beside the scene"):
        plan_of(tmp_path, "20 m", "10 t", "7 m", name="other.xlsx")
