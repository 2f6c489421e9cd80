"""Swings of a signal in a stage, from its samples: amplitude and period, and what may hide between the samples."""

from dataclasses import dataclass
from math import atan2, cos, pi, sin, sqrt
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
FEWEST = 8  # samples of a stage in which a swing is looked for
SHOWN = 0.5  # of the mean square speed is in the ways between samples: of a sinusoid, at 2.3 samples a period
FINE = 1e-9  # of a frequency
SMALLEST = 1e-4  # [m or rad] amplitude of what has no period


@dataclass(frozen=True)
class Span:
    """Time span of a stage: begin and end [s]; `free`: no drive moves during it; `lifts`: a load is lifted off during
    it."""

    name: str
    start: float
    end: float
    free: bool
    lifts: bool


class Swing(NamedTuple):
    """Amplitude [m or rad] and period [s] of the sinusoid that fits a signal best; 0 if none fits."""

    amplitude: float
    period: float


def swing(t: Floats, x: Floats, span: Span) -> Swing | None:
    """Return the swing of a signal (n, 3) or (n, 1) in a stage, along the horizontal direction of its largest
    motion."""
    inside = (t >= span.start) & (t <= span.end)
    since, across = t[inside] - span.start, x[inside]
    if len(since) < FEWEST:
        return None
    y = across[:, 0] - across[:, 0].mean()
    if across.shape[1] == 3:  # level
        z = across[:, 1] - across[:, 1].mean()
        turned = 0.5 * atan2(2.0 * float((y * z).sum()), float((y * y).sum() - (z * z).sum()))
        y = y * cos(turned) + z * sin(turned)
    amplitude = 0.5 * (top(since, y) + top(since, -y))
    return Swing(amplitude, _period(since, y) if amplitude > SMALLEST else 0.0)


def top(t: Floats, y: Floats) -> float:
    """Return the maximum of the parabola through the largest sample and its neighbours."""
    k = int(np.argmax(y))
    if not 0 < k < len(y) - 1:
        return float(y[k])
    a, b = t[k - 1] - t[k], t[k + 1] - t[k]
    left, right = y[k - 1] - y[k], y[k + 1] - y[k]
    bent, slope = (left / a - right / b) / (a - b), (left * b / a - right * a / b) / (b - a)
    return float(y[k] - slope * slope / (4.0 * bent)) if bent < 0.0 else float(y[k])


def _period(t: Floats, y: Floats) -> float:
    """Return the period [s] of the sinusoid on a straight line that fits best; 0 if fewer than two periods are seen, or
    the fit is poor."""
    from scipy.optimize import minimize_scalar  # not before a swing is looked for: it takes a third of a second

    even = np.linspace(t[0], t[-1], len(t))
    spectrum = np.abs(np.fft.rfft(np.interp(even, t, y) * np.hanning(len(t))))
    k, lasts = int(np.argmax(spectrum[1:])) + 1, float(t[-1])
    line = [np.ones_like(t), t]

    def left(f: float) -> float:
        A = np.column_stack([*line, np.cos(2 * pi * f * t), np.sin(2 * pi * f * t)])
        x, *_ = np.linalg.lstsq(A, y, rcond=None)
        return float(((A @ x - y) ** 2).sum())

    low = max(0.4, k - 1.0) / lasts
    f = float(minimize_scalar(left, bounds=(low, high := low + 2.2 / lasts), options={"xatol": FINE * high}).x)
    return 1.0 / f if f * lasts >= 2.0 and left(f) < 0.5 * float((y * y).sum()) else 0.0


def unseen(t: Floats, x: Floats, speed: Floats | None, span: Span) -> float:
    """Return the amplitude of a swing that may hide between samples (n, columns) in a stage: with the part of the speed
    that they do not show, at the lowest frequency that they cannot show."""
    inside = (t >= span.start) & (t <= span.end)
    if speed is None or inside.sum() < FEWEST:
        return 0.0
    steps, ways = np.diff(t[inside]), (np.diff(x[inside], axis=0) ** 2).sum(axis=1)
    shown, whole = (ways / steps).sum() / steps.sum(), float((speed[inside] ** 2).mean())
    return float(sqrt(2.0 * (whole - shown)) * steps.max() / pi) if shown < SHOWN * whole else 0.0
