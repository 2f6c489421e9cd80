"""`lifts:` combines scenes: each lift moves as it does alone, at its place, by its own action list."""

from __future__ import annotations

from pathlib import Path

import msgspec
import pytest
from heavylift.coordinator.live import STOP, TimedCommand
from heavylift.coordinator.record import play
from heavylift.coordinator.replay import RecordedRun
from heavylift.coordinator.run import run
from heavylift.coordinator.run.verify import verify
from heavylift.kernel import SceneError
from heavylift.nodes.devs import Tag, encode, seconds
from heavylift.nodes.models.parts import OperatorCommand
from heavylift.nodes.plan import plan
from heavylift.nodes.scene import check, load, parse, spoken
from heavylift.recordings import Recording, Signal

TEXT = """\
heavylift: 1
name: two
accuracy: 0.1 %
samples: 5 Hz
lifts:
  a: {extends: hall}
  b: {extends: hall, at: [3 m, 40 m], start: 7 s}
"""


def last_at(signal: Signal) -> dict[float, float]:
    """By time its value, after what happened then."""
    return dict(zip(signal.t.tolist(), signal.values[:, 0].tolist(), strict=True))


@pytest.fixture(scope="module")
def runs(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Recording]:
    """Both lifts in one run, and the one alone."""
    folder: Path = tmp_path_factory.mktemp("runs")
    run(parse(TEXT), folder / "two.mcap", in_process=True)
    run(parse(TEXT.split("  b:")[0]), folder / "one.mcap", in_process=True)
    return {name: Recording(folder / f"{name}.mcap") for name in ("one", "two")}


def test_each_of_several_lifts_moves_as_if_alone(runs: dict[str, Recording]) -> None:
    """The first to the bit, the second 7 s later, where rounding by its place decides the rest."""
    alone, other = runs["one"], runs["two"]
    own, first = last_at(alone["rope/tension/a-hall.main"]), last_at(other["rope/tension/a-hall.main"])
    assert len(own) > 1400
    own.popitem()  # where it ends alone
    assert [first[t] for t in own] == [*own.values()]
    peaks = runs["two"].fact("peaks", {})
    for name, peak in runs["one"].fact("peaks", {}).items():
        assert peaks[name] == peak
        later = peaks[f"b{name.removeprefix('a')}"]
        assert later["tension"] == pytest.approx(peak["tension"], rel=1e-4)
        assert later["time"] == pytest.approx(peak["time"] + 7.0, abs=2.0)
    end, there = other["pose/a-block"].values[-1, :3], other["pose/b-block"].values[-1, :3]
    assert there - end == pytest.approx((3.0, 40.0, 0.0), abs=2e-3)


def test_an_event_in_one_lift_adds_a_recorded_sample_row_to_that_lift_only(runs: dict[str, Recording]) -> None:
    """The samples of all have the common times; between them stand the rows of the lift to which something happened,
    those that it has alone."""
    alone, other = runs["one"]["rope/tension/a-hall.main"], runs["two"]
    common = other.signal("rope/tension").t
    assert [round(5.0 * t, 6) for t in common[:-1]] == [*range(len(common) - 1)]
    own = {name: {*other[f"pose/{name}-block/z"].t} - {*common} for name in "ab"}
    assert {t for t in own["a"] if t < alone.t[-1]} == {*alone.t} - {*common, alone.t[-1]}
    assert min(len(times) for times in own.values()) > 20
    assert not own["a"] & own["b"]
    assert {"/samples/a", "/samples/b", "/poses/a", "/poses/b"} <= {*other.topics}
    assert play(parse(TEXT).plan).digest == other.result["digest"]


def test_each_of_several_lifts_starts_with_the_rope_tensions_of_the_scene_it_extends(
    runs: dict[str, Recording],
) -> None:
    scene, first = load("hall"), parse(TEXT).statics.states[0]
    for rope, tension in scene.statics.states[0].tensions.items():
        assert first.tensions[f"a-{rope}"] == first.tensions[f"b-{rope}"] == pytest.approx(tension, rel=1e-9)


def test_names_of_stages_are_prefixed_with_the_names_of_their_lifts(runs: dict[str, Recording]) -> None:
    stages = [name for _, name in runs["two"].stages()]
    assert stages[:3] == ["a: take up", "b: take up", "a: lift off"]
    assert len(stages) == 2 * len(runs["one"].stages())


def test_the_plan_of_several_lifts_has_unique_names_and_is_cached_whole() -> None:
    scene = parse(TEXT)
    machines = [machine.name for machine in scene.plan.machines]
    assert machines == ["a-block", "a-hall", "b-block", "b-hall"]
    assert [(x.name, x.first, x.machines) for x in scene.plan.lists] == [
        ("a", 0, ("a-block", "a-hall")),
        ("b", 7, ("b-block", "b-hall")),
    ]
    assert plan.decode(plan.encode(scene.plan)) == scene.plan
    message = str(check(scene))
    assert "b: lift off" in message
    assert "a-hall.main (of 2)" in message


def test_user_models_move_the_drives_of_one_of_several_lifts_as_in_a_scene_of_that_lift_alone(tmp_path: Path) -> None:
    """It hears and leads what is called by the prefix, to the bit where the rails are moved across."""
    text = TEXT.replace("hall", "damper").replace("3 m, 40 m", "0 m, 64 m").replace("7 s", "1 s")
    run(load("damper", ["end=4s", "samples=5Hz"]), tmp_path / "one.mcap", in_process=True)
    run(parse(text, overrides=["end=4s", "accuracy=1e-3%"]), tmp_path / "two.mcap", in_process=True)
    alone, both = (Recording(tmp_path / f"{name}.mcap") for name in ("one", "two"))
    own, driven = (last_at(alone[f"joint/position/{name}-rail.travel"]) for name in ("led", "plain"))
    assert max(own.values()) > 1.0
    for lift, late in (("a", 0.0), ("b", 1.0)):
        found = last_at(both[f"joint/position/{lift}-led-rail.travel"])
        assert [found[t] for t in own] == [*own.values()], "a model waits for no action list"
        assert last_at(both[f"joint/position/{lift}-plain-rail.travel"])[3.8] == pytest.approx(driven[3.8 - late])


def test_an_operator_command_moves_one_of_several_lifts_and_the_stop_command_ends_all(tmp_path: Path) -> None:
    """The lift that is ordered answers; two at once are not ordered; what was said is said again in a replay."""
    scene = parse(TEXT)
    words = ("b-hall traversing: traverse 10 m/min by 0.5 m", "cranes: travel 10 m/min by 1 m", "")
    given = [
        TimedCommand(
            Tag(seconds(1.0 + i)),
            encode(OperatorCommand(text or STOP, msgspec.msgpack.encode(spoken(scene, text)) if text else b"")),
        )
        for i, text in enumerate(words)
    ]
    run(scene, tmp_path / "run.mcap", in_process=True, commands=given)
    recorded = RecordedRun(tmp_path / "run.mcap")
    answers = [e.value for e in recorded.recording.events() if e.type == "OperatorAnswer"]
    assert [(x["text"], x["refused"][:30]) for x in answers] == [
        (words[0], ""),
        (words[1], "it addresses machines of sever"),
    ]
    assert recorded.recording.fact("sim_s") == 3.0
    assert verify(recorded).same


@pytest.mark.parametrize(
    ("old", "new", "sentence"),
    [
        ("b: {extends: hall", "b: {extends: hull", "did you mean 'hall'"),
        ("at: [3 m, 40 m]", "at: [3 m, 40 m, 1 m]", "lifts.b.at: 2 values are enough here, not 3"),
        ("at: [3 m, 40 m]", "at: 3 m", "lifts.b.at: a list"),
        ("start: 7 s", "start: 7 m", "lifts.b.start"),
        ("start: 7 s", "blokk: {mass: 60 t}", "unknown key 'blokk'"),
        ("start: 7 s", "block: {mass: 160 t}", "hook load of hall.main would be 160.7 t, 161 %; 100.0 t is allowed"),
        ("  b: {", "  b c: {", "a name has letters"),
        ("samples: 5 Hz", "models: {}", "models: a scene of several lifts has nothing else"),
    ],
)
def test_lifts_that_cannot_be_combined_are_reported_with_their_line_in_the_scene(
    old: str, new: str, sentence: str
) -> None:
    assert old in TEXT
    with pytest.raises(SceneError) as message:
        parse(TEXT.replace(old, new), passing=True)
    assert sentence in str(message.value)
    assert ".yaml:" in str(message.value).splitlines()[0]
