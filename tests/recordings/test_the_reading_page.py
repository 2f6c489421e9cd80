"""Every block of READING.md does what it says, and a notebook sees tables and curves."""

from __future__ import annotations

import importlib.util
import re
from collections.abc import Callable
from pathlib import Path
from xml.etree import ElementTree

import msgspec
import numpy as np
import pytest
from heavylift.kernel import RecordingError
from heavylift.recordings import RecordedPart, Recorder, Recording, Signal
from heavylift.recordings.format import mcapfile
from heavylift.recordings.read import MESSAGE, RECORD, tables_of
from small_run import SECOND

PAGE = Path(__file__).parents[2] / "recordings/READING.md"


def test_the_code_blocks_on_the_documentation_page_about_reading_recordings_can_be_executed(
    recorded: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(recorded.parent)
    text = PAGE.read_text()
    assert len(text.splitlines()) <= 80
    names: dict[str, object] = {}
    blocks = re.findall(r"```python\n(.*?)```", text, re.S)
    assert len(blocks) == 5
    for block in blocks:
        exec(compile(block, str(PAGE), "exec"), names)


def test_reading_one_signal_of_a_recording_reads_no_other_data(recorded: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    rec = Recording(recorded)
    asked: list[str] = []
    plain = rec.numbers
    monkeypatch.setattr(rec, "numbers", lambda forms, only=None: (asked.extend(forms), plain(forms, only))[1])
    rec.load(["rope/tension", "rope/peak"])
    assert isinstance(rec["rope/tension"], Signal)
    assert asked == ["/samples"], "once for both, and no poses"


@pytest.mark.parametrize("seed", range(3))
def test_reading_selected_samples_gives_the_recorded_values_without_unpacking_other_chunks(
    seed: int, begin: Callable[[], Recorder], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(mcapfile, "CHUNK", 4096)
    random = np.random.default_rng(seed)
    with begin() as recorder:
        rows = np.rint(random.normal(size=(400, 20)) * 2.0**20)
        recorder.samples(msgspec.msgpack.encode([0, [i * SECOND for i in range(400)], rows.tobytes()]))
    names, chosen = ["rope/tension", "pose/hook"], np.unique(random.integers(400, size=5))
    rec, unpacked = Recording(tmp_path / "run.mcap"), list[int]()
    all_ = {name: rec.signal(name) for name in names}
    plain = rec._file._unpack
    monkeypatch.setattr(rec._file, "_unpack", lambda x: (unpacked.append(x.chunk_start_offset), plain(x))[1])
    found = rec.picked(names, chosen)
    assert all(np.array_equal(found[name].values, all_[name].values[chosen]) for name in names)
    assert found["pose/hook"].t.tolist() == chosen.tolist()
    assert len(unpacked) <= 2 * len(chosen) < len(rec._file.summary.chunk_indexes)


def test_a_part_of_a_recording_offers_its_signals_as_python_attributes(recorded: Path) -> None:
    rec = Recording(recorded)
    block, rope = rec["block"], rec["west.H1"]
    assert isinstance(block, RecordedPart)
    assert isinstance(rope, RecordedPart)
    assert block.signals == ["pose/block"]
    assert {"tension", "peak", "peak_time"} <= set(dir(rope))
    assert np.array_equal(rope.tension.values[:, 0], rec.signal("rope/tension").values[:, 0])
    both = rec["pose/*"]
    assert isinstance(both, RecordedPart)
    assert both.pose.names[6:9] == ["block.qw", "hook.x", "hook.y"]
    with pytest.raises(AttributeError, match="block has no tension; there are pose"):
        _ = block.tension


@pytest.mark.parametrize(
    ("name", "meant"),
    [
        ("Rope/Tension", "did you mean rope/tension?"),
        ("blok", "did you mean block?"),
        ("west.H3", "did you mean west.H2 or west.H1 or west?"),
        ("girder", "there are rope/tension, rope/peak, rope/peak_time, pose/block, pose/hook, block, hook, west, "),
    ],
)
def test_the_error_for_an_unknown_name_in_a_recording_lists_the_known_names(
    recorded: Path, name: str, meant: str
) -> None:
    for error in (KeyError, RecordingError):
        with pytest.raises(error) as caught:
            Recording(recorded)[name]
        assert str(caught.value).startswith(f"{recorded}: the recording has no signal or part {name}; {meant}")
    with pytest.raises(KeyError, match=r"rope/tension has no column west\.h1; did you mean west\.H"):
        Recording(recorded).signal("rope/tension")["west.h1"]


def test_a_python_notebook_shows_recordings_as_tables_and_curves(recorded: Path) -> None:
    rec = Recording(recorded)
    page = rec._repr_html_()
    root = ElementTree.fromstring(f"<div>{page}</div>")
    cells = [cell.text for cell in root.iter("td")]
    assert {"lift", "finished", "take up", "rope/tension", "west.H1, west.H2", "block, hook"} <= set(cells)
    assert len(list(root.iter("polyline"))) == 2
    signal = ElementTree.fromstring(f"<div>{rec.signal('rope/tension')._repr_html_()}</div>")
    assert [cell.text for cell in signal.iter("td")][:6] == ["west.H1", "100000", "0 s", "450000", "2.5 s", "100000"]


def test_names_in_a_recording_cannot_become_markup(begin: Callable[[], Recorder], tmp_path: Path) -> None:
    evil = "<script>alert(1)</script>"
    with Recorder(tmp_path / "evil.mcap", {"scene": evil}) as rec:
        rec.log(0, "info", "x", "x")
    assert "<script" not in Recording(tmp_path / "evil.mcap")._repr_html_()
    signal = Signal(np.array([0.0, 1.0]), np.array([[0.0], [1.0]]), [evil], evil, evil)
    assert "<script" not in signal._repr_html_()


@pytest.mark.skipif(importlib.util.find_spec("pandas") is None, reason="pandas is not installed (extra pandas)")
def test_a_recorded_signal_converts_to_a_data_frame(recorded: Path) -> None:
    frame = Recording(recorded).signal("pose/hook").to_pandas()
    assert frame.index.name == "time [s]"
    assert [*frame.columns] == ["x [m]", "y [m]", "z [m]", "qx [1]", "qy [1]", "qz [1]", "qw [1]"]
    assert frame["qw [1]"].iloc[0] == Recording(recorded).signal("pose/hook").values[0, 6]


@pytest.mark.parametrize("seed", range(3))
def test_a_table_of_recorded_messages_keeps_the_order_that_they_have_in_a_chunk(seed: int) -> None:
    random = np.random.default_rng(seed)
    length = {1: 40, 2: 40, 3: 7}
    order = random.choice([1, 2, 3], 40).tolist() + 30 * random.permutation([1, 2, 3]).tolist() + 25 * [2] + [1, 1, 3]
    sent = {1: [], 2: [], 3: []}  # type: dict[int, list[tuple[int, bytes]]]
    data = b""
    for t, channel in enumerate(order):
        body = random.bytes(length[channel] if t % 50 else 9)
        sent[channel].append((t, body))
        data += RECORD.pack(5, 22 + len(body)) + MESSAGE.pack(channel, t, 0, t) + body
    found: dict[int, list[tuple[int, bytes]]] = {1: [], 3: []}
    for table in tables_of(data, {1, 3}):
        found[table.channel] += [(t, x.tobytes()) for t, x in zip(table.times.tolist(), table.data, strict=True)]
    assert found == {1: sent[1], 3: sent[3]}
    with pytest.raises(ValueError, match="incomplete record"):
        list(tables_of(data[:-1], {1, 3}))
