"""How far a run is from the reference in each quantity that a scene can ask; all errors are relative.

rope tension    |peak - true peak| / true peak, of every hook rope (or rope of a mechanism); a sample above the true
                peak counts as well: the interpolant of a long step can overshoot
swing           while the load is left to itself: error of frequency and of amplitude of the sinusoid that fits best
position        at equal times since each stage began, relative to the longest way; joints one by one
lift-off time   |t - true t| / duration of the stage, or half a second if that is shorter

Rungs move the ends of stages by seconds, so places are compared stage by stage.

Swing and position are not quite what `heavylift check` predicts (`nodes.plan.fidelity`) but mostly stricter:
`MEANT` says to the reader of a report where they differ.
"""

from __future__ import annotations

from collections.abc import Iterator
from math import inf, pi

import numpy as np
from heavylift.kernel.errors import SceneError
from heavylift.nodes.fidelity import ASKABLE
from heavylift.nodes.plan.fidelity import SHORTEST, USUAL, Asked
from heavylift.nodes.scene import LoadedScene

from .playing import Shown, Span

MEANT: dict[Asked, str] = {
    "rope tension": "peak of each hook rope; a sample above the true peak counts as well",
    "swing": "frequency and amplitude of the sinusoid that fits best, in each stage that only waits, relative to that "
    "stage's own. `heavylift check` predicts the largest excursion of the whole run and the frequency after the last "
    "move: this here is stricter after a swing that nearly cancels, and blind to what happens in moves",
    "position": "largest difference at equal times since each stage began, relative to the longest way from the start. "
    "`heavylift check` predicts it as stages begin and at the end only, relative to the longest way between two of "
    "them: this here is stricter, unless moves add up to a longer way",
    "lift-off time": "relative to the duration of the stage, or to half a second if that is shorter",
}
LOADED = 1.0  # [N] a peak below it is that of a rope that never carries
STILL = 1e-6  # [m or rad] what moves or swings less does neither
FEWEST = 16  # samples of a window in which a swing can be seen


def asked(words: str, known: tuple[str, ...]) -> tuple[Asked, ...]:
    """The quantities of a list such as "rope tension, swing"; SceneError for one that does not exist."""
    wanted = [word.strip() for word in words.strip("[] ").split(",") if word.strip()]
    for word in wanted:
        if word not in ASKABLE:
            raise SceneError(f"--ask '{word}': a scene cannot be asked this; ask {', '.join(ASKABLE)}")
    return tuple(q for q in ASKABLE if q in (wanted or known))


def default_limit(scene: LoadedScene) -> float:
    """The largest error that a scene accepts of what it asks; 1 % if it asks nothing, whatever its accuracy."""
    return scene.scene.wanted_accuracy if scene.scene.ask else USUAL


def askable(shown: Shown) -> dict[Asked, str]:
    """Quantity -> "" if the run tells it, else why it does not."""
    swings = any(swing(shown, span, span.end - span.start) for span in shown.spans if span.free)
    return {
        "rope tension": "" if (shown.peaks > LOADED).any() else "no rope of the scene carries anything",
        "swing": "" if swings else "nothing swings while it is left to itself: add a stage that waits, or end later",
        "position": "" if (_way(shown) > STILL).any() else "nothing in the scene moves",
        "lift-off time": "" if any(s.lifts for s in shown.spans[:-1]) else "no stage of the scene ends 'until lifted'",
    }


def errors(run: Shown, true: Shown, ask: tuple[Asked, ...]) -> dict[Asked, float]:
    """The error of each quantity asked; infinite if the run never comes to where it shows."""
    each = {"rope tension": _tension, "swing": _swings, "position": _position, "lift-off time": _lift_off}
    return {quantity: max(each[quantity](run, true), default=inf) for quantity in ask}


def farthest(run: Shown, true: Shown) -> float:
    """The largest distance [m or rad] of a place from the true one, at equal times since each stage began."""
    pairs = _places(run, true)
    spatial = true.columns == ["x", "y", "z"]
    return max((float((np.linalg.norm(d, axis=1) if spatial else np.abs(d)).max()) for d in pairs), default=inf)


def _tension(run: Shown, true: Shown) -> Iterator[float]:
    for peak, shown, right in zip(run.peaks, run.tension.max(axis=0), true.peaks, strict=True):
        if right > LOADED:
            yield max(abs(float(peak / right) - 1.0), float(shown / right) - 1.0)


def _lift_off(run: Shown, true: Shown) -> Iterator[float]:
    for mine, right in _pairs(run, true):
        if right.lifts:
            yield abs(mine.end - right.end) / max(SHORTEST, right.end - right.start)


def _position(run: Shown, true: Shown) -> Iterator[float]:
    way = _way(true)
    moving = way > STILL
    for d in _places(run, true):
        if true.columns == ["x", "y", "z"]:
            yield float(np.linalg.norm(d, axis=1).max() / np.linalg.norm(way))
        else:
            yield float((np.abs(d[:, moving]) / way[moving]).max())


def _places(run: Shown, true: Shown) -> Iterator[np.ndarray]:
    """Differences of places (n, columns) of each stage that both come to."""
    for mine, right in _pairs(run, true):
        lasts = min(mine.end - mine.start, right.end - right.start)
        inside = true.t[(true.t > right.start) & (true.t < right.start + lasts)] - right.start
        since = np.concatenate([[0.0], inside, [lasts]])
        yield _at(run, mine.start + since) - _at(true, right.start + since)


def _at(shown: Shown, t: np.ndarray) -> np.ndarray:
    """(n, columns) at any times, by monotone cubics, which overshoot nowhere."""
    from scipy.interpolate import PchipInterpolator

    times, first = np.unique(shown.t, return_index=True)
    return np.asarray(PchipInterpolator(times, shown.places[first], axis=0)(np.clip(t, times[0], times[-1])))


def _pairs(run: Shown, true: Shown) -> Iterator[tuple[Span, Span]]:
    """Stages of both runs, in order; the last of a run that was stopped by its end is as long as both have it."""
    return zip(run.spans, true.spans, strict=False)


def _way(shown: Shown) -> np.ndarray:
    """(columns,) the longest way of each from its start."""
    way: np.ndarray = np.abs(shown.places - shown.places[0]).max(axis=0)
    return way


def _swings(run: Shown, true: Shown) -> Iterator[float]:
    for mine, right in _pairs(run, true):
        lasts = min(mine.end - mine.start, right.end - right.start)
        exact = swing(true, right, lasts) if right.free else None
        if exact is not None:
            got = swing(run, mine, lasts)
            yield max(abs(a / b - 1.0) for a, b in zip(got, exact, strict=True)) if got else 1.0


def swing(shown: Shown, span: Span, lasts: float) -> tuple[float, float] | None:
    """Frequency [Hz] and amplitude of the sinusoid, on a straight line, that fits the swing of a stage best."""
    inside = (shown.t >= span.start) & (shown.t <= span.start + lasts)
    t, first = np.unique(shown.t[inside], return_index=True)
    if len(t) < FEWEST:
        return None
    across = shown.places[inside][first][:, :2] if shown.columns == ["x", "y", "z"] else shown.places[inside][first]
    across = across - across.mean(axis=0)
    sizes, directions = np.linalg.svd(across, full_matrices=False)[1:]
    if sizes[0] / np.sqrt(len(t)) < STILL:
        return None
    return _sinusoid(t - t[0], across @ directions[0])


def _sinusoid(t: np.ndarray, y: np.ndarray) -> tuple[float, float] | None:
    from scipy.optimize import minimize_scalar

    even = np.linspace(t[0], t[-1], len(t))
    spectrum = np.abs(np.fft.rfft((np.interp(even, t, y) - y.mean()) * np.hanning(len(t))))
    k = int(np.argmax(spectrum[1:])) + 1
    line = np.column_stack([np.ones_like(t), t])

    def fit(f: float) -> tuple[float, np.ndarray]:
        A = np.column_stack([line, np.cos(2 * pi * f * t), np.sin(2 * pi * f * t)])
        x, *_ = np.linalg.lstsq(A, y, rcond=None)
        return float(((A @ x - y) ** 2).sum()), x

    lowest, step = max(0.4, k - 1.0) / t[-1], 1.0 / t[-1]
    best = minimize_scalar(lambda f: fit(f)[0], bounds=(lowest, lowest + 2.2 * step), method="bounded",
                           options={"xatol": 1e-10 * step})  # fmt: skip
    left, x = fit(best.x)
    if left > 0.5 * float((y**2).sum()):
        return None  # no sinusoid
    return float(best.x), float(np.hypot(x[2], x[3]))
