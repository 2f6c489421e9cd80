"""Superdense time: integer nanoseconds and microsteps.

A tag (t, k) is the k-th instant at time t. Integers make 0.1 s and 0.3 s meet exactly; the microstep
orders what happens at one time without letting time pass. Source: Manna and Pnueli's superdense time, as
in adevs `sd_time` and Lingua Franca's tags. `after` is the only sum: a wait of zero costs one microstep, a
positive wait starts at k = 0.
"""

import warnings
from typing import Annotated, NamedTuple

from msgspec import Meta


class Tag(NamedTuple):
    """One instant: t [ns] and the microstep k, none negative on the wire; ordered first by t, then by k."""

    t: Annotated[int, Meta(ge=0)]
    k: Annotated[int, Meta(ge=0)] = 0

    def __str__(self) -> str:
        """Show as `(1.5 s, 2)`, exact to the nanosecond."""
        if self.t == NEVER:
            return "(forever)"
        sign, (whole, part) = "-" * (self.t < 0), divmod(abs(self.t), 10**9)
        return f"({sign}{whole}{f'.{part:09d}'.rstrip('0') if part else ''} s, {self.k})"


Instant = tuple[int, int]  # a tag in the simulator's inner loop, where a plain tuple is made in a tenth of the time
NEVER = 2**63 - 1  # [ns] the time advance of a passive model
BEGIN = Tag(0)
FOREVER = Tag(NEVER, 0)


def tag_of(instant: Instant) -> Tag:
    """The tag of an instant, in a third of the time that `Tag(*instant)` takes."""
    return tuple.__new__(Tag, instant)


def succ(tag: Tag) -> Tag:
    """The next microstep at the same time."""
    return tag if tag[0] == NEVER else tuple.__new__(Tag, (tag[0], tag[1] + 1))


def after(tag: Tag, wait: int) -> Tag:
    """The tag that lies `wait` [ns] after `tag`; zero costs one microstep; forever stays."""
    if wait == 0:
        return succ(tag)
    return tuple.__new__(Tag, (tag[0] + wait, 0)) if wait < NEVER - tag[0] else FOREVER


def beyond(wait: int) -> str:
    """What is said of a wait [ns] that ends after all time."""
    long = wait if wait <= NEVER else f"2**{wait.bit_length() - 1} or more"
    return (
        f"hold_in({long}) [ns] ends beyond 2**63 ns, 292 years, as time does; hold for less, or call passivate() to "
        "wait for ever"
    )


def seconds(t: float) -> int:
    """Nanoseconds of a time in seconds, rounded to the nearest."""
    return round(t * 1e9)


def us(microseconds: float) -> int:
    """Nanoseconds of a time in microseconds, rounded to the nearest."""
    return round(microseconds * 1e3)


def ms(milliseconds: float) -> int:
    """Nanoseconds of a time in milliseconds, rounded to the nearest."""
    return round(milliseconds * 1e6)


def ns(t: float) -> int:
    """The former name of `seconds`."""
    warnings.warn(f"ns({t!r}) reads as nanoseconds; write seconds({t!r})", DeprecationWarning, stacklevel=2)
    return seconds(t)
