"""The life of a recording: on disk at once, in order, named at the end, whole even if the run fails."""

from __future__ import annotations

import resource
import time
from collections.abc import Callable
from pathlib import Path

import msgspec
import numpy as np
import pytest
from heavylift.kernel import RecordingError
from heavylift.recordings import Peak, Recorder, Recording, RopeLine, SampleChannel, SampleLayout
from mcap.reader import NonSeekingReader, make_reader
from mcap.records import Metadata
from mcap.stream_reader import StreamReader
from numpy.typing import NDArray

Begin = Callable[[], Recorder]
Batch = Callable[[int, int], bytes]
Stage = Callable[[Recorder, int, str], None]
SECOND = 1_000_000_000


def test_a_recording_receives_its_final_name_once_it_is_complete(begin: Begin, tmp_path: Path) -> None:
    rec = begin()
    assert [path.name for path in tmp_path.iterdir()] == ["run.mcap.part"]
    assert rec.close() == tmp_path / "run.mcap"
    assert [path.name for path in tmp_path.iterdir()] == ["run.mcap"]
    assert rec.close() == tmp_path / "run.mcap"


def test_the_metadata_of_a_recording_are_on_disk_before_the_first_event(begin: Begin, tmp_path: Path) -> None:
    rec = begin()
    with (tmp_path / "run.mcap.part").open("rb") as stream:
        records = iter(StreamReader(stream).records)
        next(records)
        first = next(records)
    assert isinstance(first, Metadata)
    assert first.metadata["scene"] == "lift"
    rec.close()


def test_complete_data_of_a_recording_are_flushed_to_disk_once_a_second(
    begin: Begin, batch: Batch, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    clock = 0.0
    monkeypatch.setattr(time, "monotonic", lambda: clock)
    rec = begin()

    def on_disk() -> list[int]:
        with (tmp_path / "run.mcap.part").open("rb") as stream:
            found = []
            try:
                for _, _, message in NonSeekingReader(stream).iter_messages(["/samples"], log_time_order=False):
                    found.append(message.log_time // SECOND)
            except Exception:
                return found
        raise AssertionError("a part cannot have an end")

    rec.samples(batch(0, 3))
    rec.settle(2 * SECOND)
    assert on_disk() == []
    clock = 1.1
    rec.settle(2 * SECOND)
    assert on_disk() == [0, 1]
    rec.close()


def test_samples_and_events_that_arrive_in_any_order_are_written_in_order_of_time(
    begin: Begin, batch: Batch, stage: Stage
) -> None:
    rec = begin()
    stage(rec, 1, "hoist")
    stage(rec, 3, "lower")
    rec.samples(batch(0, 6))
    stage(rec, 4, "rest")
    path = rec.close()
    with path.open("rb") as stream:
        order = [
            (channel.topic, message.log_time / SECOND)
            for _, channel, message in NonSeekingReader(stream).iter_messages(
                ["/commander/stage", "/samples"], log_time_order=False
            )
        ]
    sample, events = "/samples", "/commander/stage"
    assert order == [
        (sample, 0.0),
        (events, 1.0),
        (sample, 1.0),
        (sample, 2.0),
        (sample, 2.5),
        (events, 3.0),
        (sample, 3.0),
        (events, 4.0),
        (sample, 4.0),
    ]


def test_a_long_batch_of_samples_is_written_into_several_chunks_row_by_row(begin: Begin) -> None:
    n = 2000
    rows = np.zeros((n, 20))
    rows[:, 0], rows[:, 6], rows[:, (12, 19)] = np.arange(n), np.arange(n), 1.0
    rec = begin()
    rec.ropes(0, [RopeLine("west.H1", "world", (0, 0, 9), "block", (0, 0, 0))])
    rec.samples(msgspec.msgpack.encode([0, [i * SECOND // 2 for i in range(n)], rows.tobytes()]))
    path = rec.close()
    with path.open("rb") as stream:
        assert len(make_reader(stream).get_summary().chunk_indexes) > 3
    with path.open("rb") as stream:
        topics = ["/samples", "/poses", "/ropes"]
        found = NonSeekingReader(stream, validate_crcs=True).iter_messages(topics, log_time_order=False)
        sentence = [(channel.topic, message.sequence, message.log_time) for _, channel, message in found]
    drawn = [("/ropes", i // 2) for i in range(n)]  # once a second, with every other sample
    assert sentence == [
        (topic, number, i * SECOND // 2)
        for i in range(n)
        for topic, number in [("/samples", i), ("/poses", i), *drawn[i : i + 1 - i % 2]]
    ]
    with path.open("rb") as stream:  # by the indexes of the chunks
        found = make_reader(stream, validate_crcs=True).iter_messages(["/ropes"])
        assert [message.sequence for _, _, message in found] == [*range(n // 2)]
    assert np.array_equal(Recording(path).signal("rope/tension").values[:, 0], np.arange(n))


def test_a_run_that_ends_with_an_error_leaves_a_recording_that_can_be_read_completely(
    begin: Begin, stage: Stage, tmp_path: Path
) -> None:
    def run() -> None:
        with begin() as rec:
            stage(rec, 0, "take up")
            raise ValueError("the girder is gone")

    with pytest.raises(ValueError, match="the girder is gone"):
        run()
    recording = Recording(tmp_path / "run.mcap")
    assert (recording.result["status"], recording.result["reason"]) == ("failed", "the girder is gone")
    assert [event.value["name"] for event in recording.events()] == ["take up"]


def test_all_data_of_a_recording_are_read_back_unchanged(recorded: Path, rows: NDArray[np.float64]) -> None:
    rec = Recording(recorded)
    t, tension, names, unit = rec.signal("rope/tension")
    assert list(t) == [0.0, 1.0, 2.0, 2.5, 3.0, 4.0]
    assert (names, unit) == (["west.H1", "west.H2"], "N")
    np.testing.assert_array_equal(tension, rows[:, 0:2])
    np.testing.assert_array_equal(rec.signal("pose/hook").values, rows[:, 13:20])
    assert rec.signals() == ["rope/tension", "rope/peak", "rope/peak_time", "pose/block", "pose/hook"]
    assert [(e.t_ns, e.value["name"]) for e in rec.events("commander", "stage")] == [
        (0, "take up"),
        (SECOND, "hoist"),
        (3 * SECOND, "lower"),
    ]
    assert rec.events("nobody") == []
    assert rec.attachments == {"lift.yaml": b"heavylift: 1\n"}
    assert rec.fact("energy") == {"closes": 1e-7}
    assert rec.fact("sim_s") == 4.0


def test_recorded_peaks_include_integration_steps_between_samples(begin: Begin, batch: Batch) -> None:
    rec = begin()
    rec.samples(batch(0, 2))
    rec.samples(batch(2, 6))
    assert rec.peaks == {"west.H1": Peak(451_000.0, 2.375), "west.H2": Peak(201_000.0, 0.0)}
    rec.close()


def test_the_recorder_skips_repeated_samples_and_refuses_a_gap_in_their_numbers(begin: Begin, batch: Batch) -> None:
    rec = begin()
    rec.samples(batch(0, 3))
    rec.samples(batch(1, 4))
    rec.samples(batch(0, 2))
    with pytest.raises(RecordingError) as error:
        rec.samples(batch(5, 6))
    assert str(error.value) == "samples 4 to 4 are missing; the sender lost them or sent out of order"
    assert len(Recording(rec.close()).signal("rope/tension").t) == 4


def test_kernel_notes_that_arrive_twice_with_samples_are_recorded_once(begin: Begin, batch: Batch) -> None:
    """Under their own times, in the digest; a sampler that starts again tells them again."""

    def noted(first: int, stop: int, *notes: tuple[int, int, str]) -> bytes:
        return msgspec.msgpack.encode([*msgspec.msgpack.decode(batch(first, stop)), notes])

    early, late = (0, 500_000_000, "a rope rattles"), (1, 3 * SECOND, "a mode is missed")
    digests = []
    for batches in (
        [batch(0, 6)],
        [noted(0, 6, early, late)],
        [noted(0, 3, early), noted(0, 5, early, late), batch(5, 6)],
    ):
        rec = begin()
        for one in batches:
            rec.samples(one)
        digests.append(rec.digest.hexdigest())
        found = Recording(rec.close()).notes()
    assert digests[0] != digests[1] == digests[2]
    assert found == [(0.5, "a rope rattles"), (3.0, "a mode is missed")]


def test_changed_lines_of_ropes_are_recorded_from_their_stated_time_on(begin: Begin, batch: Batch) -> None:
    rec = begin()
    line = RopeLine("r", "block", (0, 0, 0), "hook", (0, 0, 0))
    rec.ropes(0, [line])
    rec.samples(batch(0, 3))
    rec.ropes(2 * SECOND, [line, line])
    rec.samples(batch(3, 6))
    found = list(Recording(rec.close()).messages("/ropes"))
    sizes = [len(raw.data) for raw in found]
    assert [raw.log_time for raw in found] == [0, SECOND, 2 * SECOND, 3 * SECOND, 4 * SECOND]
    assert sizes[1] < sizes[2] == sizes[-1]


def test_a_protocol_message_has_the_log_time_that_the_recording_has_reached_and_a_separate_publish_time(
    begin: Begin, stage: Stage
) -> None:
    rec = begin()
    stage(rec, 3, "lower")
    rec.settle(4 * SECOND)
    rec.protocol(SECOND, "west", "from node", "DONE", {"next": 5}, b"")
    (raw,) = Recording(rec.close()).messages("/protocol/west")
    assert (raw.log_time, raw.publish_time) == (3 * SECOND, SECOND)


def test_a_folder_that_cannot_be_written_is_refused_before_a_run_is_recorded(tmp_path: Path) -> None:
    cases = {
        tmp_path: f"{tmp_path}: this is a folder; give the name of a file in it, such as {tmp_path}/run.mcap",
        tmp_path / "no" / "run.mcap": f"{tmp_path}/no/run.mcap: the folder {tmp_path}/no does not exist; "
        "create it or choose another folder with -o",
        Path("/proc/run.mcap"): "/proc/run.mcap: the file cannot be written (No such file or directory); "
        "choose another folder with -o",
    }
    for path, sentence in cases.items():
        with pytest.raises(RecordingError) as error:
            Recorder(path, {})
        assert str(error.value) == sentence


def test_a_full_disk_is_reported_by_a_run_in_one_sentence(begin: Begin, tmp_path: Path) -> None:
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    rec = begin()
    resource.setrlimit(resource.RLIMIT_FSIZE, (2000, hard))
    try:
        with pytest.raises(RecordingError) as error:
            rec.close()
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))
    assert str(error.value) == (
        f"{tmp_path}/run.mcap.part: the file cannot be written (File too large); choose another folder with -o"
    )


def test_the_recorder_refuses_events_on_undeclared_ports_and_topics_declared_twice(
    begin: Begin, batch: Batch, tmp_path: Path
) -> None:
    rec = begin()
    refused: dict[str, Callable[[], None]] = {
        "event of west.moved: this port was not announced; call add_port first": lambda: rec.event(
            0, 0, "west", "moved", 0, "Done", b"\x80"
        ),
        "topic /commander/stage: announced twice; models, ports and samples must have different names": lambda: (
            rec.add_port("commander", "stage", {"type": "object"})
        ),
        "rope line on girder: the samples have no pose of this body; check the name": lambda: rec.ropes(
            0, [RopeLine("r", "girder", (0, 0, 0), "hook", (0, 0, 0))]
        ),
        "samples from number 0: 1 rows of 20 values are 160 bytes, but 8 arrived; the sender's layout differs "
        "from the announced one": lambda: rec.samples(b"\x93\x00\x91\x00\xc4\x08" + bytes(8)),
    }
    for sentence, call in refused.items():
        with pytest.raises(RecordingError) as error:
            call()
        assert str(error.value) == sentence
    rec.close()
    bare = Recorder(tmp_path / "bare.mcap", {})
    with pytest.raises(RecordingError, match="samples arrived before their layout; announce the layout first"):
        bare.samples(batch(0, 1))
    bare.close()


@pytest.mark.parametrize(
    ("channels", "sentence"),
    [
        (
            [SampleChannel("rope/tension", ["a", "b"], "N", 0, 3)],
            "sample channel rope/tension: 2 names for the columns 0 to 3; give one name per column",
        ),
        (
            [SampleChannel("pose/block", ["x", "y", "z"], "m", 0, 3)],
            "sample channel pose/block: a pose has 7 columns (x y z qx qy qz qw), not 3",
        ),
        (
            [SampleChannel("energy", ["kinetic"], "J", 0, 1), SampleChannel("energy", ["work"], "J", 1, 2)],
            "sample channel energy: announced twice; name each topic once",
        ),
    ],
)
def test_a_sample_layout_that_does_not_fit_its_rows_is_refused(
    tmp_path: Path, channels: list[SampleChannel], sentence: str
) -> None:
    rec = Recorder(tmp_path / "run.mcap", {})
    with pytest.raises(RecordingError) as error:
        rec.layout(SampleLayout(channels))
    assert str(error.value) == sentence
    rec.close()
