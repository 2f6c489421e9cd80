"""Checks of arguments that users pass in Python: an invalid time, order or name is refused in one sentence."""

from collections.abc import Callable, Iterable, Sequence
from math import isfinite
from numbers import Integral, Real
from typing import TypeVar

from heavylift.kernel.errors import ModelError, SignalError
from heavylift.nodes.devs import NEVER, seconds
from heavylift.nodes.scene.text.units import TIME, Limited

DENSEST = 1e-4  # [s] between samples, as the kernel takes them
NANOSECONDS = 1_000_000  # a whole number from here on [s, 11.6 days] was perhaps meant as that many of them
PERIOD = Limited("period", TIME.units, "0.1 ms", "1000 s")
What = TypeVar("What")
Order = tuple[float, What]  # when [s], and what is to be done


def time_s(name: str, value: object, span: Limited) -> float:
    """Return a time [s] after checking that it lies in a range; raises ModelError."""
    try:
        return span.read(f"{_number(name, value)!r} s")
    except ValueError as error:
        raise ModelError(f"{name}: {error}") from None


def end_ns(until: object) -> int:
    """Return the end time `until` [s] in ns, or NEVER for None; raises ModelError for an invalid time."""
    if until is None:
        return NEVER
    t = _number("until", until)
    if not t >= 0.0:
        raise ModelError(f"until={until!r}: a run ends at 0 s or later; give a number of seconds")
    if isinstance(until, Integral) and t >= NANOSECONDS:
        raise ModelError(
            f"until={until!r} looks like nanoseconds and would be {t / 86400.0:.6g} days: `until` is in seconds; write "
            f"{t * 1e-9!r} for so many nanoseconds, {t!r} for so many seconds"
        )
    return min(seconds(t), NEVER) if t < NEVER / 1e9 else NEVER


def timed(orders: object, what: str, fits: Callable[[object], bool]) -> list[Order[What]]:
    """Return timed orders, pairs of a time [s] and a value, checked and sorted by time; raises ModelError.

    `fits` decides whether a value is valid.
    """
    if not isinstance(orders, Iterable) or isinstance(orders, str | bytes):
        raise ModelError(f"orders={orders!r}: give a list of pairs (seconds, {what})")
    found: list[Order[What]] = []
    for order in orders:
        if not (isinstance(order, Sequence) and len(order) == 2 and fits(order[1])):
            raise ModelError(f"orders: {order!r} is not a pair (seconds, {what})")
        t = _number("orders", order[0])
        if not (isfinite(t) and t >= 0.0):
            raise ModelError(f"orders: {t:g} s is outside the possible times of a run")
        found.append((t, order[1]))
    return sorted(found, key=lambda order: order[0])


def patterns(keep: object) -> tuple[str, ...]:
    """Return one or several names or patterns of signals as a tuple; raises SignalError for anything else."""
    text = texts(keep)
    if text is None:
        raise SignalError(f"keep={keep!r}: give names of signals, such as ['rope/tension', 'pose/*']")
    return text


def texts(text: object) -> tuple[str, ...] | None:
    """Return one or several texts as a tuple; None if the value is anything else."""
    if isinstance(text, str):
        return (text,)
    several = tuple(text) if isinstance(text, Iterable) else (None,)
    return tuple(x for x in several if isinstance(x, str)) if all(isinstance(x, str) for x in several) else None


def whole(name: str, value: object) -> int:
    """Return a value after checking that it is a non-negative integer; raises ModelError."""
    if isinstance(value, bool) or not isinstance(value, Integral) or value < 0:
        raise ModelError(f"{name}: {value!r} is not a non-negative integer")
    return int(value)


def _number(name: str, value: object) -> float:
    if isinstance(value, bool) or not isinstance(value, Real):
        raise ModelError(f"{name}: {value!r} is not a number; give a number of seconds")
    return float(value)
