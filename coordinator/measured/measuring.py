"""Comparison of a recording with a log of the real lift: writes a recording that contains both and, on request, a scene
with estimated inputs."""

from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path

import msgspec
import numpy as np
from heavylift.coordinator.record.scene import MERGED, RESOLVED
from heavylift.coordinator.replay.recorded import RecordedRun
from heavylift.coordinator.run.resume import Beginning
from heavylift.kernel.errors import RecordingError
from heavylift.nodes.scene.inputs import inputs, uncertain_inputs
from heavylift.nodes.scene.keys.validate import uncertainties
from heavylift.nodes.scene.text.source import read
from heavylift.recordings import Recording, file_path
from heavylift.recordings.read.export import extended
from heavylift.recordings.write.outputs import beside as named_beside, output_path
from heavylift.recordings.write.partfile import written
from numpy.typing import NDArray

from .estimation import Identifiable, InputEstimates, estimate, scene_text, simulator, spread
from .mapping import LogChannel, LogSignals, measured
from .validation import (
    LEVEL,
    Alignment,
    ChannelComparison,
    Curve,
    accuracy,
    aligned,
    beside,
    compared,
    curves_of,
    overlapping,
)

QUIET = 1e-3  # of a channel's range: least scatter that it is taken to have
ROOM = 5.0  # rows at either end of the overlap that estimates leave out, for the offset moves
EARTH = 9.80665  # gravity of a recording without a scene [m/s2]
Floats = NDArray[np.float64]


@dataclass(frozen=True)
class MeasurementResult:
    """Result of comparing a measured log with a recording.

    `estimates`: value and half-width at 95 % by name; `not_identified`: reasons by name; number of log rows outside the
    run; paths of the written recording and scene.
    """

    at: Alignment
    comparisons: list[ChannelComparison]
    estimates: dict[str, tuple[str, str]]
    not_identified: dict[str, str]
    outside: int
    recording: Path = Path()
    scene: Path | None = None

    @property
    def message(self) -> list[str]:
        """The results of comparing log and run as lines of text for the user."""
        lines = [str(self.at), *map(str, self.comparisons)]
        lines += [f"{name}: {value} +- {half}" for name, (value, half) in self.estimates.items()]
        lines += [f"{name}: not fitted, {why}" for name, why in self.not_identified.items()]
        return lines + ([f"rows of the log outside of the run: {self.outside}"] if self.outside else [])

    def data(self) -> dict[str, object]:
        """Return the results of comparing log and run as plain data in SI units, with standard uncertainties."""
        files = {"recording": str(self.recording), "scene": str(self.scene) if self.scene else None}
        return {**asdict(self), **files, "told": self.message}


def measure(
    path: str | Path,
    log: str | Path,
    maps: Sequence[str],
    offset: float | None = None,
    wanted: Sequence[str] = (),
    given: Sequence[str] = (),
    out: str | Path | None = None,
    force: bool = False,
    say: Callable[[str], None] = lambda sentence: None,
) -> MeasurementResult:
    """Compare the recording `path` with a measured log, and write both to a new recording (default:
    NAME-measured.mcap).

    `offset`: time of the run at the log's time 0, estimated if not given; `wanted`: inputs of the scene to estimate,
    which are written into a scene beside the new recording; `given`: inputs with their uncertainty, `block.mass +- 3
    %`, in addition to those of the scene. Raises HeavyliftError.
    """
    path = file_path(path)
    out = output_path(out or named_beside(path, "-measured.mcap"), "a recording", (".mcap",))
    rec = Recording(path)
    again = wanted or given or _uncertain(rec)
    begun = Beginning.left(path, RecordedRun(path), "record it with `heavylift run`") if again else None
    fitted = inputs(begun.scene, wanted) if begun else []
    known = uncertain_inputs(begun.scene, given) if begun else []
    plan = msgspec.json.decode(rec.attachments.get(RESOLVED, b"{}"))
    found = measured(rec, log, maps, plan.get("gravity", EARTH))
    own = curves_of(rec, found.compared)
    at = _placed(rec, found, own, offset)
    fit, u_input = InputEstimates({}, {}, {}, at), list[Floats]()
    rate = 1.0 / float(np.median(np.diff(found.t)))
    if begun and fitted:
        rows = overlapping(own[0], found.t, at.offset, ROOM / rate)
        fit = estimate(simulator(begun, fitted, found.compared, rate, say), fitted, _reported(rec, found, rows), at)
    if begun and known:
        start, sigma = np.array([p.value for p in known]), np.array([p.sd for p in known])
        u_input = spread(simulator(begun, known, found.compared, rate, say), start, sigma, own)
    comparisons, errors = compared(rec, found, fit.at, u_input)
    rows = overlapping(own[0], found.t, fit.at.offset)
    estimates = {fitted[i].name: fitted[i].rounded(x, fit.sigma[i]) for i, x in fit.values.items()}
    unknown = {fitted[i].name: why for i, why in sorted(fit.unknown.items())}
    outcome = MeasurementResult(fit.at, comparisons, estimates, unknown, int((~rows).sum()))
    name, lines = found.log.path.name, "".join(f"{column}: {line}\n" for column, line in found.lines.items())
    files = {name: found.log.path.read_bytes(), "map.yaml": lines.encode()}
    made = extended(path, out, beside(found, fit.at, errors, rows), {"measured": outcome.data()}, files, force)
    outcome = replace(outcome, recording=made)
    if begun is None or not estimates:
        return outcome
    text = scene_text(begun.scene, fitted, estimates, name)
    return replace(outcome, scene=written(text, made.with_suffix(".yaml"), "a scene", (".yaml",), force))


def _uncertain(rec: Recording) -> bool:
    """Return whether the recorded scene states uncertain inputs."""
    files = rec.attachments
    text = files.get(MERGED) or next((text for name, text in files.items() if name != RESOLVED), b"")
    return RESOLVED in files and bool(uncertainties(read(text.decode(errors="replace"), rec.path.name)))


def _placed(rec: Recording, log: LogSignals, model: list[Curve], offset: float | None) -> Alignment:
    """Return the given or estimated clock offset; raises RecordingError if no rows of the log lie within the run."""
    T = model[0][0]
    if len(T) < 2:
        raise RecordingError(f"{rec.path}: the recording has no samples to compare; simulate a longer run")
    at = aligned(model, log.t, [c.values for c in log.compared]) if offset is None else Alignment(offset)
    if overlapping(model[0], log.t, at.offset).sum() < 2:
        a, b = log.t[0] + at.offset, log.t[-1] + at.offset
        raise RecordingError(
            f"{log.log.path}: rows {log.log.rows[0]} to {log.log.rows[-1]} are {a:.6g} to {b:.6g} s of the run, which "
            f"goes from {T[0]:.6g} to {T[-1]:.6g} s; they do not overlap: give another --offset"
        )
    return at


def _reported(rec: Recording, log: LogSignals, rows: NDArray[np.bool_]) -> Identifiable:
    """Return the measured data for the estimation from these rows of the log."""
    common = [np.hypot(c.sigma[rows], accuracy(rec) / LEVEL * np.abs(c.values).max()) for c in log.compared]
    return Identifiable(
        log.t[rows], [c.values[rows] for c in log.compared], common, [_scatter(c) for c in log.compared]
    )


def _scatter(channel: LogChannel) -> float:
    """Return the standard deviation of white noise with the channel's median step between rows."""
    steps = np.abs(np.diff(channel.values))
    return float(np.hypot(1.05 * np.median(steps), QUIET * np.ptp(channel.values))) or 1.0
