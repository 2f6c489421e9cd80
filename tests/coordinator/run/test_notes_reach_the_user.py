"""What the kernel says of a run reaches the user: as it comes, at the end, in the recording and all that reads it; the
same words, in the same digest, whether the nodes share a process or not."""

import json
from pathlib import Path

import msgspec
import pytest
from command import finish
from heavylift.coordinator.participants import KernelNode, RowFrames, configured
from heavylift.coordinator.replay import RecordedRun
from heavylift.coordinator.run import RunObserver, run
from heavylift.coordinator.run.verify import verify
from heavylift.kernel.description import Note
from heavylift.nodes.devs import Tag
from heavylift.nodes.models import build
from heavylift.nodes.scene import parse
from heavylift.recordings import Recording
from heavylift.recordings.documents import report
from heavylift.recordings.read import info, info_data

SECOND = 10**9
HEAD = "heavylift: 1\nname: hung\nend: 4 s\nsamples: 20 Hz\n"
LOAD = """\
mechanism:
  bodies:
    load: {{mass: {mass}}}
  joints:
    guide: {{type: prismatic, child: load, axis: [0, 0, 1], start: {start}}}
  ropes:
    rope: {{start: {{body: world}}, end: {{body: load}}, length: 60 m, EA: {EA}}}
"""
BOUNCING = LOAD.format(mass="450 t", start="-60.1 m", EA="1870 MN")
MISSES = HEAD + "method: radau5\nstep: 200 ms\n" + BOUNCING
FOLLOWS = HEAD + BOUNCING
RATTLES = HEAD + LOAD.format(mass="0.005 kg", start="-60 m, speed: -1e-5 m/s", EA="187000 MN")
"""A load as light as a bolt on a rope far too stiff for it."""


class Listening(RunObserver):
    """Remembers what it is reported."""

    def __init__(self) -> None:
        self.message: list[str] = []

    def say(self, sentence: str) -> None:
        self.message.append(sentence)


@pytest.mark.parametrize(
    ("text", "word"),
    [(MISSES, "step 0.2 s at 0.000 s: method 'radau5' is out of step"), (RATTLES, "it goes slack and taut at")],
    ids=["a mode that steps miss", "a rope that rattles"],
)
@pytest.mark.large(beyond=1)
def test_a_note_of_the_kernel_is_shown_in_every_output(text, word, tmp_path: Path):
    path, watch = tmp_path / "hung.mcap", Listening()
    result = run(parse(text), path, in_process=True, watch=watch)
    assert any(word in note for note in result.notes)
    assert tuple(watch.message) == result.notes
    rec = Recording(path)
    assert tuple(sentence for _, sentence in rec.notes()) == result.notes
    assert result.notes[0] in info(path)
    assert info_data(path)["notes"][0]["sentence"] == result.notes[0]
    page = report(path, tmp_path / "hung.html").read_text()
    assert "Notes of the kernel" in page
    assert "note: " not in page


def test_a_run_for_which_the_kernel_gives_no_notes_shows_no_notes(tmp_path: Path):
    path = tmp_path / "hung.mcap"
    assert run(parse(FOLLOWS), path, in_process=True).notes == ()
    assert Recording(path).notes() == []
    assert "Notes of the kernel" not in report(path, tmp_path / "hung.html").read_text()


@pytest.mark.parametrize("text", [MISSES, RATTLES], ids=["misses", "rattles"])
@pytest.mark.large(beyond=1)
def test_a_run_in_several_processes_has_the_notes_and_the_digest_of_a_run_in_one_process(text, tmp_path: Path):
    alone = run(parse(text), tmp_path / "alone.mcap", in_process=True)
    apart = run(parse(text), tmp_path / "apart.mcap")
    assert alone.notes
    assert (apart.notes, apart.digest) == (alone.notes, alone.digest)
    assert verify(RecordedRun(tmp_path / "apart.mcap")).digest == alone.digest


@pytest.mark.large
def test_the_terminal_shows_a_kernel_note_at_once_and_at_the_end_of_the_run(tmp_path: Path):
    scene = tmp_path / "hung.yaml"
    scene.write_text(MISSES)
    code, out, err = finish(tmp_path, "run", scene.name, "--in-process")
    assert code == 0
    assert "is out of step" in err
    assert "note: step 0.2 s at 0.000 s" in out
    code, out, _ = finish(tmp_path, "run", scene.name, "--in-process", "-o", "b.mcap", "--json")
    assert code == 0
    assert "is out of step" in json.loads(out)["notes"][0]


def test_a_kernel_restored_from_a_snapshot_does_not_repeat_earlier_notes():
    """The note of the start has been told; one that rattles later is numbered on."""
    plan = parse(MISSES).plan
    message, again = list[bytes](), list[bytes]()
    first, second = (KernelNode(configured(plan, build(plan)), RowFrames(out.append)) for out in (message, again))
    first.start()
    first.advance(Tag(0, 1), [], Tag(SECOND))
    assert [note for batch in message for note in numbers(batch)] == [0]
    second.start()
    again.clear()
    second.restore(first.snapshot())
    second.advance(Tag(SECOND), [], Tag(3 * SECOND))
    assert [note for batch in again for note in numbers(batch)] == []
    second.simulation.notes.append(Note(3 * SECOND, "something new"))
    second.finish(Tag(3 * SECOND + 1))
    assert [note for batch in again for note in numbers(batch)] == [1]


def numbers(batch: bytes) -> list[int]:
    """Of the notes in a batch of samples as it travels."""
    _, _, _, *notes = msgspec.msgpack.decode(batch)
    return [number for number, _, _ in notes[0]] if notes else []
