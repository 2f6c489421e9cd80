"""A recording of a DEVS model has events and no samples: people look at them all the same, and other programs."""

from __future__ import annotations

import csv
import json
from pathlib import Path

import pytest
from heavylift import run_models
from heavylift.kernel import RecordingError, SignalError
from heavylift.nodes.devs import Atomic, Coupled, Message, Out, ms
from heavylift.recordings import curves, export, info, info_data, plot, report


class Inner(Message):
    level: float


class Told(Message):
    n: int
    name: str
    inner: Inner
    pair: tuple[int, int] = (1, 2)
    maybe: float | None = None
    at: tuple[tuple[str, float], ...] = (("x.y", 2.5),)


class Bell(Message):
    pass


class Clock(Atomic):
    told, bell = Out(Told), Out(Bell)

    def start(self) -> None:
        self.n = 0
        self.hold_in(ms(1))

    def output(self) -> None:
        self.told.send(Told(self.n, f"tick {self.n}", Inner(self.n / 4), maybe=0.5 if self.n else None))
        self.bell.send(Bell())

    def internal(self) -> None:
        self.n += 1
        self.hold_in(0 if self.n == 1 else ms(2))

    def result(self) -> Told:
        return Told(self.n, "end", Inner(0.25))


def clocks(count: int = 1) -> Coupled:
    model = Coupled("shop")
    for i in range(count):
        model.add(Clock(f"clock{i}"))
    return model


@pytest.fixture(scope="module")
def recorded(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("devs") / "run.mcap"
    run_models(clocks, until=0.006, output=path, in_process=True)
    return path


def test_the_command_info_shows_models_and_results_and_events_of_a_devs_run(recorded: Path) -> None:
    text = info(recorded)
    assert f"  model     {clocks.__module__}:clocks\n" in text
    assert "shop.clock0  Told  n 4, name end, inner {'level': 0.25}, pair [1, 2], maybe None" in text
    assert "clock0       8  told 4, bell 4" in text
    message = info_data(recorded)["result"]["results"]["shop.clock0"]
    assert (message["type"], message["value"]["n"]) == ("Told", 4)


def test_events_of_a_devs_run_are_exported_with_a_column_for_each_field(recorded: Path, tmp_path: Path) -> None:
    with export(recorded, tmp_path / "run.csv").open(newline="") as file:
        head, *rows = csv.reader(file)
    assert head[:6] == ["time [s]", "microstep", "model", "port", "index", "type"]
    assert head[6:] == ["n", "name", "inner.level", "pair", "maybe", "at.x.y"]
    assert rows[0] == ["0.001", "0", "clock0", "bell", "0", "Bell", "", "", "", "", "", ""]
    assert rows[1] == ["0.001", "0", "clock0", "told", "0", "Told", "0", "tick 0", "0.0", "[1,2]", "", "2.5"]
    assert [row[:2] for row in rows[1::2]] == [["0.001", "0"], ["0.001", "1"], ["0.003", "0"], ["0.005", "0"]]


def test_selected_ports_and_fields_of_a_devs_run_are_exported_to_parquet(recorded: Path, tmp_path: Path) -> None:
    parquet = pytest.importorskip("pyarrow.parquet")
    table = parquet.read_table(export(recorded, tmp_path / "run.parquet", ["clock0/told/n", "clock0/*level"]))
    assert table.column_names[6:] == ["n", "inner.level"]
    assert table["inner.level"].to_pylist() == [0.0, 0.25, 0.5, 0.75]
    with pytest.raises(SignalError, match=r"run.mcap: no port matches 'clock0/tolled'; did you mean clock0/told"):
        export(recorded, tmp_path / "none.csv", ["clock0/tolled"])
    assert not (tmp_path / "none.csv").exists()


def test_a_plot_of_a_devs_run_has_one_panel_for_each_port(recorded: Path, tmp_path: Path) -> None:
    assert plot(recorded, tmp_path / "run.png").stat().st_size > 10_000
    page = curves(recorded, ["clock0/told/n", "clock0/bell"], tmp_path / "run.html").read_text()
    for name in ("clock0/told", "clock0/bell", '"name":"n"', '"name":"count"'):
        assert name in page
    assert "inner.level" not in page


def test_plotting_too_many_ports_or_a_run_without_events_is_reported(tmp_path: Path) -> None:
    path = tmp_path / "many.mcap"
    run_models(f"{Path(__file__)}:clocks(9)", until=0.002, output=path, in_process=True)
    with pytest.raises(
        RecordingError, match=r"18 ports are too many for one figure; name some of them, such as 'clock0/bell', '"
    ):
        plot(path, tmp_path / "many.png")
    run_models(clocks, until=0.001, output=tmp_path / "none.mcap", in_process=True)
    with pytest.raises(RecordingError, match=r"has no events to draw; simulate a longer run$"):
        plot(tmp_path / "none.mcap", tmp_path / "none.png")
    assert export(tmp_path / "none.mcap", tmp_path / "none.csv").read_text().startswith("time [s],microstep,model")
    assert json.dumps(info_data(tmp_path / "none.mcap"))


def test_a_plot_of_many_events_at_one_instant_is_drawn_without_a_warning(
    tmp_path: Path, recwarn: pytest.WarningsRecorder
) -> None:
    run_models(clocks, until=0.001000001, output=tmp_path / "run.mcap", in_process=True)
    assert plot(tmp_path / "run.mcap", tmp_path / "run.png").exists()
    assert [warning for warning in recwarn if warning.category is UserWarning] == []


def test_a_recording_of_devs_models_has_no_lift_report(recorded: Path, tmp_path: Path) -> None:
    with pytest.raises(RecordingError, match=r"a run of a DEVS model has no lift report; `heavylift info` prints"):
        report(recorded, tmp_path / "report.html")
