"""Models that listen: samples stand in the steps that the run takes anyway, and no mechanical byte changes."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from heavylift.coordinator.record import Played, play
from heavylift.nodes.models.parts import Sample
from heavylift.nodes.scene import load
from scenes import listening

CASES = [
    ("lift", "tension of crane H1", "37 ms", ("end=20 s",)),  # slings go taut, the load is lifted; islands
    ("lift", "position of crane", "500 ms", ("end=12 s", "method=radau5")),
    ("snatch", "tension of fall", "10 ms", ("end=3 s",)),  # a rigid rope that snaps taut
    ("trolley", "swing along of fall-1", "50 ms", ("end=20 s", "method=dop853")),
    ("trolley", "speed of rail", "50 ms", ("end=20 s", "method=radau5")),
    ("trolley", "position of rail", "1 ms", ("end=5 s", "step=7 ms")),
    ("damper", "height of plain-load", "125 ms", ("end=30 s",)),  # beside another model, which leads a drive
]


def mechanics(run: Played) -> tuple[bytes, bytes, list[object], list[tuple[int, str]]]:
    """All of a run but what was reported to the ear."""
    events = [event for event in run.events if not event.port.startswith("sample_ear")]
    return run.times.tobytes(), run.rows.tobytes(), list(events), run.notes


@pytest.mark.parametrize(("name", "signal", "period", "sets"), CASES)
@pytest.mark.large(beyond=4)
def test_observing_a_run_does_not_change_any_byte_of_its_recording(
    folder: Path, name: str, signal: str, period: str, sets: tuple[str, ...]
) -> None:
    heard = play(listening(folder, name, signal, period, sets).plan)
    assert mechanics(heard) == mechanics(play(load(name, sets).plan))
    samples = [event for event in heard.events if isinstance(event.value, Sample) and event.port == "sample_ear_heard"]
    step = {"ms": 1_000_000}[period.split()[1]] * int(period.split()[0])
    end = heard.plan.end or 0.0
    assert [(event.t, event.k) for event in samples] == [(i * step, 0) for i in range(round(end * 1e9) // step + 1)][
        : len(samples)
    ]
    assert len(samples) == -(-round(end * 1e9) // step), "at all whole multiples of the period before the end"


SIGNALS = [
    ("lift", "tension of crane H1", "rope/tension", "crane.H1"),
    ("lift", "length of crane H1", "rope/length", "crane.H1"),
    ("lift", "height of block", "pose/block", "z"),
    ("trolley", "position of rail", "joint/position", "rail.travel"),
    ("trolley", "speed of rail", "joint/velocity", "rail.speed"),
    ("trolley", "tension of fall-1", "rope/tension", "fall-1"),
]


@pytest.mark.parametrize(("name", "signal", "topic", "column"), SIGNALS)
def test_a_user_model_receives_the_recorded_values_of_a_signal(
    folder: Path, name: str, signal: str, topic: str, column: str
) -> None:
    run = play(listening(folder, name, signal, "1 s", ("end=12 s", "samples=2 Hz")).plan)
    channel = next(c for c in run.layout.channels if c.topic == topic)
    message = [event.value.value for event in run.events if isinstance(event.value, Sample)]
    recorded = run.rows[:, channel.start + list(channel.names).index(column)]
    first = [int(np.searchsorted(run.times, t * 10**9)) for t in range(12)]  # before what commands of that time change
    assert message == pytest.approx(recorded[first], rel=1e-12, abs=1e-12)


def test_the_signal_swing_is_the_angle_of_the_rope_to_the_vertical(folder: Path) -> None:
    run = play(listening(folder, "trolley", "swing along of fall-1", "500 ms", ("end=20 s",)).plan)
    message = [event.value.value for event in run.events if isinstance(event.value, Sample)]
    channel = next(c for c in run.layout.channels if c.topic == "joint/position")
    at = {n: run.rows[:, channel.start + i] for i, n in enumerate(channel.names)}
    first = [int(np.searchsorted(run.times, i * 5 * 10**8)) for i in range(40)]
    lean = np.arcsin((at["float.x"] - at["rail.travel"])[first] / 24.0)
    assert message == pytest.approx(lean, abs=1e-6), "both ropes stay parallel"
    assert np.ptp(lean) > 0.03
