"""Validation of a run by a measurement: E = S - D of each channel, and the uncertainty u_val of that difference.

ASME V&V 20-2009: u_val^2 = u_num^2 + u_input^2 + u_D^2, standard uncertainties. If |E| is well above u_val, E is the
error of the model; if it is within, model and measurement cannot be distinguished. u_num: accuracy of tensions from the
run's certificate, else from its tolerance, and of linear interpolation between samples; u_input: from runs with inputs
one standard uncertainty more and less; u_D: uncertainty of the sensor, from the map, and of the clock offset.

Alignment, t of the run = t of the log + offset: a coarse search maximises the mean correlation of the channels, with
the share of their motion in the overlap as weight; least squares refine it, each measured channel being a line a + b S
of the model's. The uncertainty is that of Gauss-Newton, widened for autocorrelated residuals (Sokal 1997, Monte
Carlo Methods in Statistical Mechanics).
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from heavylift.kernel.errors import RecordingError
from heavylift.nodes.plan.plan import TOLERANCE_OF_ACCURACY
from heavylift.recordings import Recording, Signal
from heavylift.recordings.format.samples import ERROR, MEASURED
from heavylift.recordings.render.curves import larger
from numpy.typing import NDArray
from scipy.optimize import minimize_scalar

from .mapping import LogChannel, LogSignals

COARSE = 150  # steps of the shorter one in the coarse search
SHORTEST = 0.25  # of the shorter one: less overlap is not looked at
WINDOW = 0.05  # of the shorter one: as far the best offset may be from that of the coarse search
DOUBTED = 0.95  # correlation up to which the offset is reported with a warning
ALIKE = 0.5  # least mean correlation of what is taken to be the same lift
Floats = NDArray[np.float64]
Curve = tuple[Floats, Floats]  # times (n,) [s] and values (n,)


@dataclass(frozen=True)
class Alignment:
    """Clock offset between a log and a run [s], with its standard uncertainty and the mean correlation of the
    channels."""

    offset: float
    sigma: float = 0.0
    correlation: float = 1.0
    estimated: bool = False

    def __str__(self) -> str:
        where = f"time 0 of the log is {self.offset:.9g} s of the run"
        if not self.estimated:
            return f"{where}, as given"
        doubt = "" if self.correlation > DOUBTED else ", so low that it may be wrong; see the plot, or give --offset"
        return f"{where} +- {2.0 * self.sigma:.2g} s (95 %), estimated; correlation {self.correlation:.3f}{doubt}"


def aligned(model: Sequence[Curve], t: Floats, values: Sequence[Floats]) -> Alignment:
    """Estimate the clock offset of a log from measured and simulated channels; raises RecordingError if they leave
    it open."""
    T = model[0][0]
    span = min(T[-1] - T[0], t[-1] - t[0])
    step, reach, window = span / COARSE, SHORTEST * span, WINDOW * span
    grid = np.arange(t[0], t[-1] + 0.5 * step, step)
    coarse = [np.interp(grid, t, y) for y in values]
    offsets = np.arange(T[0] + reach - t[-1], T[-1] - reach - t[0] + 0.5 * step, step)
    scores = [_score(model, grid, coarse, offset) for offset in offsets]
    if max(scores) <= 0.0:
        raise RecordingError(
            "no mapped channel varies in both run and log, so their clocks cannot be aligned; give --offset"
        )
    best = float(offsets[int(np.argmax(scores))])
    rows = overlapping(model[0], t, best, window)
    measured = [y[rows] for y in values]

    def residuals(offset: float) -> Floats:
        return np.concatenate(
            [_off_line(s, y) for s, y in zip(_sampled(model, t[rows], offset), measured, strict=True)]
        )

    def misfit(offset: float) -> float:
        return float(np.sum(residuals(offset) ** 2))

    near = min(np.arange(best - window, best + window, 0.25 * step), key=misfit)
    tight = {"xatol": 1e-6 * step}
    offset = float(minimize_scalar(misfit, bounds=(near - step, near + step), method="bounded", options=tight).x)
    r, h = residuals(offset), 0.1 * step
    slope = float(np.sum((residuals(offset + h) - residuals(offset - h)) ** 2)) / (2.0 * h) ** 2
    factor = max(correlation_time(part) for part in np.split(r, len(values)))
    alike = float(
        np.mean([_correlation(s, y) for s, y in zip(_sampled(model, t[rows], offset), measured, strict=True)])
    )
    if alike < ALIKE or slope == 0.0:
        raise RecordingError(f"log and run do not match at any offset (correlation {alike:.2f}); give --offset")
    sigma = float(np.sqrt(factor * np.sum(r * r) / max(1, len(r) - 2 * len(values) - 1) / slope))
    return Alignment(offset, sigma, alike, True)


def overlapping(curve: Curve, t: Floats, offset: float, margin: float = 0.0) -> NDArray[np.bool_]:
    """Return a mask (n,) of the rows of a log that lie within the run, at least `margin` [s] from its ends."""
    at: NDArray[np.bool_] = (t + offset >= curve[0][0] + margin) & (t + offset <= curve[0][-1] - margin)
    return at


def correlation_time(r: Floats) -> float:
    """Return the integrated autocorrelation time of a series in samples, at least 1.

    It is 1 + 2 (sum of autocorrelations), cut at the first window that is five times as long as the result.
    """
    n, r = len(r), r - np.mean(r)
    rho = np.fft.irfft(np.abs(np.fft.rfft(r, 2 * n)) ** 2)[:n]
    if rho[0] <= 0.0:
        return 1.0
    tau = 2.0 * np.cumsum(rho / rho[0]) - 1.0
    window = np.flatnonzero(np.arange(n) >= 5.0 * tau)
    return float(max(1.0, tau[window[0] if len(window) else n - 1]))


def _sampled(model: Sequence[Curve], t: Floats, offset: float) -> list[Floats]:
    return [np.interp(t + offset, T, S) for T, S in model]


def _score(model: Sequence[Curve], t: Floats, values: Sequence[Floats], offset: float) -> float:
    """Return the mean of the squared correlations, each weighted with the share of the motion in the overlap."""
    rows, total = overlapping(model[0], t, offset), 0.0
    if rows.sum() < 3:
        return 0.0
    for (T, S), s, y in zip(model, _sampled(model, t[rows], offset), values, strict=True):
        inside = (t[rows][0] + offset <= T) & (t[rows][-1] + offset >= T)
        covered = max(_motion(y[rows]) / (_motion(y) or 1.0), _motion(S[inside]) / (_motion(S) or 1.0))
        total += max(_correlation(s, y[rows]), 0.0) ** 2 * min(covered, 1.0)
    return total / len(model)


def _motion(x: Floats) -> float:
    return float(np.sum((x - x.mean()) ** 2)) if len(x) else 0.0


def _correlation(s: Floats, d: Floats) -> float:
    norm = np.sqrt(_motion(s) * _motion(d))
    return float((s - s.mean()) @ (d - d.mean()) / norm) if norm > 1e-12 * float(np.sum(s * s) + np.sum(d * d)) else 0.0


def _off_line(s: Floats, d: Floats) -> Floats:
    """Return the residual of `d` from the best line a + b s with b >= 0, relative to the scatter of `d`."""
    s, d = s - s.mean(), d - d.mean()
    b = max(0.0, float(s @ d)) / (float(s @ s) or 1.0)
    off: Floats = (d - b * s) / (float(np.std(d)) or 1.0)
    return off


LEVEL = 2.0  # standard uncertainties of a level of 95 %


@dataclass(frozen=True)
class ChannelComparison:
    """Comparison of one measured channel with the run.

    Mean, RMS and largest error E and its time [s]; validation uncertainty u_val and its parts; share of rows with |E|
    <= 2 u_val; `lacks`: uncertainties that were not stated.
    """

    channel: str
    unit: str
    mean: float
    rms: float
    largest: float
    when: float
    u_val: float
    u_num: float
    u_input: float
    u_D: float
    within: float
    lacks: tuple[str, ...]

    def __str__(self) -> str:
        factor, unit = larger(self.unit)
        mean, rms, most = (f"{factor * x:.3g}" for x in (self.mean, self.rms, self.largest))
        val, num, given, D = (f"{factor * LEVEL * x:.2g}" for x in (self.u_val, self.u_num, self.u_input, self.u_D))
        off = f"E {mean} +- {val} {unit} in the mean, RMS {rms}, {most} at {self.when:.2f} s"
        lacks = (
            f"; u_val lacks the uncertainty of {' and '.join(self.lacks)}, which is not stated" if self.lacks else ""
        )
        return (
            f"{self.channel}: {off}; u_val of num {num}, input {given}, D {D}; {100 * self.within:.0f} % within{lacks}"
        )


def curves_of(rec: Recording, channels: Sequence[LogChannel]) -> list[Curve]:
    """Return the simulated curves of these measured channels, from a recording."""
    rec.load([*dict.fromkeys(channel.signal for channel in channels)])
    return [(rec.signal(channel.signal).t, rec.signal(channel.signal)[channel.column]) for channel in channels]


def compared(
    rec: Recording, log: LogSignals, at: Alignment, u_input: Sequence[Floats]
) -> tuple[list[ChannelComparison], list[Floats]]:
    """Compare each measured channel with the run; return the comparisons, and per channel the errors (n,), simulated
    minus measured.

    `u_input`: standard uncertainty of each channel at the samples of the run; empty if no input has a stated
    uncertainty.
    """
    out, errors = list[ChannelComparison](), list[Floats]()
    for k, (channel, (T, S)) in enumerate(zip(log.compared, curves_of(rec, log.compared), strict=True)):
        rows = overlapping((T, S), log.t, at.offset)
        t = log.t[rows] + at.offset
        s = np.interp(t, T, S)
        error = s - channel.values[rows]
        num = np.full(len(t), np.hypot(accuracy(rec) * float(np.abs(S).max()) / LEVEL, _straight(S)))
        given = np.interp(t, T, u_input[k]) if u_input else np.zeros(len(t))
        sensor = np.hypot(channel.sigma[rows], np.gradient(s, t) * at.sigma)
        val = np.sqrt(num**2 + given**2 + sensor**2)
        most = int(np.argmax(np.abs(error)))
        lacks = ("the sensor",) * (not channel.stated) + ("inputs",) * (not u_input)
        out.append(ChannelComparison(
            channel.name, channel.unit, mean=float(error.mean()), rms=_rms(error), largest=float(error[most]),
            when=float(t[most]), u_val=_rms(val), u_num=_rms(num), u_input=_rms(given), u_D=_rms(sensor),
            within=float(np.mean(np.abs(error) <= LEVEL * val)), lacks=lacks,
        ))  # fmt: skip
        errors.append(error)
    return out, errors


def beside(log: LogSignals, at: Alignment, errors: list[Floats], rows: NDArray[np.bool_]) -> list[Signal]:
    """Return the measured signals, and the differences between run and log, at the log's times on the run's clock."""
    t, found = log.t[rows] + at.offset, dict[str, list[tuple[str, str, Floats]]]()
    parts = [(MEASURED, channel, channel.values[rows]) for channel in log.channels]
    for kind, channel, values in [*parts, *((ERROR, c, e) for c, e in zip(log.compared, errors, strict=True))]:
        found.setdefault(kind + channel.signal, []).append((channel.column, channel.unit, values))
    return [
        Signal(t, np.column_stack([x for _, _, x in parts]), [name for name, _, _ in parts], parts[0][1], signal)
        for signal, parts in found.items()
    ]


def accuracy(rec: Recording) -> float:
    """Return the relative numerical error of recorded rope tensions, from the certificate or else from the tolerance; 0
    for fixed steps."""
    bars = [bar for bar in rec.fact("certified", {}).get("bars", []) if bar["quantity"] == "rope tension"]
    if bars and all(bar["numerical"] is not None for bar in bars):
        return float(max(bar["numerical"] / abs(bar["value"]) for bar in bars))
    return 0.0 if "step" in rec.run else float(rec.run.get("tolerance", "0")) / TOLERANCE_OF_ACCURACY


def _straight(S: Floats) -> float:
    """Return the RMS error of linear interpolation between samples, estimated as an eighth of the second
    differences."""
    return _rms(np.diff(S, 2)) / 8.0 if len(S) > 2 else 0.0


def _rms(x: Floats) -> float:
    return float(np.sqrt(np.mean(x * x)))
