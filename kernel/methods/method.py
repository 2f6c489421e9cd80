"""Interface of an integration method: the stages of one step, the solution inside the step, and its amplification.

The methods run on floats and are traced, like all code of the kernel. A method sees the equations only through `rate(t,
among, y)`, so that it serves every scene; `among` is a time inside the step, which selects the piece of a profile where
two pieces meet.

The module also defines the state block X by name, the result of one evaluation of the equations, and the null method
for statics, which takes no steps.
"""

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from types import MappingProxyType, SimpleNamespace
from typing import Protocol

import numpy as np
from heavylift.kernel.compiler.emit import EmittedParts
from heavylift.kernel.compiler.function import Function, Places
from heavylift.kernel.compiler.symbol import Value, any_of, minimum, select

SCALARS = (
    # control: loop flags, then why it stopped, attempts left in this call
    "run", "due", "locate", "status", "budget",
    # time: now, proposed step, step boundary that no step crosses, horizon behind which steps stay tentative
    "t", "h", "t_stop", "until",
    # tolerance and its scale, step control, earliest time at which a scene may count as still, and what rounding does
    "tol", "scale", "h_min", "h_max", "error", "forced", "t_rest", "grain", "faint",
    "accepted", "rejected", "tentative", "still",
    # last step: start, length, bracket of a root, whether only a stage has seen it, status and loop without it
    "t0", "h0", "lo", "hi", "doubt", "calm", "more",
    # samples: next, period, local time of sample 0 of this stretch, number within the stretch, row, rows allowed
    "t_out", "dt_out", "t_base", "count", "row", "rows",
)  # fmt: skip


class StepState(SimpleNamespace):
    """State block X of the stepping loop, with its numbers and vectors as attributes."""

    y: Value  # (ny,) state and derivative now, then at the start of the step
    f: Value
    d0: Value
    f0: Value
    T: Value  # (n_ropes,) tensions, the largest since the last sample, and when
    peak: Value
    peak_time: Value
    G: Value  # (n_guards,)
    gap: Value  # (n_rows,) of the constraint rows
    slip: Value
    pivot: Value


class Evaluated(Protocol):
    """Result of one evaluation of the equations: derivative (ny,), tensions (n_ropes,) and guards (n_guards,)."""

    dy: Value
    T: Value
    G: Value
    drift: Value  # of the constraint rows
    reach: Value  # longest step in which shapes cannot pass each other
    window: Value  # the same for fixed steps


class Rate(Protocol):
    """Right-hand side of the equations of motion at time t, state y; `among`: a time in the same profile piece as t."""

    def __call__(self, t: Value, among: Value, y: Value) -> Evaluated: ...


LONGEST = 0.1  # [s] a step that nothing else bounds
LEFT = 1e-10  # [s] before a boundary a step ends at it: by rounding nothing would be left for the next one


@dataclass(frozen=True)
class Exponents:
    """Exponents of PI step-size control (Gustafsson)."""

    down: float  # shrinkage: error^down
    up: float  # growth: error^up last_error^memory
    memory: float
    held: float = 1.0  # a step that would grow by less keeps its length, so that its matrix factors are used again


@dataclass
class Attempt:
    """An attempted step: solution and derivative at its end, evaluation there, data of the interpolant.

    `error`: estimate of the local error for `control.ErrorControl`: one vector (ny,), a pair of vectors, or None.
    `seen`: for each stage, its fraction of the step and whether a guard is negative there.
    """

    y: Value
    f: Value
    r: Evaluated
    error: Value
    seen: list[tuple[float, Value]]
    k: list[Value]
    sound: Value = None  # whether its equations were solved; None: there are none
    fresh: Value = None  # whether they had a new Jacobian


class StepCode(Protocol):
    """Interface of native stepping functions that are called by name."""

    def call(self, name: str, *blocks: np.ndarray) -> None: ...


Build = Callable[..., Function]  # (name, part) -> native function of X and P; with matrices=True of M, too


class Method(ABC):
    """Base class of integration methods.

    `order` of the solution; `vectors`: names of the (ny,) blocks for `interpolate`. Implicit methods solve their
    equations before `attempt` in parts of their own (`prologue`), keep numbers in `scalars` and matrices in a block M
    of `matrices` doubles. `evaluations`: number of evaluations of the equations in every attempt; `counted`: scalars
    that count further operations, and how many evaluations each takes.
    """

    name: str
    order: int
    # [s] bounds what a guard can do unseen in motion so slow that the error estimate allows any step
    longest = LONGEST  # [s] step
    evaluations: int
    vectors: tuple[str, ...]
    exponents: Exponents | None = None  # None: no error estimate, fixed steps only
    scalars: tuple[str, ...] = ()
    counted: Mapping[str, int] = MappingProxyType({})
    matrices = 0
    native = True  # whether native code takes the steps
    completes = False  # whether `interpolate` needs `complete` first

    def prologue(
        self, build: Build, at: Places, rate: Function, sizes: Mapping[str, int]
    ) -> tuple[Function | EmittedParts, ...]:
        """Return the native functions that run before `attempt` in each step; `at`: places in memory block X."""
        return ()

    @property
    def implicit(self) -> bool:
        """Whether the method is implicit and may damp fast motions numerically."""
        return bool(self.matrices)

    def run(self, code: StepCode, at: Places, sizes: Mapping[str, int]) -> StepCode:
        """Return the native stepping functions; methods without native steps replace them by Python functions."""
        return code

    def constants(self) -> dict[str, Value]:
        """Return, by name, the constants of the integration method that native code reads from memory."""
        return {}

    def forgotten(self) -> dict[str, float]:
        """Return the values to which the method resets its stored variables after a jump of the derivative, by name."""
        return {}

    @abstractmethod
    def attempt(self, s: StepState, rate: Rate, h: Value, among: Value) -> Attempt:
        """Attempt a step from (s.t, s.y) with derivative s.f to s.t + h."""

    @abstractmethod
    def keep(self, s: StepState, h: Value, a: Attempt) -> None:
        """Store in the state s what `interpolate` needs to compute states inside the attempted step."""

    def complete(self, s: StepState, rate: Rate) -> None:
        """Compute the remaining stages of the dense output, when it is first used."""
        raise AssertionError(f"method {self.name}: the dense output has no remaining stages")

    @abstractmethod
    def interpolate(self, s: StepState, x: Value) -> Value:
        """Return the state (ny,) at s.t0 + x s.h0 inside the last step."""

    @abstractmethod
    def amplification(self, J: np.ndarray, h: float, nq: int) -> np.ndarray:
        """Return the amplification matrix (n, n) of a step h for y' = J y; its first nq components are coordinates."""


def combine(c: list[float], k: list[Value]) -> Value:
    """Return the sum of c_i k_i; terms with a zero coefficient are left out."""
    # zeros are skipped, or traced code would multiply by them
    return sum(a * x for a, x in zip(c, k, strict=False) if a)


def fallen_in(r: Evaluated) -> Value:
    """Return whether any guard of an evaluation is negative."""
    return any_of(g < 0.0 for g in r.G)


def inside(s: StepState) -> Value:
    """Return a time shortly after the start s.t of a step, which selects the profile piece valid in the step."""
    # at most half a second inside: t_stop may be for ever, and a time so late would lose its digits
    return s.t + 0.5 * minimum(1.0, s.t_stop - s.t)


def length(s: StepState) -> tuple[Value, Value]:
    """Return the length [s] of the step that begins at s.t, and whether it ends at the boundary s.t_stop."""
    # a step that would leave less than LEFT before the boundary ends on it, or the rest would be lost in round-off
    last = s.t + s.h >= s.t_stop - LEFT
    return select(last, s.t_stop - s.t, s.h), last


class Stepless(Method):
    """Base class of integration methods without native steps, of which the kernel uses only the interpolation."""

    native = False
    order = evaluations = 0
    exponents = Exponents(0.0, 0.0, 0.0)

    def attempt(self, s: StepState, rate: Rate, h: Value, among: Value) -> Attempt:
        raise AssertionError("a method without native steps cannot attempt a step")

    def keep(self, s: StepState, h: Value, a: Attempt) -> None:
        raise AssertionError("a method without native steps cannot store a step")

    def amplification(self, J: np.ndarray, h: float, nq: int) -> np.ndarray:
        raise AssertionError("a method without native steps has no amplification matrix")


class AtRest(Stepless):
    """Null method for statics: takes no steps, only evaluates the equations, with one-sided forces not cut at zero."""

    name = "at-rest"
    vectors = ()

    def interpolate(self, s: StepState, x: Value) -> Value:
        return s.d0
