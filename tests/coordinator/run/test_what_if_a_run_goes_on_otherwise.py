"""What if: a recorded run goes on otherwise from some time on; all before must be the recording's, or it is refused."""

from __future__ import annotations

import random
from pathlib import Path

import msgspec
import numpy as np
import pytest
from heavylift.coordinator.cli import main
from heavylift.coordinator.live import TimedCommand
from heavylift.coordinator.run import RunBranch, RunObserver, conversation, run
from heavylift.coordinator.run.branch import branch
from heavylift.kernel import HeavyliftError, ModelError, RecordingError, SceneError
from heavylift.nodes.devs import Tag, encode
from heavylift.nodes.models.parts import OperatorCommand
from heavylift.nodes.scene import load, spoken
from heavylift.recordings import Recording, compare

SLOWER = "stage up/all hooks=hoist 2 m/min by 1 m"
UP = 23.680119940  # when stage `up` begins [s]


class Heard(RunObserver):
    """Keeps what is said."""

    def __init__(self) -> None:
        self.said: list[str] = []

    def say(self, sentence: str) -> None:
        self.said.append(sentence)


@pytest.fixture(scope="module")
def lift(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("lift") / "lift.mcap"
    run("lift", path, in_process=True)
    return path


def branched(
    path: Path, at: str, *settings: str, out: Path, scene: Path | None = None, force: bool = False
) -> tuple[Path, list[str]]:
    """The new recording, and what was said."""
    heard = Heard()
    return branch(RunBranch.of(path, at, settings, scene), out, heard, force).recording, heard.said


def refusal(path: Path, at: str, *settings: str) -> str:
    with pytest.raises(HeavyliftError) as refused:
        branch(RunBranch.of(path, at, settings), path.with_name("refused.mcap"))
    assert not list(path.parent.glob("refused*")), "a branch that is refused leaves nothing"
    return str(refused.value)


def before(path: Path, tag: Tag) -> tuple[list[object], list[bytes]]:
    """Events and samples of a recording before a tag."""
    rec = Recording(path)
    rows = [
        (t, row.tobytes())
        for times, values in rec.blocks(rec.signals())
        for t, row in zip(times, np.hstack(values), strict=True)
    ]
    return [e for e in rec.events() if (e.t_ns, e.microstep) < tag], [row for t, row in rows if t < tag.t]


def begin(path: Path, stage: str) -> Tag:
    """Tag of the event with which a stage begins."""
    found = (e for e in Recording(path).events(port="stage") if e.value["name"] == stage)
    return next(Tag(e.t_ns, e.microstep) for e in found)


def digest(path: Path) -> str:
    return Recording(path).result["digest"]


def test_a_branch_goes_on_from_a_checkpoint_and_equals_the_run_of_the_changed_scene(lift: Path, tmp_path: Path) -> None:
    path, text = branched(lift, "stage up", SLOWER, out=tmp_path / "slower.mcap")
    assert text == [
        "continues from the checkpoint at 23.680 s",
        f"equal to {lift} up to 23.680 s (stage up), proved: 66 events and 62 samples came again",
    ]
    whole = run(load("lift", [SLOWER]), tmp_path / "whole.mcap", in_process=True)
    assert digest(path) == whole.digest != digest(lift)
    assert before(path, begin(lift, "up")) == before(lift, begin(lift, "up"))
    assert compare(lift, path).first.startswith("event at 23.680119940 s: commander.order_crane Order")
    fact = Recording(path).fact("branch")
    assert fact == {"of": "lift.mcap", "digest": digest(lift), "t": UP, "stage": "up"}


def test_a_branch_of_a_recorded_run_can_be_branched_again(lift: Path, tmp_path: Path) -> None:
    first, _ = branched(lift, "stage up", SLOWER, out=tmp_path / "first.mcap")
    settings = [SLOWER, "stage sideways/trolleys=traverse 10 m/min by 1 m"]
    second, text = branched(first, "end of stage up", settings[1], out=tmp_path / "second.mcap")
    assert text[0] == "continues from the checkpoint at 54.347 s"
    assert digest(second) == run(load("lift", settings), tmp_path / "whole.mcap", in_process=True).digest
    _, text = branched(second, "stage lift off", "end=30 s", out=tmp_path / "early.mcap")
    assert text[0] == "continues from the checkpoint at 9.148 s", "those of the past are passed on"


def test_a_changed_order_is_refused_if_it_would_act_before_the_branch_point(lift: Path) -> None:
    message = refusal(lift, "stage up", "block.mass=310 t")
    assert "the changes affect the run before 23.680 s (stage up), at (0 s, 0) on " in message
    assert "300000.0 -> 310000.0" in message
    message = refusal(lift, "stage sideways", SLOWER)
    assert "at (23.68011994 s, " in message
    assert "on /commander/order_crane: recorded " in message
    assert "actions[2].orders[0].speed 0.05 -> 0.0333" in message
    assert "before 23.680 s" in refusal(lift, "stage up", "tolerance=1e-7"), (
        "the recorded accuracy is kept, unless it is named"
    )
    assert "tolerance" in refusal(lift, "stage up", "accuracy=0.1 %")


def test_a_branch_whose_mechanics_are_changed_is_simulated_from_its_start(lift: Path, tmp_path: Path) -> None:
    sling = "stage sideways/when=moves done and tension of loader-1.sling-1 >= 350 kN"
    assert 'recorded nothing, now {"Order"' in refusal(lift, "end of stage up", sling), "it is watched before"
    path, text = branched(lift, "stage up", sling, out=tmp_path / "b.mcap")
    assert text[0] == "simulates from the start: the mechanics of the new scene differ"
    assert text[1].startswith(f"equal to {lift} up to 23.680 s (stage up), proved: 66 events")
    assert digest(path) == run(load("lift", [sling]), tmp_path / "whole.mcap", in_process=True).digest


def test_an_edited_scene_replaces_the_recorded_one_in_a_branch(lift: Path, tmp_path: Path) -> None:
    edited = tmp_path / "edited.yaml"
    text = Recording(lift).attachments["lift.yaml"].decode()
    edited.write_text(text.replace("traverse 20 m/min by 2 m", "traverse 5 m/min by 1 m"))
    path, _ = branched(lift, "0:40", out=tmp_path / "b.mcap", scene=edited)
    assert digest(path) == run(edited, tmp_path / "whole.mcap", in_process=True).digest


@pytest.mark.parametrize(
    ("at", "told"),
    [
        ("stage turn", "there is no stage 'turn'; there are take up slack, lift off, up, sideways, swing"),
        ("stage upp", "there is no stage 'upp'; did you mean up?"),
        ("end of stage swing", "swing is the last stage; there is nothing after it to branch into"),
        ("stage take up slack", "nothing lies before it; run the scene instead"),
        ("0", "nothing lies before it"),
        ("2:00", "the run ended at 77.329 s"),
        ("soon", "write 'stage NAME', 'end of stage NAME', or a time such as 2:00"),
        ("-5 s", "write 'stage NAME'"),
        ("nan", "write 'stage NAME'"),
    ],
)
def test_an_invalid_branch_time_is_refused_with_the_option_and_the_reason(lift: Path, at: str, told: str) -> None:
    with pytest.raises(RecordingError) as refused:
        RunBranch.of(lift, at, [SLOWER])
    assert f"{lift}: --at '{at}': " in str(refused.value)
    assert told in str(refused.value)


def test_changes_of_a_scene_that_rule_out_a_branch_are_reported(
    lift: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    with pytest.raises(SceneError, match="the branch changes nothing"):
        RunBranch.of(lift, "stage up")
    with pytest.raises(SceneError, match=r"the end 20 s is before the branch point 23\.680 s"):
        RunBranch.of(lift, "stage up", ["end=20 s"])
    with pytest.raises(RecordingError, match="is the recording itself, which will not be overwritten"):
        branch(RunBranch.of(lift, "stage up", [SLOWER]), lift, force=True)
    other = tmp_path / "other.mcap"
    other.write_bytes(b"mine")
    with pytest.raises(HeavyliftError, match="a file that heavylift has not made"):
        branch(RunBranch.of(lift, "stage up", [SLOWER]), other, force=True)
    assert other.read_bytes() == b"mine"
    monkeypatch.setattr("heavylift.coordinator.run.branch.__version__", "9.9")
    with pytest.raises(RecordingError, match=r"was made by heavylift \S+, this is 9\.9, .*; "):
        RunBranch.of(lift, "stage up", [SLOWER])


def test_branching_a_run_does_not_overwrite_existing_files(
    lift: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    mine = tmp_path / "lift.mcap"
    mine.write_bytes(lift.read_bytes())
    monkeypatch.setattr("sys.argv", ["heavylift", "branch", str(mine), "--at", "stage up", "--set", "end=30 s"])
    for _ in range(2):
        main()
    assert sorted(path.name for path in tmp_path.iterdir()) == [
        "lift-branch-2.mcap",
        "lift-branch.mcap",
        "lift.mcap",
    ]


def test_a_branch_of_a_recording_whose_checkpoints_are_damaged_is_simulated_from_the_start(
    lift: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(Recording, "checkpoint", lambda self, at: b"\x93\x01\x02\x03")
    path, text = branched(lift, "stage up", "end=30 s", out=tmp_path / "damaged.mcap")
    assert text[0] == "simulates from the start: its checkpoint is damaged, or too old"
    monkeypatch.setattr(Recording, "checkpoints", {})
    same, text = branched(lift, "stage up", "end=30 s", out=tmp_path / "without.mcap")
    assert text[0] == "simulates from the start: the recording has no checkpoint before the branch"
    assert digest(path) == digest(same)


def test_recording_checkpoints_of_nodes_does_not_change_messages_and_samples(
    lift: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(conversation, "KEEP_s", 0.0)
    run("lift", tmp_path / "many.mcap", in_process=True)
    few, many = Recording(lift), Recording(tmp_path / "many.mcap")
    assert [t / 1e9 for t, _ in few.checkpoints] == [9.147880475, UP, 44.68011994, 57.329230581]
    assert set(few.checkpoints) < set(many.checkpoints)
    assert few.result["digest"] == many.result["digest"]
    counted = [{topic.name: topic.messages for topic in rec.topics.values()} for rec in (few, many)]
    assert counted[0] == counted[1]


def test_a_branch_repeats_the_commands_of_an_operator(tmp_path: Path) -> None:
    scene = load("lift", ["end=12 s"])
    words = "crane: travel 10 m/min by 0.2 m"
    order = encode(OperatorCommand(words, msgspec.msgpack.encode(spoken(scene, words))))
    given = [TimedCommand(Tag(2 * 10**9), order), TimedCommand(Tag(11 * 10**9), order)]
    run(scene, tmp_path / "a.mcap", in_process=True, commands=given)
    path, _ = branched(tmp_path / "a.mcap", "10 s", "end=14 s", out=tmp_path / "b.mcap")
    whole = run(load("lift", ["end=14 s"]), tmp_path / "c.mcap", in_process=True, commands=given)
    assert digest(path) == whole.digest
    assert len(Recording(path).events("operator")) == 2


def test_a_failed_run_is_branched_from_the_point_of_failure(tmp_path: Path) -> None:
    never = ["stage swing/when=moves done and tension of loader-1.sling-1 >= 9 MN", "stage swing/timeout=13 s"]
    with pytest.raises(ModelError, match="timeout of 13 s"):
        run(load("lift", [*never, "end=60 s"]), tmp_path / "a.mcap", in_process=True)
    path, text = branched(tmp_path / "a.mcap", "stage sideways", "stage swing/timeout=30 s", out=tmp_path / "b.mcap")
    assert text[0] == "continues from the checkpoint at 44.680 s"
    assert Recording(path).result["status"] == "finished"


@pytest.mark.parametrize("name", ["lift", "snatch", "tackle", "linkage", "trolley", "gust"])
def test_a_branch_without_changes_from_any_time_has_the_digest_of_the_run(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(conversation, "KEEP_s", 0.0)  # a checkpoint at each GRANT of the kernel
    end = run(name, tmp_path / "a.mcap", in_process=True)
    choice = random.Random(name)
    for i in range(2):
        at = choice.uniform(0.01, end.sim_s)
        path, _ = branched(tmp_path / "a.mcap", f"{at:.9f} s", "name=again", out=tmp_path / f"{i}.mcap")
        assert digest(path) == end.digest
