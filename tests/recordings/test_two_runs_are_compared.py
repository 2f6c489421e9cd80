"""Two recordings side by side: equal, or where they part and by how much."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import msgspec
import numpy as np
import pytest
from heavylift.recordings import Difference, Recorder, SampleChannel, SampleLayout, compare
from numpy.typing import NDArray
from small_run import NAMES, SECOND, TIMES, Stage

Write = Callable[..., Path]


@pytest.fixture
def write(tmp_path: Path) -> Write:
    """A recording of two tensions and some stages."""

    def make(name: str, tension: NDArray[np.float64], stages: list[tuple[int, str]]) -> Path:
        with Recorder(tmp_path / name, {"scene": "lift"}) as rec:
            rec.add_port("commander", "stage", msgspec.json.schema(Stage))
            rec.layout(SampleLayout([SampleChannel("rope/tension", NAMES, "N", 0, 2)]))
            for i, (second, text) in enumerate(stages):
                payload = msgspec.msgpack.encode(Stage(text, i))
                rec.event(second * SECOND, 0, "commander", "stage", 0, "Stage", payload)
            rec.samples(msgspec.msgpack.encode([0, TIMES[: len(tension)], tension.tobytes()]))
        return tmp_path / name

    return make


TENSION = np.array([[1e5, 2e5], [3e5, 2e5], [4e5, 1e5], [4.5e5, 0.0], [2e5, 0.0], [1e5, 0.0]])
STAGES = [(0, "take up"), (1, "hoist"), (3, "lower")]


def test_two_equal_runs_are_recognised_by_their_equal_digests(write: Write) -> None:
    found = compare(write("a.mcap", TENSION, STAGES), write("b.mcap", TENSION, STAGES))
    assert found.equal
    assert str(found).splitlines()[0] == (
        f"{found.a} and {found.b} are equal: same digest, computed again of both, and the same facts and attachments, "
        "2 signals"
    )


def test_the_comparison_of_two_runs_reports_the_first_event_in_which_they_differ(write: Write) -> None:
    other = [STAGES[0], (1, "wait"), STAGES[2]]
    found = compare(write("a.mcap", TENSION, STAGES), write("b.mcap", TENSION, other))
    assert not found.equal
    assert found.first == (
        "event at 1.000000000 s: commander.stage Stage {'name': 'hoist', 'number': 1} in a.mcap, "
        "commander.stage Stage {'name': 'wait', 'number': 1} in b.mcap"
    )
    assert [d.most for d in found.differences] == [0.0, 0.0]


def test_comparing_two_runs_reports_the_largest_difference_and_rms_of_each_signal(write: Write) -> None:
    other = TENSION.copy()
    other[2, 0] += 100.0
    found = compare(write("a.mcap", TENSION, STAGES), write("b.mcap", other, STAGES))
    west, second = found.differences
    assert found.first == "rope/tension at 2.000000000 s"
    # the square of the difference rises over 1 s and falls over 0.5 s of 4 s
    assert west == Difference("rope/tension/west.H1", 100.0, 2.0, pytest.approx(np.sqrt(1e4 * 0.75 / 4.0)), 4.5e5, "N")
    assert second.most == 0.0


def test_comparing_two_runs_lists_differences_as_small_as_rounding_last(write: Write) -> None:
    one, other = TENSION.copy(), TENSION.copy()
    one[:, 1], other[:, 1] = 1e-9, 2e-9
    other[2, 0] += 4.5e3
    lines = str(compare(write("a.mcap", one, STAGES), write("b.mcap", other, STAGES))).splitlines()
    assert [line.split()[0] for line in lines if "rope/tension/" in line] == [f"rope/tension/{name}" for name in NAMES]
    assert " 1 %" in next(line for line in lines if "west.H1" in line)


def test_signals_with_different_sample_times_are_compared_after_linear_interpolation(write: Write) -> None:
    fewer = np.array([[0.0, 0.0], [10.0, 0.0]])
    found = compare(write("a.mcap", fewer, []), write("b.mcap", TENSION, []))
    assert found.first == "rope/tension at 0.000000000 s"
    assert [(d.most, d.when) for d in found.differences] == [(299990.0, 1.0), (2e5, 0.0)]


def test_comparing_two_runs_reports_that_one_ends_earlier(write: Write) -> None:
    found = compare(write("a.mcap", TENSION, []), write("b.mcap", TENSION[:4], []))
    assert found.first == "rope/tension at 3.000000000 s; b.mcap ends before"
    assert [d.most for d in found.differences] == [0.0, 0.0]


def test_a_comparison_of_two_runs_is_exported_with_named_fields(write: Write) -> None:
    a, b = (write(name, TENSION + off, []) for name, off in (("a.mcap", 0.0), ("b.mcap", 1.0)))
    found = msgspec.json.decode(msgspec.json.encode(compare(a, b), enc_hook=str))
    assert found["equal"] is False
    first = found["differences"][0]
    assert (first["name"], first["most"], first["rms"], first["unit"]) == ("rope/tension/west.H1", 1.0, 1.0, "N")
    same = msgspec.json.decode(msgspec.json.encode(compare(a, a), enc_hook=str))
    assert (same["equal"], same["first"]) == (True, "")
