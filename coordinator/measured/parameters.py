"""Runs with other inputs of a recorded scene, and estimates of them written back into it, its comments kept."""

from __future__ import annotations

import io
import tempfile
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path as FilePath
from typing import Any

import msgspec
import numpy as np
from heavylift.coordinator.run import run
from heavylift.coordinator.run.resume import Beginning
from heavylift.kernel.errors import HeavyliftError, RecordingError, SceneError
from heavylift.nodes.scene import LoadedScene
from heavylift.nodes.scene.inputs import Input, settings, stated, varied
from heavylift.nodes.scene.keys.defaults import override
from heavylift.nodes.scene.loading import parse
from heavylift.nodes.scene.text.source import ordered, read
from heavylift.recordings import Recording
from numpy.typing import NDArray
from ruamel.yaml import YAML

from .alignment import Curve
from .mapping import LogChannel
from .validation import curves_of

SAMPLES = (20.0, 100.0)  # [Hz] at least and at most, between which samples are as many as the log's rows
TIGHT = 1e-7  # tolerance at which differences of two runs are those of their inputs
Floats = NDArray[np.float64]
Simulate = Callable[[Floats], list[Curve]]


def simulator(
    begun: Beginning, inputs: Sequence[Input], channels: list[LogChannel], rows_hz: float, say: Callable[[str], None]
) -> Simulate:
    """Curves of the channels for values of the inputs; HeavyliftError names the values that make no run."""
    hz = begun.scene.plan.samples_hz
    rate = min(max(SAMPLES[0], rows_hz, hz), max(SAMPLES[1], hz))

    def simulate(values: Floats) -> list[Curve]:
        given = ", ".join(f"{p.name} {x / p.factor:.6g} {p.unit}".strip() for p, x in zip(inputs, values, strict=True))
        say(given)
        try:
            other = varied(begun.scene, inputs, values.tolist())
            plan = msgspec.structs.replace(other.plan, samples_hz=rate, tolerance=min(other.plan.tolerance, TIGHT))
            with tempfile.TemporaryDirectory(prefix="heavylift-", ignore_cleanup_errors=True) as folder:
                made = FilePath(folder) / "run.mcap"
                run(replace(other, plan=plan), made, in_process=True, commands=begun.commands)
                return curves_of(Recording(made), channels)
        except HeavyliftError as error:
            raise RecordingError(f"with {given} there is no run: {error}") from None

    return simulate


def spread(simulate: Simulate, values: Floats, sigma: Floats, own: Sequence[Curve]) -> list[Floats]:
    """Standard uncertainty of each curve, at the times of the run's own, from that of the inputs."""
    squares = [np.zeros(len(T)) for T, _ in own]
    for step in np.diag(sigma):
        pairs = zip(simulate(values + step), simulate(values - step), strict=True)
        for square, (T, _), (up, down) in zip(squares, own, pairs, strict=True):
            square += (0.5 * (np.interp(T, *up) - np.interp(T, *down))) ** 2
    return [np.sqrt(square) for square in squares]


def scene_text(
    scene: LoadedScene, inputs: Sequence[Input], estimates: Mapping[str, tuple[str, str]], source: str
) -> str:
    """The text of a scene with estimates, (value, uncertainty) by name, from the log `source`.

    What was laid over the scene for its run, by `extends` or `--set`, is written out.
    """
    name, out, yaml = scene.path.name, io.StringIO(), YAML()
    yaml.preserve_quotes, yaml.width = True, 10_000  # lines stay as long as they are
    yaml.indent(mapping=2, sequence=4, offset=2)
    fitted, wanted = [p for p in inputs if p.name in estimates], read(scene.merged or scene.text, name)
    for setting in settings(fitted, [stated(scene, p, *estimates[p.name]) for p in fitted]):
        override(wanted, setting)
    data = _laid(yaml.load(scene.text), wanted.data)
    for part in dict.fromkeys(p.path[0] for p in fitted):
        lines = [f"  {p.name}: {' +- '.join(estimates[p.name])}" for p in fitted if p.path[0] == part]
        data.yaml_set_comment_before_after_key(part, before="\n".join([f"from {source}, 95 %:", *lines]))
    yaml.dump(data, out)
    if ordered(read(out.getvalue(), name).data) != ordered(wanted.data):
        raise SceneError(f"{name}: cannot be written with its comments; set the estimates with --set")
    parse(out.getvalue(), name)
    return out.getvalue()


def _laid(data: Any, wanted: Any) -> Any:
    """The data as wanted; what is so already stays the object that it is, with its comments and style."""
    if isinstance(data, dict) and isinstance(wanted, dict):
        for key in [key for key in data if key not in wanted]:
            del data[key]
        for key, value in wanted.items():
            data[key] = _laid(data.get(key), value)
        return data
    if isinstance(data, list) and isinstance(wanted, list) and len(data) == len(wanted):
        for i, value in enumerate(wanted):
            data[i] = _laid(data[i], value)
        return data
    return data if data == wanted and type(data) is not bool else wanted
