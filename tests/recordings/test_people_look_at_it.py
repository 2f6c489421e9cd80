"""`info` and `plot`: what a person is reported and shown about a recording."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest
from heavylift.coordinator.commands import files
from heavylift.kernel import RecordingError
from heavylift.kernel.description import clock
from heavylift.recordings import Recorder, Recording, SampleLayout, info, plot, storyboard
from heavylift.recordings.format import duration
from heavylift.recordings.render import outline, spread
from heavylift.recordings.render.plot import FINE, _most_used


def test_the_command_info_shows_peaks_and_channels_of_a_recording(recorded: Path) -> None:
    text = info(recorded)
    rec = Recording(recorded)
    assert text.splitlines()[:4] == [
        str(recorded),
        "  scene     lift",
        "  settings  seed 7",
        "  status    finished",
    ]
    assert re.search(r"\n  time      4 s simulated in \S+ s, \S+ x real time\n", text)
    assert f"\n  digest    {rec.result['digest']}, computed again\n" in text
    assert "\n".join(
        [
            "  rope         peak      at   rated   use",
            "  west.H1  451.0 kN  2.38 s  900 kN  50 %",
            "  west.H2  201.0 kN     0 s",
        ]
    ) in re.sub(" +\n", "\n", text)
    assert "  commander       3  stage 3" in text
    assert re.search(r"\n  rope/tension +2  N\n", text)
    assert re.search(r"\n  /samples +6  heavylift.Samples\n", text)
    assert "  lift.yaml   13 B" in text


def test_the_command_info_shows_the_cause_of_a_failed_run(begin: Callable[[], Recorder]) -> None:
    path = begin().close("failed", "west: rope H1 broke at 12 s")
    assert "  status    failed: west: rope H1 broke at 12 s\n" in info(path)


@pytest.mark.parametrize(
    ("seconds", "text"), [(0.0, "0 s"), (3.21, "3.21 s"), (245.0, "4 min 05 s"), (3964.4, "1 h 06 min 04 s")]
)
def test_durations_in_messages_are_written_in_words(seconds: float, text: str) -> None:
    assert duration(seconds) == text


def test_plot_writes_a_picture_of_the_requested_format(recorded: Path, tmp_path: Path) -> None:
    png = plot(recorded, tmp_path / "run.png", {"loader 1": "west.H1", "loader 2": "west.H2"})
    svg = plot(recorded, tmp_path / "run.svg")
    assert png.read_bytes()[:8] == b"\x89PNG\r\n\x1a\n"
    assert ElementTree.parse(svg).getroot().tag == "{http://www.w3.org/2000/svg}svg"
    again = plot(recorded, tmp_path / "again.svg")
    assert svg.read_bytes() == again.read_bytes()


def test_recordings_that_cannot_be_plotted_are_reported(
    recorded: Path, begin: Callable[[], Recorder], tmp_path: Path
) -> None:
    cases: list[tuple[Path, Path, dict[str, str] | None, str]] = [
        (
            recorded,
            tmp_path / "run.pdf",
            None,
            f"{tmp_path}/run.pdf: the file name of a figure must end in .png or .svg; choose such a name",
        ),
        (
            recorded,
            tmp_path / "no" / "run.png",
            None,
            f"{tmp_path}/no/run.png: the folder {tmp_path}/no does not exist; "
            "create it or choose another folder with -o",
        ),
        (
            recorded,
            tmp_path / "run.png",
            {"loader 1": "east.H1"},
            f"{recorded}: the recording has no rope east.H1; it has west.H1, west.H2",
        ),
    ]
    for path, out, loaders, sentence in cases:
        with pytest.raises(RecordingError) as error:
            plot(path, out, loaders)
        assert str(error.value) == sentence
    bare = Recorder(tmp_path / "bare.mcap", {"scene": "bare"})
    bare.layout(SampleLayout([]))
    with pytest.raises(
        RecordingError, match=r"bare\.mcap: no tensions or joint positions are recorded to plot; record a scene"
    ):
        plot(bare.close(), tmp_path / "run.png")


def test_overlapping_labels_in_plots_are_moved_apart_and_keep_their_order() -> None:
    room = [100.0, 100.0, 95.0, 90.0]
    assert spread([10, 40, 60, 80], room, 10) == [10, 40, 60, 80]
    assert spread([50, 50, 50, 90], room, 10) == [40, 50, 60, 90]
    assert spread([0, 0, 0, 0], room, 10) == [0, 10, 20, 30]
    assert spread([99, 99, 99, 99], room, 10) == [60, 70, 80, 90]


def test_drawing_the_band_of_a_long_recording_with_few_points_keeps_its_extremes() -> None:
    t = np.linspace(0.0, 600.0, 120_001)
    low, high = np.sin(t), 1.5 + np.cos(t)
    high[77_777] = 9.0
    times, below, above = outline(t, low, high)
    assert len(times) <= FINE
    assert (below.min(), above.max()) == (low.min(), 9.0)
    assert [*map(list, outline(t[:9], low[:9], high[:9]))] == [list(t[:9]), list(low[:9]), list(high[:9])]


def test_plots_show_the_most_utilised_ropes_first_and_ropes_without_a_rating_last() -> None:
    peaks = np.array([[1.0, 50.0, 3.0, 9.0], [4.0, 40.0, 9.0, 10.0]])
    assert _most_used(["a", "b", "c", "d"], peaks, {"a": 5.0, "c": 10.0}) == ["c", "a", "b", "d"]


def test_plots_of_one_recording_are_written_to_files_with_distinct_names(
    recorded: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    files.plot(recorded)
    files.plot(recorded, lift=True)
    files.plot(recorded, ["rope/tension/*"])
    message = [line.removeprefix("wrote ") for line in capsys.readouterr().out.splitlines()]
    assert message == [f"{recorded.parent}/run{ending}" for ending in (".png", "-lift.png", "-signals.png")]


def test_a_recorded_lift_is_rendered_as_a_film(recorded: Path, tmp_path: Path) -> None:
    from PIL import Image

    with Image.open(storyboard(recorded, tmp_path / "lift.gif")) as film:
        assert (film.n_frames, film.info["comment"]) == (5, b"heavylift"), "of six samples"
    assert storyboard(recorded, tmp_path / "lift.gif", force=True) == tmp_path / "lift.gif"


@pytest.mark.parametrize(
    ("seconds", "digits", "text"),
    [(0.0, 0, "0:00"), (59.96, 1, "1:00.0"), (75.0, 0, "1:15"), (3963.0, 0, "1:06:03"), (7.25, 2, "0:07.25")],
)
def test_times_in_plots_are_written_in_hours_minutes_and_seconds(seconds: float, digits: int, text: str) -> None:
    assert clock(seconds, digits) == text
