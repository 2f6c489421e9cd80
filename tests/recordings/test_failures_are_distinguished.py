"""Damage, other programs, libraries that fail, a system that refuses: each has a sentence of its own."""

from __future__ import annotations

import errno
import json
import sys
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from altered_recordings import Parts, altered
from heavylift.kernel import RecordingError, extra
from heavylift.recordings import Recording, curves, export, info, info_data, plot, recover, report, storyboard, view
from heavylift.recordings.documents import facts, tables_of
from spoiled_recordings import CHUNK, records

NO_NUMBERS = ["NaN", "Infinity", "-Infinity", "1e999", '"NaN"', "null", "[]", '{"a":NaN}']


@pytest.fixture
def library(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Callable[[str], None]]:
    """A library of a user's that does this when it is imported."""

    def write(text: str) -> None:
        (tmp_path / "site-packages" / "oldlib.py").write_text(text)

    (tmp_path / "site-packages").mkdir()
    monkeypatch.syspath_prepend(tmp_path / "site-packages")
    yield write
    sys.modules.pop("oldlib", None)


@pytest.mark.parametrize(
    ("text", "call", "told"),
    [
        ("raise ValueError('numpy.dtype size changed')", "", "numpy.dtype size changed"),
        ("raise ImportError('needs numpy 3')", "", "needs numpy 3"),
        ("import no_such_library", "", "No module named 'no_such_library'"),
        ("def f(): raise TypeError('another signature')", "f", "another signature"),
        ("", "f", "module 'oldlib' has no attribute 'f'"),
    ],
)
def test_an_error_raised_by_a_third_party_library_names_the_library(
    text: str, call: str, told: str, recorded: Path, library: Callable[[str], None]
) -> None:
    library(text)

    def use() -> None:
        import oldlib  # type: ignore[import-not-found]

        getattr(oldlib, call)() if call else None

    with pytest.raises(RecordingError) as error, Recording(recorded).reading():
        use()
    answer = str(error.value)
    assert "the library " in answer
    assert told in answer
    assert "damaged" not in answer


def test_an_installed_optional_package_that_fails_to_import_is_reported_by_name(library: Callable[[str], None]) -> None:
    missing = RecordingError("install it")
    library("raise ValueError('numpy.dtype size changed')")
    with pytest.raises(RecordingError, match=r"oldlib is installed but fails \(numpy\.dtype size changed\)"):
        extra("oldlib", missing)
    with pytest.raises(RecordingError, match="install it"):
        extra("no_such_library", missing)


@pytest.mark.parametrize(
    ("error", "told"),
    [
        (OSError(errno.EIO, "Input/output error"), "cannot be read: Input/output error; look after the disk"),
        (MemoryError(), "cannot be read: there is too little memory"),
    ],
)
def test_an_operating_system_error_during_reading_is_not_reported_as_damage(
    error: Exception, told: str, recorded: Path
) -> None:
    with pytest.raises(RecordingError, match=told), Recording(recorded).reading():
        raise error


def test_every_command_that_reads_a_damaged_recording_suggests_recover(recorded: Path, tmp_path: Path) -> None:
    data = bytearray(recorded.read_bytes())
    place, length = next((place, length) for opcode, place, length in records(bytes(data)) if opcode == CHUNK)
    data[place + 9 + length // 2] ^= 0x55
    path = tmp_path / "turned.mcap"
    path.write_bytes(data)
    distances: list[Callable[[], object]] = [
        lambda: plot(path, tmp_path / "x.png"),
        lambda: export(path, tmp_path / "x.csv"),
        lambda: report(path, tmp_path / "x.html"),
        lambda: view(path, tmp_path / "y.html"),
        lambda: storyboard(path, tmp_path / "z.png"),
        lambda: curves(path, ["rope/*"], tmp_path / "x.svg"),
        lambda: info(path),
        lambda: Recording(path).events(),
    ]
    for distance in distances:
        with pytest.raises(RecordingError, match=rf"is damaged \(.*\); `heavylift recover {path}` saves"):
            distance()
    assert [x.name for x in tmp_path.iterdir() if x.suffix in (".png", ".csv", ".html", ".svg")] == []


def test_no_error_message_suggests_the_command_recover_for_a_recording_that_another_program_has_altered(
    recorded: Path, tmp_path: Path
) -> None:
    def spoil(parts: Parts) -> None:
        i = parts.rows()[0]
        parts.messages[i] = parts.messages[i]._replace(data=parts.messages[i].data[:-1])

    path = altered(recorded, tmp_path / "changed.mcap", spoil)
    with pytest.raises(
        RecordingError, match=r"has contents that no run writes \(.*\), though no byte is damaged: another pro"
    ):
        Recording(path).signal("rope/tension")
    with pytest.raises(RecordingError, match="is complete and undamaged; there is nothing to recover"):
        recover(path)


@pytest.mark.parametrize("text", NO_NUMBERS)
@pytest.mark.parametrize("name", ["sim_s", "wall_s", "samples", "peaks", "rated"])
def test_reading_a_recording_with_infinite_values_ends_with_a_one_sentence_error(
    name: str, text: str, recorded: Path, tmp_path: Path
) -> None:
    path = altered(recorded, tmp_path / "no.mcap", lambda parts: parts.metadata["result"].update({name: text}))
    distances: list[Callable[[], object]] = [
        lambda: info(path),
        lambda: info_data(path),
        lambda: tables_of(facts(Recording(path))),
        lambda: Recording(path)._repr_html_(),
        lambda: plot(path, tmp_path / "x.png"),
        lambda: view(path, tmp_path / "y.html"),
    ]
    sentences = []
    for distance in distances[: None if text == "NaN" else 3]:
        try:
            distance()
        except RecordingError as error:
            sentences.append(str(error))
    assert not [x for x in sentences if "\n" in x]
    if name != "wall_s" and text not in ("null", "[]"):
        assert sentences or name == "rated"


def test_the_command_info_detects_an_altered_digest_or_peak_in_a_recording(recorded: Path, tmp_path: Path) -> None:
    def forge(parts: Parts) -> None:
        result = parts.metadata["result"]
        peaks = json.loads(result["peaks"])
        peaks["west.H1"]["tension"] *= 0.9
        result |= {"digest": "0" * 64, "peaks": json.dumps(peaks), "samples": "5"}

    path = altered(recorded, tmp_path / "forged.mcap", forge)
    message = info(path)
    assert "the result says " + "0" * 64 in message
    assert "the peak of west.H1 is 451 kN in the rows, the result says 405.9 kN" in message
    assert "there are 6 samples, the result says 5" in message
    assert len(info_data(path)["wrong"]) == 3
    assert info_data(recorded)["wrong"] == []
