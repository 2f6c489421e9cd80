"""Helpers that write a scene text to a file, load and run it with all nodes, and read its recording.

Nothing here reaches into a room: what a test sees is what stands in the recording.
"""

from __future__ import annotations

import itertools
import json
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np
from heavylift.coordinator.run import run
from heavylift.nodes.scene import load
from heavylift.recordings import Recording
from numpy.typing import NDArray

Array = NDArray[np.float64]

CLOSED_FORMS = {
    form["id"]: form for form in json.loads((Path(__file__).parents[1] / "data" / "closed_forms.json").read_text())
}
G = 9.80665  # standard gravity [m/s2], as in the closed forms

_number = itertools.count()


class Happening(NamedTuple):
    """A state event of the kernel: when [s], to which element, what, with which value."""

    t: float
    name: str
    what: str
    value: float


def play(folder: Path, text: str, overrides: Sequence[str] = (), in_process: bool = True) -> Recording:
    """The recording of a run of this scene, in a folder of its own: lines of the scene's file are on record."""
    own = folder / f"run-{next(_number)}"
    own.mkdir()
    scene, output = own / "scene.yaml", own / "run.mcap"
    scene.write_text(text)
    run(load(scene, overrides), output, in_process)
    return Recording(output)


def channel(recording: Recording, topic: str, name: str = "") -> tuple[Array, Array]:
    """Times and values of one column of a topic (of its only one, without a name)."""
    signal = recording.signal(topic)
    if not name:
        assert len(signal.names) == 1, f"{topic} has {signal.names}"
    return signal.t, signal.values[:, signal.names.index(name) if name else 0]


def happenings(recording: Recording, what: str, name: str = "") -> list[Happening]:
    """The state events of the kernel of one kind, in order."""
    events = [e for e in recording.events(source="kernel") if e.type == "StateEvent" and e.value["what"] == what]
    found = [Happening(e.t_ns / 1e9, e.value["name"], what, e.value["value"]) for e in events]
    return [h for h in found if name in ("", h.name)]


def the_only(found: list[Happening]) -> Happening:
    """The event of which there is exactly one."""
    assert len(found) == 1, found
    return found[0]


def near(value: float, want: float, rtol: float) -> bool:
    """Whether a value is the wanted one within a relative error."""
    return abs(value - want) <= rtol * abs(want)
