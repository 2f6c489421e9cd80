"""Estimation of a scene's inputs from a log: weighted least squares of model and log; which inputs the log determines.

The unknowns are scaled, x = p / scale; the log's offset is one of them unless it was given. Weights are the channels'
scatter. A direction of x is not determined by the log if two standard uncertainties along it, from the singular values
of the weighted Jacobian, are more than the scale: inputs in it are named and not fitted. Uncertainty of the others: the
scatter of the residuals, widened for autocorrelation; and errors that all rows of a sensor share, since its stated
uncertainty is taken as that of its calibration, which no number of rows averages out.

Also runs of a recorded scene with other inputs, and writing estimates back into the scene with its comments kept.
"""

import io
import tempfile
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path as FilePath
from typing import Any

import msgspec
import numpy as np
from heavylift.coordinator.run import run
from heavylift.coordinator.run.resume import Beginning
from heavylift.kernel.errors import HeavyliftError, RecordingError, SceneError
from heavylift.nodes.scene import LoadedScene
from heavylift.nodes.scene.inputs import Input, settings, stated, varied
from heavylift.nodes.scene.keys.validate import override
from heavylift.nodes.scene.loading import parse
from heavylift.nodes.scene.text.source import ordered, read
from heavylift.recordings import Recording
from numpy.typing import NDArray
from ruamel.yaml import YAML
from scipy.optimize import least_squares

from .mapping import LogChannel
from .validation import Alignment, Curve, correlation_time, curves_of

STEP, OFFSET_STEP = 0.02, 0.5  # of a scale, and of the log's: steps of the central differences
NOISE = 0.5  # of a difference: what derivatives of twice the step may differ by, and curvature may be without a look
SHARE = 0.3  # of a direction that an input must have to be named with it
EVALUATIONS = 20
ENOUGH = 1e-4  # relative change of x or of the sum of squares that ends it
Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Identifiable:
    """Measured data to which the inputs of a scene are fitted: times, channel values and their uncertainties."""

    t: Floats
    values: Sequence[Floats]
    systematic: Sequence[Floats]
    scatter: Sequence[float]


@dataclass(frozen=True)
class InputEstimates:
    """Estimated values and standard uncertainties of the inputs of a scene, by index in the list of inputs.

    `unknown`: reasons why other inputs cannot be identified; `at`: clock offset.
    """

    values: dict[int, float]
    sigma: dict[int, float]
    unknown: dict[int, str]
    at: Alignment


def estimate(
    simulate: Callable[[Floats], Sequence[Curve]], inputs: Sequence[Input], message: Identifiable, at: Alignment
) -> InputEstimates:
    """Estimate inputs of a scene by least squares from measured data, or state why the data do not determine an input.

    `simulate` returns the channels for given input values (m,).
    """
    m, known = len(inputs), dict[bytes, Sequence[Curve]]()
    unknowns = [(p.value, p.scale, *p.bounds, STEP) for p in inputs]
    unknowns += [(0.0, float(np.median(np.diff(message.t))), -np.inf, np.inf, OFFSET_STEP)] * at.estimated
    start, scale, lower, upper, step = (np.array(column) for column in zip(*unknowns, strict=True))
    free, unknown = list(range(len(start))), dict[int, str]()
    noisy = np.zeros(len(start), bool)

    def residuals(x: Floats) -> Floats:
        p = start.copy()
        p[free] = x * scale[free]
        if (key := p[:m].tobytes()) not in known:
            known[key] = simulate(p[:m])
        t = message.t + at.offset + (p[m] if at.estimated else 0.0)
        parts = zip(known[key], message.values, message.scatter, strict=True)
        return np.concatenate([(np.interp(t, T, S) - D) / s for (T, S), D, s in parts])

    def jacobian(x: Floats) -> Floats:
        columns = []
        for k, i in enumerate(free):
            h, centre = step[i] * np.eye(len(x))[k], x.copy()
            centre[k] = np.clip(x[k], lower[i] / scale[i] + 2.0 * step[i], upper[i] / scale[i] - 2.0 * step[i])
            up, down = residuals(centre + h), residuals(centre - h)
            columns.append((up - down) / (2.0 * step[i]))
            noisy[i] = False
            if i < m and _large(up + down - 2.0 * residuals(centre), up - down):  # a kink, or noise
                wide = residuals(centre + 2.0 * h) - residuals(centre - 2.0 * h)
                noisy[i] = _large(0.5 * wide - (up - down), up - down)
        return np.column_stack(columns)

    while any(i < m for i in free):
        names = [inputs[i].name for i in free if i < m]
        x, ends = start[free] / scale[free], (lower[free] / scale[free], upper[free] / scale[free])
        lost = _not_identifiable(jacobian(x), noisy[free], names)
        if not lost:
            found = least_squares(residuals, x, jacobian, ends, max_nfev=EVALUATIONS, xtol=ENOUGH, ftol=ENOUGH)
            lost = _not_identifiable(found.jac, noisy[free], names)
            if found.status == 0:
                lost = dict.fromkeys(
                    range(len(names)),
                    f"the fit has not settled after {EVALUATIONS} steps; start from values nearer to the solution",
                )
        if not lost:
            sigma = np.sqrt(np.diag(_covariance(found.jac, found.fun, message)))
            vague = [k for k in range(len(names)) if 2.0 * sigma[k] > 1.0 or found.active_mask[k]]
            lost = {k: f"the log leaves it uncertain by {200.0 * sigma[k]:.0f} % of its scale" for k in vague}
        if not lost:
            values = dict(zip(free, found.x * scale[free], strict=True))
            bars = dict(zip(free, sigma * scale[free], strict=True))
            if at.estimated:
                at = Alignment(at.offset + float(values.pop(m)), float(bars.pop(m)), at.correlation, True)
            return InputEstimates(
                {i: float(v) for i, v in values.items()}, {i: float(v) for i, v in bars.items()}, unknown, at
            )
        unknown |= {free[k]: why for k, why in lost.items()}
        free[:] = [i for k, i in enumerate(free) if k not in lost]
    return InputEstimates({}, {}, unknown, at)


def _not_identifiable(J: Floats, noisy: NDArray[np.bool_], names: Sequence[str]) -> dict[int, str]:
    """Return the inputs in a direction that the residuals do not determine, by number, with the reasons."""
    lost, m = dict[int, str](), len(names)
    for k in range(m):
        if (norm := float(np.linalg.norm(J[:, k]))) < 2.0:
            lost[k] = (
                f"the log hardly depends on it (a change by its scale moves residuals by {norm:.2g} of their scatter)"
            )
        elif noisy[k]:
            lost[k] = "its effect is smaller than the numerical noise of the run"
    if lost:
        return lost
    unit = J / np.linalg.norm(J, axis=0)
    alike = np.abs(unit.T @ unit - np.eye(J.shape[1])).max(axis=0)
    _, sizes, directions = np.linalg.svd(J, full_matrices=False)
    for direction in directions[sizes < 2.0]:
        involved = [k for k in range(m) if abs(direction[k]) > SHARE * np.abs(direction).max()]
        for k in involved:
            others = ", ".join(names[i] for i in involved if i != k) or "the log's offset"
            lost.setdefault(k, f"the log cannot distinguish it from {others} (correlation {alike[k]:.4f})")
    return lost


def _large(a: Floats, b: Floats) -> bool:
    return bool(np.linalg.norm(a) > NOISE * np.linalg.norm(b))


def _covariance(J: Floats, r: Floats, message: Identifiable) -> Floats:
    """Return the covariance (m, m) of x from scatter, correlation time and common errors of each channel."""
    A, n = np.linalg.inv(J.T @ J), len(message.values)
    middle, spare = np.zeros_like(A), len(r) / max(1, len(r) - J.shape[1])
    for Jk, rk, common, s in zip(np.split(J, n), np.split(r, n), message.systematic, message.scatter, strict=True):
        middle += correlation_time(rk) * spare * float(np.mean(rk * rk)) * (Jk.T @ Jk)
        shift = Jk.T @ (common / s)
        middle += np.outer(shift, shift)
    return A @ middle @ A


SAMPLES = (20.0, 100.0)  # [Hz] at least and at most, between which samples are as many as the log's rows
TIGHT = 1e-7  # tolerance at which differences of two runs are those of their inputs
Simulate = Callable[[Floats], list[Curve]]


def simulator(
    begun: Beginning, inputs: Sequence[Input], channels: list[LogChannel], rows_hz: float, say: Callable[[str], None]
) -> Simulate:
    """Return a function that simulates the channels for input values (m,); it raises HeavyliftError for values with
    which the scene cannot run."""
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
            raise RecordingError(f"the simulation with {given} fails: {error}") from None

    return simulate


def spread(simulate: Simulate, values: Floats, sigma: Floats, own: Sequence[Curve]) -> list[Floats]:
    """Return, for each simulated curve, its standard uncertainty due to the uncertainties `sigma` of the inputs."""
    squares = [np.zeros(len(T)) for T, _ in own]
    for step in np.diag(sigma):
        pairs = zip(simulate(values + step), simulate(values - step), strict=True)
        for square, (T, _), (up, down) in zip(squares, own, pairs, strict=True):
            square += (0.5 * (np.interp(T, *up) - np.interp(T, *down))) ** 2
    return [np.sqrt(square) for square in squares]


def scene_text(
    scene: LoadedScene, inputs: Sequence[Input], estimates: Mapping[str, tuple[str, str]], source: str
) -> str:
    """Return the text of a scene with the estimated values and uncertainties of its inputs; `source`: the measured log.

    Settings of its run, made by `extends` or `--set`, are written into the text.
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
        raise SceneError(
            f"{name}: estimates cannot be written into this file without losing comments; set them with --set"
        )
    parse(out.getvalue(), name)
    return out.getvalue()


def _laid(data: Any, wanted: Any) -> Any:
    """Return `data` changed to equal `wanted`; unchanged objects are kept, with their comments and style."""
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
