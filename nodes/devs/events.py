"""Superdense time, and the events that cross the border of a node.

A tag (t, k) is the k-th instant at t whole nanoseconds, so that 0.1 s and 0.3 s meet exactly and the microstep orders
events without letting time pass (Manna and Pnueli; adevs `sd_time`, Lingua Franca). `after` is the only sum: a wait of
zero takes one microstep, a positive wait starts at k = 0. An event is one message on an out port of a coupled model;
its total order is that of its fields, (t, k, source, port, index): no clock, process or arrival order enters. Whatever
implements `Steppable` can be a node: the local `Simulator` of one or several models, and the mechanics kernel.
"""

import warnings
from collections.abc import Mapping, Sequence
from typing import Annotated, NamedTuple, Protocol, runtime_checkable

import msgspec
from msgspec import Meta

from .messages import Message, decode


class Tag(NamedTuple):
    """An instant: time t [ns] and microstep k, ordered by t, then k; non-negative on the wire."""

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
    """Return the tag of an instant, in a third of the time of `Tag(*instant)`."""
    return tuple.__new__(Tag, instant)


def succ(tag: Tag) -> Tag:
    """Return the next microstep at the same time."""
    return tag if tag[0] == NEVER else tuple.__new__(Tag, (tag[0], tag[1] + 1))


def after(tag: Tag, wait: int) -> Tag:
    """Return the tag `wait` [ns] after `tag`; a wait of zero takes one microstep; FOREVER stays."""
    if wait == 0:
        return succ(tag)
    return tuple.__new__(Tag, (tag[0] + wait, 0)) if wait < NEVER - tag[0] else FOREVER


def beyond(wait: int) -> str:
    """Return the error message for a wait [ns] beyond the end of time."""
    long = wait if wait <= NEVER else f"2**{wait.bit_length() - 1} or more"
    return (
        f"hold_in({long}) [ns] ends beyond 2**63 ns, 292 years, as time does; hold for less, or call passivate() to "
        "wait for ever"
    )


def seconds(t: float) -> int:
    """Return a time in seconds as nanoseconds, rounded to the nearest."""
    return round(t * 1e9)


def us(microseconds: float) -> int:
    """Return a time in microseconds as nanoseconds, rounded to the nearest."""
    return round(microseconds * 1e3)


def ms(milliseconds: float) -> int:
    """Return a time in milliseconds as nanoseconds, rounded to the nearest."""
    return round(milliseconds * 1e6)


def ns(t: float) -> int:
    """Deprecated: the former name of `seconds`."""
    warnings.warn(f"ns({t!r}) reads as nanoseconds; write seconds({t!r})", DeprecationWarning, stacklevel=2)
    return seconds(t)


Order = tuple[int, int, str, str, int]  # t, k, source, port, index: the total order of events


class Event(msgspec.Struct, frozen=True, order=True, array_like=True, gc=False):
    """A message on an out port: tag, source model, port, index in its bag, class name, bytes."""

    t: Annotated[int, msgspec.Meta(ge=0)]
    k: Annotated[int, msgspec.Meta(ge=0)]
    source: str
    port: str
    index: Annotated[int, msgspec.Meta(ge=0)]
    type: str
    payload: bytes

    @property
    def tag(self) -> Tag:
        """The tag at which the event is sent and received."""
        return tag_of((self.t, self.k))

    @property
    def order(self) -> Order:
        """The place of the event in the total order."""
        return self.t, self.k, self.source, self.port, self.index

    @property
    def value(self) -> Message:
        """Return a new copy of the message."""
        return decode(self.type, self.payload)


class AtomicResult(msgspec.Struct, frozen=True):
    """Result of an atomic model at the end of a run: path, class name, bytes of the message."""

    path: str
    type: str
    payload: bytes

    @property
    def value(self) -> Message:
        """Return a new copy of the message."""
        return decode(self.type, self.payload)


class Slack(msgspec.Struct, frozen=True):
    """The shortest time by which outputs of a port were scheduled in advance: its largest possible lookahead."""

    port: str  # path of the atomic's port
    declared_ns: int
    observed_ns: int
    count: int  # outputs


class Steppable(Protocol):
    """Interface of a node's model. `outputs` is pure; only `advance` changes the state."""

    @property
    def lookahead(self) -> Mapping[str, int]:
        """Lookahead [ns] by out port "model.port"; NEVER without outputs to other nodes, 0 if not listed."""

    @property
    def slack(self) -> list[Slack]:
        """The lookaheads observed so far."""

    @property
    def last(self) -> Tag:
        """The tag of the last transition; (-1, 0) before the first one."""

    def results(self, end: Tag) -> Mapping[str, Message]:
        """Return the results of the node's atomics at the end of a run, by path."""

    @property
    def next_time(self) -> Tag:
        """The tag of the next internal transition; FOREVER when passive."""

    @property
    def quiet(self) -> Tag:
        """The earliest tag at which the node can send an event if no input arrives: next_time, or later if its output
        is empty."""

    def start(self) -> None:
        """Set the initial state at (0, 0)."""

    def outputs(self) -> list[Event]:
        """Return the outputs at next_time to other nodes, in total order."""

    def advance(self, tag: Tag, bag: Sequence[Event], until: Tag) -> None:
        """Execute the transitions at `tag` <= next_time, and later ones below `until` as long as no event is sent."""

    def among(self) -> list[Event]:
        """Return the events between models of the node, or without receiver, since the last call, in total order."""


@runtime_checkable
class Keepable(Protocol):
    """A `Steppable` whose state can be saved between two tags and restored in another one."""

    def snapshot(self) -> bytes:
        """Return all state on which the future depends; raises HeavyliftError if part of it cannot be saved."""

    def restore(self, snapshot: bytes) -> None:
        """Continue from a snapshot of the same model, after `start`."""
