"""Signals as a table: CSV and Parquet with units in the names and all digits."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np
import pytest
from heavylift.kernel import RecordingError
from heavylift.recordings import Recording, export
from pyarrow import parquet


def test_an_exported_table_has_units_and_all_digits(recorded: Path, tmp_path: Path) -> None:
    with export(recorded, tmp_path / "run.csv").open(newline="") as file:
        head, *rows = csv.reader(file)
    assert head[:3] == ["time [s]", "rope/tension/west.H1 [N]", "rope/tension/west.H2 [N]"]
    assert head[7:10] == ["pose/block/x [m]", "pose/block/y [m]", "pose/block/z [m]"]
    assert head[10] == "pose/block/qx [1]"
    rec = Recording(recorded)
    numbers = np.array(rows, float)
    assert np.array_equal(numbers[:, 0], rec.signal("rope/tension").t)
    assert np.array_equal(numbers[:, 14:21], rec.signal("pose/hook").values)


def test_only_selected_signals_are_exported(recorded: Path, tmp_path: Path) -> None:
    with export(recorded, tmp_path / "run.csv", ["rope/*/west.H2", "rope/peak"]).open(newline="") as file:
        head = next(csv.reader(file))
    assert head == [
        "time [s]",
        "rope/tension/west.H2 [N]",
        "rope/peak/west.H1 [N]",
        "rope/peak/west.H2 [N]",
        "rope/peak_time/west.H2 [s]",
    ]


def test_an_exported_parquet_file_holds_the_same_numbers_as_the_recording(recorded: Path, tmp_path: Path) -> None:
    table = parquet.read_table(export(recorded, tmp_path / "run.parquet", ["rope/tension"]))
    assert table.column_names == ["time [s]", "rope/tension/west.H1 [N]", "rope/tension/west.H2 [N]"]
    tension = Recording(recorded).signal("rope/tension").values
    assert np.array_equal(table["rope/tension/west.H2 [N]"].to_numpy(), tension[:, 1])


def test_exporting_unknown_signals_or_to_an_unknown_format_is_reported(recorded: Path, tmp_path: Path) -> None:
    with pytest.raises(RecordingError) as error:
        export(recorded, tmp_path / "run.xlsx")
    assert str(error.value) == (
        f"{tmp_path / 'run.xlsx'}: the file name of a table must end in .csv or .parquet; choose such a name"
    )
    with pytest.raises(RecordingError) as error:
        export(recorded, tmp_path / "run.csv", ["rope/colour"])
    assert str(error.value) == (
        f"{recorded}: no signal matches 'rope/colour'; there are rope/tension, rope/peak, rope/peak_time, "
        "pose/block, pose/hook"
    )
