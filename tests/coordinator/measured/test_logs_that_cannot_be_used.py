"""Each fault of a log or a map ends in one sentence with file, row and column."""

from __future__ import annotations

import math
from pathlib import Path

import pytest
from heavylift.coordinator.measured import measure, measured
from heavylift.kernel import HeavyliftError
from heavylift.recordings import Recording
from heavylift.recordings.read import read_log
from small_lift import TIMES, log, recorded, tension

T = [round(0.5 * i, 3) for i in range(60)]
CELL = [round(x / 1e3, 3) for x in tension(TIMES[::10][:60], 1e6, 0.6)[:, 0]]
MAP = "cell=rope/tension/west.H1 [kN]"


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return recorded(tmp_path_factory.mktemp("run") / "run.mcap")


def changed(column: list[object], at: int, value: object) -> list[object]:
    return [*column[:at], value, *column[at + 1 :]]


def refused(run: Path, path: Path, *maps: str, offset: float | None = None) -> str:
    with pytest.raises(HeavyliftError) as message:
        measure(run, path, maps or [MAP], offset, out=path.with_name("out.mcap"))
    assert not path.with_name("out.mcap").exists()
    return str(message.value)


@pytest.mark.parametrize(
    ("columns", "row", "column", "what"),
    [
        ({"time [s]": T, "cell": changed(CELL, 7, "nan")}, 9, "cell", "'nan' is not a finite number"),
        ({"time [s]": T, "cell": changed(CELL, 0, "-inf")}, 2, "cell", "'-inf' is not a finite number"),
        ({"time [s]": T, "cell": changed(CELL, 59, "")}, 61, "cell", "is empty, which is a gap"),
        ({"time [s]": T, "cell": changed(CELL, 3, "12_0")}, 5, "cell", "'12_0' is not a number"),
        (
            {"time [s]": changed(T, 5, 1.0), "cell": CELL},
            7,
            "time",
            "1.0 comes after 2.0; times must be in ascending order",
        ),
        (
            {"time [s]": changed(T, 5, T[4]), "cell": CELL},
            7,
            "time",
            "2.0 comes after 2.0; times must be in ascending order",
        ),
        ({"time [s]": [*T[:30], *(t + 9.0 for t in T[30:])], "cell": CELL}, 31, "time", "a gap of 9.5 s behind it"),
        ({"time": T, "cell": CELL}, 1, "time", "the unit is missing"),
        ({"time [m]": T, "cell": CELL}, 1, "time", "'m' is not a unit of time"),
        ({"clock [s]": T, "cell": CELL}, 1, "time", "there is no such column; there are clock, cell"),
        ({"time [s]": T, "cel": CELL}, 1, "cell", "there is no such column; did you mean cel?"),
        ({"time [s]": T[:1], "cell": CELL[:1]}, 2, "time", "the log needs at least two rows"),
    ],
)
def test_a_fault_in_a_measured_log_is_reported_with_its_row_and_column(
    run: Path, tmp_path: Path, columns: dict[str, list[object]], row: int, column: str, what: str
) -> None:
    path = log(tmp_path / "log.csv", columns)
    message = refused(run, path)
    assert message.startswith(f"{path}: row {row}, column '{column}': {what}")
    assert "\n" not in message


@pytest.mark.parametrize(
    ("line", "what"),
    [
        ("cell=rope/tension/west.H1", "row 1, column 'cell': the unit is missing"),
        ("cell=rope/tension/west.H1 [m]", "'m' is not a unit of rope/tension/west.H1; use kN, N, MN, t, kg"),
        ("cell=rope/tension/west.H7 [kN]", "the run has no such channel; did you mean 'rope/tension/west.H"),
        ("cell=rope/tension/* [kN]", "2 channels"),
        ("cell=rope/tension/west.H1 [kN] +- 3", "the unit is missing; use %, kN"),
        ("cell=rope/tension/west.H1 [kN] +- much", "is not a valid uncertainty"),
        ("cell=measured/wind [m/s]", "no column is mapped to a channel of"),
        ("cell=measured/ [m/s]", "measured/ does not name a channel"),
        ("map.yaml", "map.yaml: the map cannot be read"),
    ],
)
def test_a_fault_in_the_map_of_a_measured_log_is_reported(run: Path, tmp_path: Path, line: str, what: str) -> None:
    assert what in refused(run, log(tmp_path / "log.csv", {"time [s]": T, "cell": CELL}), line)


def test_a_fault_in_an_option_for_measured_logs_is_reported(run: Path, tmp_path: Path) -> None:
    message = refused(run, log(tmp_path / "log.csv", {"time [s]": T, "cell": CELL}), "cell=rope/tension/west.H1 [m]")
    assert message.splitlines()[1:] == ["    1 | cell=rope/tension/west.H1 [m]", "      |      ^", "1 error in --map"]


def test_a_fault_in_the_text_of_a_measured_log_is_reported_with_its_line_in_the_file(run: Path, tmp_path: Path) -> None:
    lines = tmp_path / "map.yaml"
    lines.write_text("# cells\ncell: rope/tension/west.H1 [kg m]\n")
    message = refused(run, log(tmp_path / "log.csv", {"time [s]": T, "cell": CELL}), str(lines))
    assert f"{lines}:2:7: error: cell: 'kg m' is not a unit" in message


def test_logs_that_do_not_overlap_the_run_are_refused(run: Path, tmp_path: Path) -> None:
    message = refused(run, log(tmp_path / "log.csv", {"time [s]": T, "cell": CELL}), offset=500.0)
    assert "rows 2 to 61 are 500 to 529.5 s of the run, which goes from 0 to 39.95 s; they do not overlap" in message


def test_a_measured_log_that_does_not_match_the_run_is_refused(run: Path, tmp_path: Path) -> None:
    still = log(tmp_path / "still.csv", {"time [s]": T, "cell": [300.0] * 60})
    assert "no mapped channel varies" in refused(run, still)
    other = log(tmp_path / "other.csv", {"time [s]": T, "cell": [math.sin(40.0 * t * t) for t in T]})
    assert "do not match" in refused(run, other)


def test_a_file_that_is_not_a_measured_log_is_refused(run: Path, tmp_path: Path) -> None:
    for name in ("none.csv", ".", "n" * 300):
        assert "this log does not exist" in refused(run, tmp_path / name)
    path = tmp_path / "log.csv"
    for data, what in ((b"", "no rows"), (b"time,cell\n", "no rows"), (b"\xff\xfe\n\x81", "not UTF-8 text"),
                       (b"time [s],cell\n0,1\n1,2,3\n", "row 3 has 3 cells, but the header has 2")):  # fmt: skip
        path.write_bytes(data)
        assert what in refused(run, path)


def test_measured_logs_in_common_formats_of_data_loggers_are_read(run: Path, tmp_path: Path) -> None:
    """Semicolons with decimal commas, dates, a mark at the beginning, blank lines, tonnes."""
    path = tmp_path / "log.csv"
    path.write_bytes(b"\xef\xbb\xbfZeit;Last [t]\r\n2024-05-01T06:00:00;1,5\r\n\r\n2024-05-01T06:00:00.5;2,5\r\n")
    found = measured(Recording(run), path, ["Zeit=time [date]", "Last=rope/tension/west.H1 +- 2 %"], gravity=10.0)
    assert found.t.tolist() == [0.0, 0.5] == read_log(path).seconds("Zeit").tolist()
    (channel,) = found.channels
    assert channel.values.tolist() == [15_000.0, 25_000.0]
    assert channel.sigma.tolist() == [150.0, 250.0]
