"""Probability distributions of times in seconds, drawn from the random stream of the atomic model that uses them.

Law and Kelton, Simulation Modeling and Analysis, 6.2; PERT-beta after Malcolm et al. (1959) with shape 4.
"""

from abc import ABC, abstractmethod
from collections.abc import Sequence
from itertools import accumulate
from math import isfinite, log, sqrt
from random import Random

from heavylift.kernel.errors import ModelError

SHAPE = 4.0  # of PERT: how many times the most likely value counts in the mean (a + 4 m + b) / 6


class Distribution(ABC):
    """Base class of distributions of times >= 0 [s] with the mean `mean` [s]; `draw` takes a sample from a stream."""

    mean: float

    @abstractmethod
    def draw(self, random: Random) -> float:
        """Draw a time [s] from a random stream."""


class Fixed(Distribution):
    """A constant `time` [s]."""

    def __init__(self, time: float) -> None:
        self.mean = _checked(self, time=time)[0]

    def draw(self, random: Random) -> float:
        """Return the constant time [s]."""
        return self.mean


class Uniform(Distribution):
    """Uniformly distributed times from `low` [s] to `high` [s]."""

    def __init__(self, low: float, high: float) -> None:
        self.low, self.high = _checked(self, low=low, high=high)
        _rising(self, low, high)
        self.mean = (low + high) / 2

    def draw(self, random: Random) -> float:
        """Draw a uniformly distributed time [s] from a random stream."""
        return self.low + (self.high - self.low) * random.random()


class Exponential(Distribution):
    """Exponentially distributed times: the intervals of a Poisson process."""

    def __init__(self, mean: float) -> None:
        self.mean = _checked(self, mean=mean)[0]

    def draw(self, random: Random) -> float:
        """Draw an exponentially distributed time [s] from a random stream."""
        return -log(1.0 - random.random()) * self.mean


class Erlang(Distribution):
    """The sum of `phases` exponentially distributed times with equal means."""

    def __init__(self, phases: int, mean: float) -> None:
        self.mean = _checked(self, phases=phases, mean=mean)[1]
        if not isinstance(phases, int) or phases < 1:
            raise ModelError(f"Erlang: {phases} phases; give a whole number of at least 1")
        self.phases = phases

    def draw(self, random: Random) -> float:
        """Draw an Erlang-distributed time [s] from a random stream."""
        product = 1.0
        for _ in range(self.phases):
            product *= 1.0 - random.random()
        return -log(product) * self.mean / self.phases


class Triangular(Distribution):
    """Triangularly distributed times from `low` [s] to `high` [s], most likely `mode` [s]."""

    def __init__(self, low: float, mode: float, high: float) -> None:
        self.low, self.mode, self.high = _checked(self, low=low, mode=mode, high=high)
        _rising(self, low, mode, high)
        self.mean = (low + mode + high) / 3

    def draw(self, random: Random) -> float:
        """Draw a triangularly distributed time [s] from a random stream."""
        return random.triangular(self.low, self.high, self.mode)


class Pert(Distribution):
    """A beta distribution from an optimistic time `low` [s] to a pessimistic one `high` [s], most likely `mode` [s]."""

    def __init__(self, low: float, mode: float, high: float) -> None:
        self.low, self.mode, self.high = _checked(self, low=low, mode=mode, high=high)
        _rising(self, low, mode, high)
        self.mean = (low + SHAPE * mode + high) / (SHAPE + 2)

    def draw(self, random: Random) -> float:
        """Draw a PERT-distributed time [s] from a random stream."""
        width = self.high - self.low
        if not width:
            return self.low
        first = 1 + SHAPE * (self.mode - self.low) / width
        return self.low + width * random.betavariate(first, SHAPE + 2 - first)


class LogNormal(Distribution):
    """Log-normally distributed times, which themselves have this `mean` [s] and standard `deviation` [s]."""

    def __init__(self, mean: float, deviation: float) -> None:
        self.mean, self.deviation = _checked(self, mean=mean, deviation=deviation)
        if not mean:
            raise ModelError("LogNormal: mean is 0; it must be positive")
        variance = log(1 + (deviation / mean) ** 2)
        self._location, self._scale = log(mean) - variance / 2, sqrt(variance)

    def draw(self, random: Random) -> float:
        """Draw a log-normally distributed time [s] from a random stream."""
        return random.lognormvariate(self._location, self._scale)


class Empirical(Distribution):
    """An empirical distribution: listed `times` [s] with their `weights` [1] (None: equal weights)."""

    def __init__(self, times: Sequence[float], weights: Sequence[float] | None = None) -> None:
        self.times = _checked(self, **{f"times[{n}]": time for n, time in enumerate(times)})
        shares = (
            [1.0] * len(times)
            if weights is None
            else _checked(self, **{f"weight {n}": x for n, x in enumerate(weights)})
        )
        if not times or len(shares) != len(times) or not sum(shares):
            raise ModelError(
                f"Empirical: {len(times)} times and {len(shares)} weights; give one weight for each time, at "
                "least one above zero"
            )
        self._sums = list(accumulate(shares))
        self.mean = sum(time * share for time, share in zip(times, shares, strict=True)) / self._sums[-1]

    def draw(self, random: Random) -> float:
        """Draw one of the listed times [s] from a random stream, according to the weights."""
        return random.choices(self.times, cum_weights=self._sums)[0]


def _checked(distribution: Distribution, **given: float) -> list[float]:
    """Return the given values as floats; raises ModelError if one is negative or not finite."""
    for name, x in given.items():
        if isinstance(x, bool) or not isinstance(x, float | int) or not isfinite(x) or x < 0:
            raise ModelError(f"{type(distribution).__name__}: {name} is {x!r}; give a finite number of seconds >= 0")
    return [float(x) for x in given.values()]


def _rising(distribution: Distribution, *ends: float) -> None:
    if list(ends) != sorted(ends):
        raise ModelError(
            f"{type(distribution).__name__}: {', '.join(f'{x:g}' for x in ends)} s are not in ascending order; "
            "sort them"
        )
