"""The planner's document: each number again from the samples, and the limits that were passed in red."""

from __future__ import annotations

import re
from pathlib import Path

import msgspec
import numpy as np
import pytest
from browser import CHROMIUM
from heavylift.coordinator.run import run
from heavylift.kernel import RecordingError
from heavylift.nodes.scene import load
from heavylift.recordings import Recorder, Recording, RopeLine, SampleChannel, SampleLayout, report
from heavylift.recordings.documents import facts
from small_run import POSE, SECOND, Stage

G = 9.80665
PLAN = {
    "gravity": G,
    "cranes": [{"name": "west", "capacity": 40e3, "gantry": {"start": 0.0}, "hooks": [{"block_mass": 2e3}]}],
    "rig": {"hook_ropes": [{"name": "west.H1", "crane": "west"}]},
}
TENSION = np.array([1e5, 3e5, 4.4e5, 4e5, 4e5, 4e5, 4.2e5, 4e5])  # [N] each second; rated 4.3e5


@pytest.fixture
def recorded(tmp_path: Path) -> Path:
    """A load on one rope: taken up for 3 s, held for 5 s."""
    layout = SampleLayout(
        [
            SampleChannel("rope/tension", ["west.H1"], "N", 0, 1),
            SampleChannel("rope/peak", ["west.H1"], "N", 1, 2),
            SampleChannel("pose/load", POSE, "m", 2, 9),
        ]
    )
    n = len(TENSION)
    poses = np.zeros((n, 7))
    poses[:, 2], poses[:, 6] = 4.0, 1.0
    rows = np.ascontiguousarray(np.column_stack([TENSION, TENSION, poses]))
    facts_ = {"scene": "<b>lift</b>", "rated": {"west.H1": 4.3e5}}
    attachments = {"resolved.json": msgspec.json.encode(PLAN)}
    with Recorder(tmp_path / "run.mcap", facts_, attachments) as rec:
        rec.add_port("commander", "stage", msgspec.json.schema(Stage))
        rec.layout(layout)
        rec.ropes(0, [RopeLine("west.H1", "world", (0, 0, 10), "load", (0, 0, 1))])
        for second, name in ((0, "take up"), (3, "hold")):
            payload = msgspec.msgpack.encode(Stage(name, second))
            rec.event(second * SECOND, 0, "commander", "stage", 0, "Stage", payload)
        rec.samples(msgspec.msgpack.encode([0, [i * SECOND for i in range(n)], rows.tobytes()]))
        return rec.close()


def test_every_number_is_that_of_the_samples(recorded: Path) -> None:
    found = facts(Recording(recorded))
    (rope,) = found.ropes
    assert (rope.name, rope.peak, rope.when, rope.stage, rope.rated) == ("west.H1", 4.4e5, 2.0, "take up", 4.3e5)
    (crane,) = found.cranes
    assert crane.load == pytest.approx(4.4e5 / G - 2e3), "the hook block belongs to the crane"
    assert (crane.when, crane.capacity) == (2.0, 40e3)
    take_up, hold = found.stages
    assert (take_up.start, take_up.end, take_up.rope) == (0.0, 3.0, "west.H1")
    assert take_up.dynamic == {"west": pytest.approx(1.1)}
    assert hold.dynamic == {"west": pytest.approx(1.05)}


def test_what_went_beyond_its_limits_is_listed_in_order_of_time(recorded: Path) -> None:
    assert [(w.when, w.who, w.what) for w in facts(Recording(recorded)).warnings] == [
        (2.0, "west", "107 % of the load that it may carry"),
        (2.0, "west.H1", "tension 102 % of the rated one"),
    ]


def test_the_page_says_the_worst_first_and_escapes_what_scenes_say(recorded: Path, tmp_path: Path) -> None:
    text = report(recorded, tmp_path / "report.html").read_text()
    assert "<b>lift</b>" not in text
    assert "&lt;b&gt;lift" in text
    assert "2 warnings, listed below. The rope used most is west.H1: 102 % of its rated tension." in text
    assert re.findall(r'<td class="bad">(.*?)</td>', text)[-3:] == ["107 %", "102 %", "102 %"]
    assert text.count("data:image/png;base64,") == 2
    with pytest.raises(
        RecordingError, match=r"a report is written as \.html, \.pdf or \.xlsx; give it one of these endings"
    ):
        report(recorded, tmp_path / "report.doc")


def test_it_is_printed_where_a_browser_is(recorded: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    if CHROMIUM:
        printed = report(recorded, tmp_path / "report.pdf").read_bytes()
        assert printed.startswith(b"%PDF")
        assert b"/MediaBox [0 0 594.95" in printed, "A4"
    monkeypatch.setenv("PATH", str(tmp_path))
    with pytest.raises(RecordingError) as error:
        report(recorded, tmp_path / "other.pdf")
    assert str(error.value) == (
        f"{tmp_path}/other.pdf: no Chromium or Chrome is installed to print it; write {tmp_path}/other.html and print "
        "that from any browser"
    )


def test_a_mechanism_without_ropes_and_stages_has_a_report_as_well(tmp_path: Path) -> None:
    run(load("pendulum", ["end=2 s"]), tmp_path / "pendulum.mcap", in_process=True)
    text = report(tmp_path / "pendulum.mcap", tmp_path / "pendulum.html").read_text()
    assert "<h2>Scene</h2>" in text
    assert "<h2>Stages</h2>" not in text


def test_hooks_stages_and_scene_of_a_whole_lift(tmp_path: Path) -> None:
    scene = load("lift")
    run(scene, tmp_path / "lift.mcap", in_process=True)
    found = facts(Recording(tmp_path / "lift.mcap"))
    assert [h.name for h in found.hooks] == ["crane H1", "crane H2", "crane H3"]
    for hook, rope in zip(found.hooks, found.ropes, strict=False):
        block_mass = scene.plan.cranes[0].hooks[0].block_mass
        assert hook.load == pytest.approx(rope.peak / scene.plan.gravity - block_mass, rel=0.02), (
            "samples miss the peak"
        )
    up = {s.name: s.lowest for s in found.stages}
    assert up["take up slack"] == pytest.approx(2.0, abs=0.02), "on its stools"
    assert up["sideways"] == pytest.approx(3.0, abs=0.15), "hoisted by 1 m"
    assert dict(found.scene)["block"].startswith("300 t, centre at 40, 75, ")
