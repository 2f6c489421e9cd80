"""Statistics of an atomic, kept in its state, and random streams.

    self.waits.add(seconds)                   Tally: of observations, each of which counts once
    self.length.set(len(queue), self.now)     TimeWeighted: of a value that holds until it changes
    self.random = stream(self.seed, self.path)

Law and Kelton, Simulation Modeling and Analysis, 1.4; mean and variance in one pass after Welford (1962).
"""

from math import inf, isfinite, nan, sqrt
from random import Random

from heavylift.kernel.errors import ModelError

from .events import Tag


class Tally:
    """Count, mean, minimum and maximum of observations; for no observations, the mean is NaN, the extremes infinite."""

    def __init__(self) -> None:
        self.count, self.mean, self.least, self.most = 0, nan, inf, -inf
        self._squares = 0.0  # of what lies between observations and their mean

    def add(self, x: float) -> None:
        """Add an observation; raises ModelError if it is not finite."""
        if not isfinite(x):
            raise _no_observation(x)
        self.count += 1
        off = x - self.mean if self.count > 1 else 0.0
        self.mean = self.mean + off / self.count if self.count > 1 else float(x)
        self._squares += off * (x - self.mean)
        if x < self.least:
            self.least = x
        if x > self.most:
            self.most = x

    @property
    def deviation(self) -> float:
        """Sample standard deviation of the observations; NaN for fewer than two."""
        return sqrt(self._squares / (self.count - 1)) if self.count > 1 else nan


class TimeWeighted:
    """A piecewise constant value over time, with its time average, minimum and maximum."""

    def __init__(self, value: float = 0.0, since_ns: int = 0) -> None:
        if not isfinite(value):
            raise _no_observation(value)
        self.value = self.least = self.most = value
        self.since = self._changed = since_ns
        self._area = 0.0  # [ns] times value

    def set(self, value: float, now: Tag) -> None:
        """Set the value from the time `now` on; raises ModelError if it is not finite or `now` is in the past."""
        if not isfinite(value):
            raise _no_observation(value)
        self._area, self._changed, self.value = self._until(now), now.t, value
        if value < self.least:
            self.least = value
        elif value > self.most:
            self.most = value

    def mean(self, now: Tag) -> float:
        """Return the time average until `now`; NaN if no time has passed."""
        area = self._until(now)
        return area / (now.t - self.since) if now.t > self.since else nan

    def _until(self, now: Tag) -> float:
        if now.t < self._changed:
            raise ModelError(f"a time average cannot go back in time from {Tag(self._changed)} to {now}")
        return self._area + self.value * (now.t - self._changed)


def stream(seed: int, name: str) -> Random:
    """Return a random generator that is independent for each seed and name; the name may be a model's path."""
    return Random(f"{seed}/{name}")


def _no_observation(x: float) -> ModelError:
    return ModelError(f"{x} is not a valid observation: give a finite number")
