"""One run of `turnover` for all tests of this folder: eleven node processes, full recording, read once."""

from __future__ import annotations

import numpy as np
import pytest
from heavylift.coordinator.run import run
from heavylift.kernel.simulation.native import native_state
from heavylift.nodes.scene import load
from independent_mechanics import Mechanics
from stock_reader import Reading
from the_run import Lift, Stage


@pytest.fixture(scope="session")
def lift(tmp_path_factory: pytest.TempPathFactory) -> Lift:
    path = tmp_path_factory.mktemp("turnover") / "turnover.mcap"
    code = tmp_path_factory.mktemp("code")
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("HEAVYLIFT_CACHE", str(code))
        patch.setattr(native_state, "_loaded", {})  # of tests before
        return Lift(path, run(load("turnover"), path), code)


@pytest.fixture(scope="session")
def reading(lift: Lift) -> Reading:
    return Reading(lift.path)


@pytest.fixture(scope="session")
def mechanics(reading: Reading) -> Mechanics:
    return Mechanics(reading)


@pytest.fixture(scope="session")
def stages(reading: Reading) -> dict[str, Stage]:
    """By name; a name that comes again is counted: "settle", "settle 2"."""
    text = reading.said("commander", "stage")
    starts = [e["t_ns"] * 1e-9 for e in text]
    found: dict[str, Stage] = {}
    for event, start, end in zip(text, starts, [*starts[1:], reading.t[-1] + 1e-9], strict=True):
        name = event["value"]["name"]
        count = sum(e["value"]["name"] == name for e in text[: len(found)])
        samples = np.flatnonzero((reading.t >= start) & (reading.t < end))
        found[f"{name} {count + 1}" if count else name] = Stage(start, end, samples)
    return found


@pytest.fixture(scope="session")
def fine(tmp_path_factory: pytest.TempPathFactory) -> Mechanics:
    """The first 100 s of the scene, until the block hangs free and rises, sampled fifty times a second."""
    path = tmp_path_factory.mktemp("fine") / "fine.mcap"
    run(load("turnover", ["end=100 s", "samples=50 Hz"]), path, in_process=True)
    return Mechanics(Reading(path))
