"""A recording of each format version: today's program reads those that it promises to read, and says of the others who
made them and what to do."""

from __future__ import annotations

from pathlib import Path

import pytest
from heavylift.kernel import RecordingError
from heavylift.kernel.version import __version__
from heavylift.nodes.plan import encode
from heavylift.nodes.scene import load
from heavylift.recordings import Recording, recover
from heavylift.recordings.documents import scene_table
from heavylift.recordings.format import plan_of, unread
from heavylift.recordings.read import amended, info
from heavylift.recordings.write import FORMAT, OLDEST
from mcap.reader import make_reader
from mcap_protobuf.decoder import DecoderFactory
from spoiled_recordings import read_in_all_ways

FILES = Path(__file__).parent.parent / "data" / "recordings"
g, START, LENGTH = 9.80665, -29.5, 30.0  # of a block that hangs on a slack rope [m], and of that [m]
TAUT = (2.0 * (LENGTH + START) / g) ** 0.5  # when the block has fallen into its rope [s]
STEPS = 1e-8  # in which numbers are recorded, and more
READABLE = range(OLDEST, FORMAT + 1)


def golden(number: int) -> Path:
    return FILES / f"format-{number}.mcap"


def test_each_recording_format_has_a_stored_example() -> None:
    assert sorted(FILES.glob("*.mcap")) == [golden(number) for number in range(1, FORMAT + 1)]
    assert all(path.stat().st_size < 60e3 for path in FILES.glob("*.mcap"))


@pytest.mark.parametrize("number", READABLE)
def test_every_reader_reads_each_recording_format(number: int, tmp_path: Path) -> None:
    text = read_in_all_ways(golden(number), golden(number), tmp_path, pictures=True)
    assert text == [f"{golden(number)}: the file is complete and undamaged; there is nothing to recover"]


@pytest.mark.parametrize("number", READABLE)
def test_stored_recordings_of_each_format_show_a_block_that_falls_into_its_slack_rope(number: int) -> None:
    rec = Recording(golden(number))
    pose, rope = rec["block"].pose, rec.signal("rope/tension")
    t = pose.t[pose.t <= TAUT]
    assert pose["z"][: len(t)] == pytest.approx(START - 0.5 * g * t**2, abs=STEPS)
    assert not rope.values[rope.t < TAUT].any()
    assert rope.values[(rope.t > TAUT) & (rope.t < TAUT + 0.1)].all()
    (first, *_) = [e for e in rec.events("kernel") if e.value["what"] == "taut"]
    assert (first.value["name"], first.t_ns * 1e-9) == ("fall", pytest.approx(TAUT, abs=STEPS))
    assert rec.stages() == [(0.0, "fall and bounce")]


def test_reading_a_plan_of_an_earlier_version_gives_a_note_that_lists_the_parts_not_read() -> None:
    message = "of an earlier version: cranes, slings and block are not listed; run the scene again for them"
    assert f"  plan      {message}" in info(golden(2)).splitlines()
    rec = Recording(golden(2))
    assert ("plan", message) in scene_table(rec, plan_of(rec.attachments))


def test_a_plan_recorded_by_the_present_version_is_read_without_a_note() -> None:
    assert not unread(plan_of({"resolved.json": encode(load("lift").plan)}))
    assert not unread({}), "a DEVS model has none"


@pytest.mark.parametrize("number", READABLE)
def test_the_standard_mcap_library_finds_the_sample_times_that_heavylift_reads(number: int) -> None:
    with golden(number).open("rb") as stream:
        text = make_reader(stream, decoder_factories=[DecoderFactory()]).iter_decoded_messages(["/samples"])
        times = [message.log_time * 1e-9 for _, _, message, _ in text]
    assert Recording(golden(number)).signal("energy").t.tolist() == pytest.approx(times, abs=1e-9)


@pytest.mark.parametrize("number", range(1, OLDEST))
def test_an_unsupported_recording_format_is_reported(number: int) -> None:
    message = f"the recording has format {number}, but this is heavylift {__version__}, which reads format {FORMAT}; "
    message += "run the scene again"
    with pytest.raises(RecordingError) as caught:
        Recording(golden(number))
    assert str(caught.value) == f"{golden(number)}: {message}, or install heavylift 0.1.0, which made it"


def test_a_recovered_or_amended_recording_names_the_version_of_heavylift_that_computed_it(tmp_path: Path) -> None:
    """What was cut off or amended is still of the heavylift that computed it."""
    whole = golden(FORMAT).read_bytes()
    made = Recording(golden(FORMAT)).library
    assert made.startswith("heavylift 0.2.0.dev1385+g96c95ba37 ")
    part = tmp_path / "run.mcap.part"
    part.write_bytes(whole[: len(whole) // 2])
    saved = recover(part, begun=True).path
    assert Recording(saved).library == made
    assert Recording(amended(saved, {"seen": True})).library == made
