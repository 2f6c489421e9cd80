"""Whatever is altered in a recording is seen: beside the unaltered one by `compare`, alone by `replay --verify`."""

from __future__ import annotations

import json
import random
import re
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

import pytest
from altered_recordings import Parts, Said, altered
from heavylift.coordinator.replay import RecordedRun
from heavylift.coordinator.run.verify import verify
from heavylift.kernel import RecordingError
from heavylift.recordings import compare, info
from heavylift.recordings.format import log_message

Alter = Callable[[Parts, random.Random], None]
TIMES = 2  # that each is altered, at another place


def row_dropped(parts: Parts, rng: random.Random) -> None:
    i = rng.choice(parts.rows())
    del parts.messages[i : i + 2]


def numbers_dropped(parts: Parts, rng: random.Random) -> None:
    del parts.messages[rng.choice(parts.rows())]


def last_row_dropped(parts: Parts, rng: random.Random) -> None:
    i = parts.rows()[-1]
    del parts.messages[i : i + 2]


def row_doubled(parts: Parts, rng: random.Random) -> None:
    i = rng.choice(parts.rows())
    parts.messages[i:i] = parts.messages[i : i + 2]


def rows_shuffled(parts: Parts, rng: random.Random) -> None:
    i, j = rng.sample(parts.rows(), 2)
    for k in (0, 1):
        parts.messages[i + k], parts.messages[j + k] = parts.messages[j + k], parts.messages[i + k]


def moved(parts: Parts, i: int) -> None:
    text = parts.messages[i]
    parts.messages[i] = text._replace(publish_time=text.publish_time + 1)


def time_of_numbers_altered(parts: Parts, rng: random.Random) -> None:
    moved(parts, rng.choice(parts.rows()))


def time_of_poses_altered(parts: Parts, rng: random.Random) -> None:
    moved(parts, rng.choice(parts.rows()) + 1)


def turned(parts: Parts, i: int, at: int) -> None:
    """One bit of a message, counted from its end."""
    text = bytearray(parts.messages[i].data)
    text[-at] ^= 1
    parts.messages[i] = parts.messages[i]._replace(data=bytes(text))


def bit_of_a_number_turned(parts: Parts, rng: random.Random) -> None:
    turned(parts, rng.choice(parts.rows()), rng.choice((3, 4, 8 + 3)))


def bit_of_a_pose_turned(parts: Parts, rng: random.Random) -> None:
    turned(parts, rng.choice(parts.rows()) + 1, 4)


def events(parts: Parts, like: bytes = b"") -> list[int]:
    return [i for i, x in enumerate(parts.messages) if "port" in parts.channels[x.topic][1].metadata and like in x.data]


def event_dropped(parts: Parts, rng: random.Random) -> None:
    del parts.messages[rng.choice(events(parts))]


def event_doubled(parts: Parts, rng: random.Random) -> None:
    i = rng.choice(events(parts))
    parts.messages.insert(i, parts.messages[i])


def replaced(parts: Parts, i: int, old: bytes, new: bytes) -> None:
    text = parts.messages[i]
    assert old in text.data
    parts.messages[i] = text._replace(data=text.data.replace(old, new, 1))


def stage_renamed(parts: Parts, rng: random.Random) -> None:
    i = next(i for i in events(parts, b'"Stage"') if b'"name":"lift off"' in parts.messages[i].data)
    replaced(parts, i, b"lift off", b"lift up")


def speed_altered(parts: Parts, rng: random.Random) -> None:
    i = rng.choice(events(parts, b'"SetProfile"'))
    replaced(parts, i, b'"accel":', b'"accel":1')


def note_added(parts: Parts, rng: random.Random) -> None:
    parts.messages.append(Said("/log", 1, 1, log_message(1, "warning", "kernel", "steps are too long")))


def column_renamed(parts: Parts, rng: random.Random) -> None:
    facts = parts.channels["/samples"][1].metadata
    facts["signals"] = facts["signals"].replace("crane.H1", "crane.H9", 1)


def body_renamed(parts: Parts, rng: random.Random) -> None:
    facts = parts.channels["/poses"][1].metadata
    names = json.loads(facts["names"])
    facts["names"] = json.dumps([*reversed(names)])


def shape_altered(parts: Parts, rng: random.Random) -> None:
    turned(parts, next(i for i, x in enumerate(parts.messages) if x.topic == "/scene"), 4)


def rope_line_altered(parts: Parts, rng: random.Random) -> None:
    replaced(parts, next(i for i, x in enumerate(parts.messages) if x.topic == "/rig"), b"crane.H1", b"crane.H2")


def text_altered(parts: Parts, rng: random.Random) -> None:
    text = parts.attachments["merged.json"].decode()
    parts.attachments["merged.json"] = re.sub(r'"mass": ?"300 t"', '"mass":"310 t"', text).encode()
    assert text.encode() != parts.attachments["merged.json"]


def plan_altered(parts: Parts, rng: random.Random) -> None:
    plan = json.loads(parts.attachments["resolved.json"])
    plan["limits"] = plan["limits"][1:]
    parts.attachments["resolved.json"] = json.dumps(plan).encode()


def layout_altered(parts: Parts, rng: random.Random) -> None:
    parts.attachments["lichtblick.json"] += b" "


def layout_dropped(parts: Parts, rng: random.Random) -> None:
    del parts.attachments["lichtblick.json"]


def verdict_forged(parts: Parts, rng: random.Random) -> None:
    verdict = json.loads(parts.metadata["result"]["verdict"])
    verdict |= {"red": not verdict["red"], "line": "red: all ropes break"}
    parts.metadata["result"]["verdict"] = json.dumps(verdict)


def clearance_forged(parts: Parts, rng: random.Random) -> None:
    verdict = json.loads(parts.metadata["result"]["verdict"])
    verdict["clearances"][0]["distance"] += 1.0
    parts.metadata["result"]["verdict"] = json.dumps(verdict)


def peak_forged(parts: Parts, rng: random.Random) -> None:
    peaks = json.loads(parts.metadata["result"]["peaks"])
    peaks["crane.H1"][rng.choice(("tension", "time"))] *= 0.5
    parts.metadata["result"]["peaks"] = json.dumps(peaks)


def digest_forged(parts: Parts, rng: random.Random) -> None:
    parts.metadata["result"]["digest"] = parts.metadata["result"]["digest"][::-1]


def fact_forged(kind: str, name: str, text: str) -> Alter:
    def alter(parts: Parts, rng: random.Random) -> None:
        assert parts.metadata[kind].get(name) != text
        parts.metadata[kind][name] = text

    alter.__name__ = f"{kind}_{name}"
    return alter


FORGED = [
    ("result", "status", "failed"),
    ("result", "reason", "a cable broke"),
    ("result", "sim_s", "19.5"),
    ("result", "samples", "7"),
    ("result", "unfinished", "waiting for nothing"),
    ("result", "energy_error", "0.0"),
    ("run", "scene", "another"),
    ("run", "tolerance", "1e-12"),
    ("run", "rated", '{"crane.H1":9e9}'),
    ("run", "modelled", "everything"),
]
ALL: list[Alter] = [
    row_dropped, numbers_dropped, last_row_dropped, row_doubled, rows_shuffled, time_of_numbers_altered,
    time_of_poses_altered, bit_of_a_number_turned, bit_of_a_pose_turned, event_dropped, event_doubled, stage_renamed,
    speed_altered, note_added, column_renamed, body_renamed, shape_altered, rope_line_altered, text_altered,
    plan_altered, layout_altered, layout_dropped, verdict_forged, clearance_forged, peak_forged, digest_forged,
    *(fact_forged(*x) for x in FORGED),
]  # fmt: skip
ONCE = (
    text_altered,
    plan_altered,
    layout_altered,
    layout_dropped,
    verdict_forged,
    last_row_dropped,
    *ALL[-len(FORGED) :],
)


def test_a_recording_rewritten_without_changes_compares_equal_and_is_verified(lift: Path, tmp_path: Path) -> None:
    same = altered(lift, tmp_path / "same.mcap", lambda parts: None)
    assert compare(lift, same).equal, compare(lift, same)
    assert verify(RecordedRun(same)).same


@pytest.mark.large(beyond=12)
@pytest.mark.parametrize("alter", ALL, ids=lambda f: f.__name__)
def test_any_alteration_of_a_recording_is_detected(alter: Alter, lift: Path, tmp_path: Path) -> None:
    for seed in range(1 if alter in ONCE else TIMES):
        path = altered(lift, tmp_path / f"{seed}.mcap", lambda parts, seed=seed: alter(parts, random.Random(seed)))
        with suppress(RecordingError):  # where it cannot be read any more
            assert not compare(lift, path).equal
            assert not compare(path, lift).equal
        with suppress(RecordingError):
            outcome = verify(RecordedRun(path))
            assert not outcome.same
            assert not outcome.digest


def test_the_comparison_of_two_recordings_reports_the_number_of_missing_rows_of_each_topic(
    lift: Path, tmp_path: Path
) -> None:
    def drop(parts: Parts) -> None:
        for i in reversed(parts.rows()[10:15]):
            del parts.messages[i : i + 2]

    path = altered(lift, tmp_path / "fewer.mcap", drop)
    found = compare(lift, path)
    assert [x.split(",")[0] for x in found.rows] == [
        f"5 rows of {topic} are missing in fewer.mcap" for topic in ("/poses", "/samples")
    ]
    assert "signals are equal in the rows that both have" in str(found)


def test_a_forged_verdict_is_detected(lift: Path, tmp_path: Path) -> None:
    path = altered(lift, tmp_path / "forged.mcap", lambda parts: verdict_forged(parts, random.Random(0)))
    line = next(line for line in info(path).splitlines() if "all ropes break" in line)
    assert "as recorded" in line
    (other,) = verify(RecordedRun(path)).others
    assert other.startswith("result.verdict: red: all ropes break in forged.mcap, RED: 1 passed, 1 red")
