"""Observers of a replay hear what observers of the run heard; time, keys, topics and the part that is played."""

from __future__ import annotations

import base64
import json
import os
import pty
import queue
import subprocess
import sys
import time
import urllib.request
from pathlib import Path

import msgspec
import numpy as np
import pytest
import zenoh
from heavylift.coordinator.live import Keyboard
from heavylift.coordinator.replay import Player, PublishedItem, Publisher, RecordedRun, Replay
from heavylift.coordinator.transport import OBSERVER, guest_session, key
from heavylift.kernel import RecordingError

HEAVYLIFT = Path(sys.executable).parent / "heavylift"
SECOND = 1_000_000_000


class Clock:
    """A wall clock that moves by waiting only, and a keyboard on which keys are pressed at given times [s]."""

    def __init__(self, keys: dict[float, str] | None = None) -> None:
        self.now, self.keys, self.there = 0.0, dict(keys or {}), True

    def __call__(self) -> float:
        return self.now

    def wait(self, seconds: float | None) -> str:
        end = float("inf") if seconds is None else self.now + seconds
        at = min(self.keys, default=float("inf"))
        if at <= end:
            self.now = max(self.now, at)
            return self.keys.pop(at)
        assert seconds is not None, "somebody waits for a key that nobody presses"
        self.now = end
        return ""


def played(run: RecordedRun, keys: dict[float, str], rate: float, **options: bool) -> list[tuple[float, float]]:
    """(wall, simulation) time [s] of each instant of the samples."""
    clock = Clock(keys)
    times: list[tuple[float, float]] = []
    player = Player(lambda text: None, rate, keyboard=clock, clock=clock, **options)  # type: ignore[arg-type]
    player.on_time = lambda t_ns: times.append((round(clock.now, 6), t_ns / 1e9))
    player.play(Replay(run, ["samples"], 1.0, 4.0))
    return times


def test_an_observer_of_a_replay_receives_the_recorded_events(recorded: RecordedRun) -> None:
    heard: queue.SimpleQueue[zenoh.Sample] = queue.SimpleQueue()
    text: list[PublishedItem] = []
    with Publisher("lift", recorded.path) as publisher:
        observer = guest_session(publisher.directory, OBSERVER)
        subscribers = [
            observer.declare_subscriber(key(publisher.run, part, "**"), heard.put) for part in ("event", "sample")
        ]
        first = PublishedItem(0, None, "ready", b"?")
        while heard.empty():  # until the observer is known to the hub
            publisher.say(first)
            time.sleep(0.01)
        player = Player(lambda one: (text.append(one), publisher.say(one))[0], rate=40.0)
        player.play(Replay(recorded, ["commander/*", "samples"]))
        publisher.say(PublishedItem(0, None, "over", b"."))
        got: list[tuple[str, bytes]] = []
        while not got or not got[-1][0].endswith("/over"):
            sample = heard.get(timeout=10)
            got.append((str(sample.key_expr), sample.payload.to_bytes()))
        assert subscribers
        observer.close()
    got = [x for x in got[:-1] if not x[0].endswith("/ready")]
    prefix = f"heavylift/{publisher.run}/"
    events = [(f"{prefix}event/{e.source}/{e.port}", e.payload) for e in recorded.events if e.source == "commander"]
    assert [x for x in got if "/event/" in x[0]] == events
    samples = [x for x in got if x[0] == prefix + "sample/samples"]
    assert len(samples) == len(recorded.recording.signal("rope/tension").t)
    assert [s.t_ns for s in text] == sorted(s.t_ns for s in text)


def test_a_recording_is_replayed_at_the_requested_rate(recorded: RecordedRun) -> None:
    times = played(recorded, {}, rate=2.0)
    assert times
    for wall, t in times:
        assert wall == pytest.approx((t - 1.0) / 2.0, abs=1e-6)


def test_a_replay_is_paused_and_stepped_and_sped_up_and_ended_by_keys(recorded: RecordedRun) -> None:
    free = [t for _, t in played(recorded, {}, rate=1.0)]
    times = played(recorded, {0.55: " ", 5.0: "s", 6.0: "s", 7.0: " "}, rate=1.0)
    before = [x for x in times if x[0] <= 0.55]
    assert [t for _, t in times] == free, "nothing is left out, nothing comes twice"
    n = len(before)
    assert [wall for wall, _ in times[n : n + 2]] == [5.0, 6.0], "each step is one instant"
    assert times[n + 2][0] == pytest.approx(7.0 + times[n + 2][1] - times[n + 1][1])
    faster = played(recorded, {1.0: "+"}, rate=1.0)
    assert faster[-1] == (pytest.approx(1.0 + (faster[-1][1] - 2.0) / 2.0), free[-1])
    assert [t for _, t in played(recorded, {1.25: "q"}, rate=1.0)] == [t for t in free if t <= 2.25]
    assert played(recorded, {0.5: "q"}, rate=1.0, paused=True) == []


def test_a_replay_publishes_only_the_selected_part_of_a_recording(recorded: RecordedRun) -> None:
    stages = [group for _, group in Replay(recorded, ["commander/stage"], 1.0)]
    expected = [e for e in recorded.events if e.port == "stage" and e.t >= SECOND]
    assert [text.event for group in stages for text in group] == expected
    with pytest.raises(RecordingError, match=r"lift\.mcap: no topic matches crane/west; it has /block/input, "):
        Replay(recorded, ["crane/west"])
    with pytest.raises(RecordingError, match=r"nothing lies between 5\.0 s and 1\.0 s; give --from before --to$"):
        Replay(recorded, [], 5.0, 1.0)
    with pytest.raises(RecordingError, match="--from and --to must be numbers, in seconds of the run"):
        Replay(recorded, [], float("nan"))


@pytest.mark.large
def test_a_replay_started_without_a_terminal_cannot_be_controlled_by_keys(lift: Path) -> None:
    arguments = [HEAVYLIFT, "replay", lift, "--rate", "1000", "--topics", "*/stage"]
    done = subprocess.run(arguments, stdin=subprocess.DEVNULL, capture_output=True, text=True, timeout=60)
    assert done.returncode == 0
    assert done.stdout == "replayed 2 messages of 1 topics\n"
    assert "\x1b" not in done.stderr
    assert "space pauses" not in done.stderr
    done = subprocess.run(
        [*arguments, "--paused"], stdin=subprocess.DEVNULL, capture_output=True, text=True, timeout=60
    )
    assert done.returncode == 1
    assert done.stderr.endswith("--paused waits for keys, but there is no terminal; leave it out\n")
    done = subprocess.run([*arguments, "--from", "99", "--loop"], capture_output=True, text=True, timeout=60)
    assert done.stderr.endswith("nothing was recorded in this time range; give an earlier --from\n"), "no endless loop"
    done = subprocess.run([*arguments, "--rate", "0"], capture_output=True, text=True, timeout=60)
    assert done.stderr.endswith("--rate 0 is not a valid rate; give a number greater than 0, such as 20\n")


def test_a_replay_reads_the_terminal_key_by_key_and_restores_its_settings(monkeypatch: pytest.MonkeyPatch) -> None:
    import termios

    mine, theirs = pty.openpty()
    with os.fdopen(theirs, "r") as terminal:
        monkeypatch.setattr("sys.stdin", terminal)
        before = termios.tcgetattr(terminal)
        with Keyboard() as keyboard:
            assert keyboard.there
            assert keyboard.wait(0.0) == ""
            os.write(mine, b"s ")
            assert (keyboard.wait(5.0), keyboard.wait(5.0)) == ("s", " "), "without a return key"
        assert termios.tcgetattr(terminal) == before
    os.close(mine)


def test_a_replayed_recording_is_shown_on_the_same_live_page_as_a_run(lift: Path, recorded: RecordedRun) -> None:
    arguments = [HEAVYLIFT, "replay", lift, "--rate", "1000", "--view"]
    with subprocess.Popen([*arguments, "--from", "5"], stderr=subprocess.PIPE, stdout=subprocess.DEVNULL) as process:
        assert process.stderr is not None
        address = process.stderr.readline().decode().removeprefix("watch it at ").strip()
        message = []
        with urllib.request.urlopen(address + "events", timeout=60) as messages:
            for line in messages:
                if line.startswith(b"data: "):
                    message.append(json.loads(line.removeprefix(b"data: ")))
                    if "peaks" in message[-1] and len(message) > 1:
                        break
        assert process.wait(60) == 0
    begin, *more, end = message
    assert begin["title"] == "lift"
    assert "block" in [body["name"] for body in begin["bodies"]]
    assert begin["rig"][0]["lines"] == json.loads(msgspec.json.encode(recorded.recording.rigs()[0].lines))
    t = [x for m in more if "rows" in m for x in np.frombuffer(base64.b64decode(m["rows"]["t"]), "<f8")]
    assert (round(min(t) * SECOND), round(max(t) * SECOND)) == (5 * SECOND, 20 * SECOND - 1)
    text = [e["t"] for m in more for e in m["events"]]
    assert text == [e.t * 1e-9 for e in recorded.events if e.t >= 5 * SECOND]
    peaks = recorded.recording.fact("peaks")
    assert {p["name"]: p["tension"] for p in end["peaks"]} == {name: peak["tension"] for name, peak in peaks.items()}
    assert end["status"] == f"replayed, 20 s simulated; recorded in {lift}"
    done = subprocess.run([*arguments, "--loop"], capture_output=True, text=True, timeout=60)
    assert done.returncode == 1
    assert done.stderr == f"heavylift: {lift}: --view shows a replay only once; leave out --loop\n"
