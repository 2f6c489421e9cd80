"""Swings of a signal in a stage, from its samples: amplitude and period, and the amplitude hidden between samples."""

from dataclasses import dataclass
from math import atan2, cos, pi, sin, sqrt
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
FEWEST = 8  # samples of a stage in which a swing is looked for
SHOWN = 0.5  # of the mean square speed is in the ways between samples: of a sinusoid, at 2.3 samples a period
FINE = 1e-9  # of a frequency
STARTS, STEPS = 12, 30  # frequencies from which the best fit is sought, and steps of that
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
    """Amplitude [m or rad] and period [s] of the sinusoid fitted to a signal; zeros if the signal does not
    oscillate."""

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
    """Return the maximum of a sampled signal, interpolated by a parabola through the largest sample and its
    neighbours."""
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
    even, lasts = np.linspace(t[0], t[-1], len(t)), float(t[-1])
    spectrum = np.abs(np.fft.rfft(np.interp(even, t, y) * np.hanning(len(t))))
    low = max(0.4, float(np.argmax(spectrum[1:]))) / lasts
    high = low + 2.2 / lasts
    (left, step), f = min((_fitted(t, y, f), f) for f in np.linspace(low, high, STARTS).tolist())
    # Gauss-Newton steps, shortened where they would not improve the fit
    for _ in range(STEPS):
        trial = min(max(f + step, low), high)
        new = _fitted(t, y, trial)
        f, (left, step) = (trial, new) if new[0] < left else (f, (left, 0.25 * step))
        if abs(step) <= FINE * high:
            break
    return 1.0 / f if f * lasts >= 2.0 and left < 0.5 * float((y * y).sum()) else 0.0


def _fitted(t: Floats, y: Floats, f: float) -> tuple[float, float]:
    """Fit a sinusoid of frequency `f` [Hz] on a straight line to a signal; return the residual sum of squares, and the
    change of the frequency [Hz] that would reduce the sum most."""
    cosine, sine = np.cos(2 * pi * f * t), np.sin(2 * pi * f * t)
    A = np.column_stack([np.ones_like(t), t, cosine, sine])
    x = np.linalg.lstsq(A, y, rcond=None)[0]
    slope = 2 * pi * t * (x[3] * cosine - x[2] * sine)
    change = np.linalg.lstsq(np.column_stack([A, slope]), y, rcond=None)[0][4]
    return float(((A @ x - y) ** 2).sum()), float(change)


def unseen(t: Floats, x: Floats, speed: Floats | None, span: Span) -> float:
    """Return an upper bound, in a stage, of the amplitude of oscillations that are too fast for the sample rate.

    It is the amplitude, at the Nyquist frequency of the samples, of that part of the RMS speed which the sampled
    positions do not explain.
    """
    inside = (t >= span.start) & (t <= span.end)
    if speed is None or inside.sum() < FEWEST:
        return 0.0
    steps, ways = np.diff(t[inside]), (np.diff(x[inside], axis=0) ** 2).sum(axis=1)
    shown, whole = (ways / steps).sum() / steps.sum(), float((speed[inside] ** 2).mean())
    return float(sqrt(2.0 * (whole - shown)) * steps.max() / pi) if shown < SHOWN * whole else 0.0
