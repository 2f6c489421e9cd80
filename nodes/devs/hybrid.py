"""Hybrid atomic models: between transitions a state vector of real numbers follows an ordinary differential equation.

An event occurs when a guard function falls through zero; its time is the first whole nanosecond at which the guard is
not positive. Only the state at the last transition is stored, so that snapshots stay small: the motion since then is
integrated again with the same steps. Only IEEE arithmetic is used, so runs are bit-identical.

Dormand-Prince 5(4) with dense output: Hairer, Norsett, Wanner, Solving ODEs I, II.4 to II.6.
"""

from collections.abc import Callable, Iterator, Sequence
from math import ceil, fsum, isfinite, isnan, sqrt
from typing import NamedTuple

from heavylift.kernel.algebra.elementary import power
from heavylift.kernel.errors import ModelError
from heavylift.kernel.methods.explicit import DormandPrince5

from .messages import Message
from .models import Atomic
from .ports import Bag, OutPort

State = tuple[float, ...]
Flow = Callable[[State], Sequence[float]]
LOOKAHEADS = (0.25, 0.5, 0.75, 1.0)  # of a step, at which guards are looked at
STEPS = 1_000_000  # of one look ahead
RESOLVED = 2  # [ns] after the one before, an event of a guard shows rounding of time, and no motion
CROWD = 1000  # such events, of which no OTHERS in a row were later, that are chatter
OTHERS = (
    10  # where one side is slow, the way back from it takes longer than the resolution, and cycles may have more sides
)
ALONE = 1e-14  # [s] steps that are shorter lead nowhere


class Trajectory(Message):
    """Message with a sample of the continuous state of a hybrid model."""

    state: tuple[float, ...]


class Hybrid(Atomic):
    """Base class of hybrid models: atomic DEVS models whose continuous state is integrated between events.

    A subclass overrides `start`, `flow` (the derivatives) and, if needed, `guards` (zero-crossing functions), `tell`
    (output at an event), `fell` (transition at an event) and `heard` (transition for inputs). `start`, `fell` and
    `heard` must call `go` with the new state, from which the integration continues.

    `longest` [s] limits the integration step, `tolerance` the error of each step relative to 1 + |x|, and `horizon` [s]
    how far the model integrates ahead at once. Two events of the same guard within a quarter of a step may be missed,
    unless the first one is at the beginning of the step. With `sampled` [ns], the state is sent through the port
    `trajectory` at all multiples of that time, which changes no event; the model is then never passive.
    """

    tolerance, longest, horizon = 1e-10, 0.1, 10.0
    sampled = 0
    _crowd: tuple[int, int, int, tuple[int, ...]] = 0, 0, -1, ()
    """Events that follow each other closely: their number, the later events that do not, the time of the last [ns],
    their guards."""

    def __init__(self, name: str) -> None:
        super().__init__(name)
        self._sample = False  # the next transition is one
        if self.sampled:
            self.add_out("trajectory", Trajectory)

    def _port_name(self, name: str) -> str:
        if hasattr(Hybrid, name) or name in ("state", "ahead", "fallen"):
            raise ModelError(
                f"{self.path}: a port cannot be named {name}: every hybrid model has an attribute of this name"
            )
        return super()._port_name(name)

    def flow(self, x: State) -> Sequence[float]:
        """Return the time derivatives of a hybrid model's state x; if all are zero, the model waits for an input."""
        raise ModelError("the model defines no flow(); define it")

    def guards(self, x: State) -> Sequence[float]:
        """Return the values of a hybrid model's guards at the state x; an event occurs when one falls through zero.

        The number of guards must always be the same."""
        return ()

    def tell(self, which: tuple[int, ...]) -> None:
        """Send the output of a hybrid model at an event, before its transition `fell`.

        `which`: indices of the guards that became negative; `ahead` is the state at the event."""

    def fell(self, which: tuple[int, ...]) -> None:
        """Make the transition of a hybrid model at an event.

        `which`: indices of the guards that became negative; `state` is the state at the event."""
        raise ModelError("a guard became negative, but the model defines no fell(); define it")

    def heard(self, x: Bag) -> None:
        """Make the transition of a hybrid model for the inputs x; `state` is the present state."""
        raise ModelError("an input arrived, but the model defines no heard(); define it")

    def go(self, *x: float) -> None:
        """Set the continuous state of a hybrid model to x at the present time, and schedule its next event."""
        if not all(map(isfinite, x)):
            raise ModelError(f"go() was called with {x}: the state must consist of finite numbers")
        self.state: State = tuple(map(float, x))
        self.ahead, self.fallen, wait = self._next()
        self._began, self._due = self.now.t, self.now.t + wait if wait else None
        self._schedule()

    def _schedule(self) -> None:
        """Wait for the next event, end of the horizon, or sample."""
        now, due = self.now.t, self._due
        sample = now - now % self.sampled + self.sampled if self.sampled else None
        self._sample = sample is not None and (due is None or sample < due)
        then = sample if self._sample else due
        if then is None:
            self.passivate()
        else:
            self.hold_in(then - now)

    def at(self, e: int) -> State:
        """Return the continuous state of a hybrid model e [ns] after its last transition, before the next one."""
        if e <= 0 or not any(self.flow(self.state)):
            return self.state
        for step in _steps(self.flow, self.state, self.tolerance, self.longest):
            if e <= step.end:
                return step.at(e)
        raise AssertionError("steps have no end")

    @property
    def present(self) -> State:
        """The continuous state of a hybrid model at the present time."""
        return self.at(self.now.t - self._began)

    def output(self) -> None:
        """Send the state of a hybrid model as a sample, or its output at an event by calling `tell`."""
        if self._sample and isinstance(port := self.ports["trajectory"], OutPort):
            port.send(Trajectory(self.present))
        elif self.fallen:
            self.tell(self.fallen)

    def internal(self) -> None:
        """Make the transition at an event by `fell`; at the end of the integration horizon, continue integrating."""
        if self._sample:
            self._schedule()
            return
        self.state, which = self.ahead, self.fallen
        if which:
            self._check_crowd(which)
            self.fell(which)
        else:
            self.go(*self.state)

    def _check_crowd(self, which: tuple[int, ...]) -> None:
        """Raise ModelError if events of guards accumulate so close together that time does not resolve them."""
        many, later, last, guards = self._crowd
        close = 0 <= last >= self.now.t - RESOLVED
        many, later = (many + 1, 0) if close else (many, later + 1)
        guards = tuple(sorted({*guards, *which}))
        self._crowd = (many, later, self.now.t, guards) if later < OTHERS else (0, 0, self.now.t, which)
        if many >= CROWD:
            named = f"guard{'s' * (len(guards) > 1)} {', '.join(map(str, guards))}"
            raise ModelError(
                f"{named} of guards() became negative {many} times, each at most {RESOLVED} ns after the last: the "
                "flow leads to the guard's zero from both sides; give the guard hysteresis, or let the model rest there"
            )

    def external(self, e: int, x: Bag) -> None:
        """Advance the state of a hybrid model to the present time, and pass the inputs to `heard`."""
        self.state = self.at(self.now.t - self._began)
        self.heard(x)

    def _next(self) -> tuple[State, tuple[int, ...], int]:
        """Return the state, the negative guards and the time [ns] of the next event or of the end of the horizon; time
        0 if no event is possible."""
        before = self._guards(self.state)
        if not before or not any(self.flow(self.state)):
            return self.state, (), 0
        last, end = 0, ceil(self.horizon * 1e9)
        for number, step in enumerate(_steps(self.flow, self.state, self.tolerance, self.longest)):
            if number == STEPS:
                raise ModelError(
                    f"the flow from {self.state} needs more than {STEPS} steps for {step.t0:g} s: it is stiff, or the "
                    f"horizon of {self.horizon:g} s is too long"
                )
            for look in LOOKAHEADS:
                t = min(end, max(last + 1, step.begin + ceil(look * step.h * 1e9)))
                now = self._guards(step.at(t))
                if fallen := self._falls(step, last, before, t, now):
                    return step.at(fallen[0]), fallen[1], fallen[0]
                last, before = t, now
                if t == end:
                    return step.at(t), (), t
        raise AssertionError("steps have no end")

    def _guards(self, x: State) -> Sequence[float]:
        found = tuple(self.guards(x))
        if any(map(isnan, found)):  # it would never fall
            raise ModelError(f"guards() returned {found} at {x}; return numbers")
        return found

    def _falls(
        self, step: "_Step", last: int, before: Sequence[float], t: int, now: Sequence[float]
    ) -> tuple[int, tuple[int, ...]] | None:
        """Return the first time [ns] in (last, t] at which guards are no longer positive, and the indices of these
        guards; None if there is none."""
        if len(now) != len(before):
            raise ModelError(
                f"guards() returned {len(before)} numbers, then {len(now)}; always return the same number of them"
            )
        found = dict[int, int]()
        for i, (a, b) in enumerate(zip(before, now, strict=True)):
            low, high = last, t
            while last == 0 and a <= 0 and b <= 0 and high > 1:  # it begins at zero: has it been above since?
                low, high = high // 2, low if low > high else high
                a = self._guards(step.at(low))[i]
                if a <= 0:
                    low, high = 0, low
            if a > 0 >= b:
                found[i] = self._first(step, i, low, high)
        at = min(found.values(), default=0)
        return (at, tuple(i for i in found if found[i] == at)) if found else None

    def _first(self, step: "_Step", i: int, low: int, high: int) -> int:
        """Return the first time [ns] at which guard i is not positive, given that it is at `low` and not at `high`."""
        while high - low > 1:
            middle = (low + high) // 2
            if self._guards(step.at(middle))[i] > 0:
                low = middle
            else:
                high = middle
        return high


class _Step(NamedTuple):
    """An integration step that starts at t0 [s] and has length h [s], with the coefficients d of its dense output;
    times count from the last transition."""

    t0: float
    h: float
    d: tuple[State, ...]

    @property
    def begin(self) -> int:
        """Start of the integration step [ns], rounded up."""
        return ceil(self.t0 * 1e9)

    @property
    def end(self) -> int:
        """End of the integration step [ns], rounded up."""
        return ceil((self.t0 + self.h) * 1e9)

    def at(self, t: int) -> State:
        """Return the state at a time [ns] within the integration step."""
        u = (t * 1e-9 - self.t0) / self.h
        w = 1.0 - u
        return tuple(a + u * (b + w * (c + u * (d + w * e))) for a, b, c, d, e in zip(*self.d, strict=True))


def _steps(flow: Flow, x: State, tolerance: float, longest: float) -> Iterator[_Step]:
    """Yield accepted integration steps from the state x, endlessly."""
    A, error, dense = DormandPrince5.tableau.A, DormandPrince5.tableau.error, DormandPrince5.dense
    t, f = 0.0, _flowing(flow, x)
    h = min(longest, 0.01 * _norm(x, [1.0] * len(x)) / max(_norm(f, [1.0] * len(x)), 1e-5))
    h = max(h, min(longest, 1e-6))
    while True:
        k = [f]
        for a in A[1:]:
            y = tuple(xi + h * s for xi, s in zip(x, _combined(a, k), strict=True))
            k.append(_flowing(flow, y))
        size = [tolerance * (1.0 + max(abs(a), abs(b))) for a, b in zip(x, y, strict=True)]
        wrong = _norm([h * e for e in _combined(error, k)], size)
        if wrong <= 1.0:
            d1 = tuple(b - a for a, b in zip(x, y, strict=True))
            d2 = tuple(h * s - d for s, d in zip(f, d1, strict=True))
            d3 = tuple(a - h * s - b for a, s, b in zip(d1, k[-1], d2, strict=True))
            yield _Step(t, h, (x, d1, d2, d3, tuple(h * s for s in _combined(dense, k))))
            t, x, f = t + h, y, k[-1]
        factor = 0.9 * power(max(wrong, 1e-10), -0.2) if isfinite(wrong) else 0.1
        h = min(longest, h * min(5.0, max(0.1, factor)))
        if h < ALONE * max(1.0, t):
            raise ModelError(
                f"the flow cannot be integrated from {x} at {t:g} s: it is stiff, jumps or is not finite; model jumps "
                "as events of guards"
            )


def _flowing(flow: Flow, x: State) -> State:
    f = tuple(flow(x))
    if len(f) != len(x):
        raise ModelError(
            f"flow() returned {len(f)} rates for a state of {len(x)} numbers; return one rate for each number"
        )
    return f


def _combined(weights: Sequence[float], k: Sequence[State]) -> Iterator[float]:
    """Yield, for each component, the sum of the stages k times their weights."""
    return (sum(w * s for w, s in zip(weights, column, strict=False)) for column in zip(*k, strict=True))


def _norm(x: Sequence[float], size: Sequence[float]) -> float:
    """Return the root mean square of x / size; infinite if it is not finite."""
    squares = [(a / b) * (a / b) for a, b in zip(x, size, strict=True)]
    return sqrt(fsum(squares) / len(squares)) if all(map(isfinite, squares)) else float("inf")
