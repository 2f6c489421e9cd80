"""Superdense (logical) time, and the events that pass between nodes.

A tag (t, k) is a logical time: the k-th instant at t whole nanoseconds. Times in whole nanoseconds make 0.1 s and 0.3 s
exact, and the microstep k orders events without letting time pass (Manna and Pnueli; adevs `sd_time`, Lingua Franca).
Tags are added only by `after`: a wait of zero leads to the next microstep, a positive wait to microstep 0 of a later
time. An event is one message on an output port of a root model. Events are totally ordered by their fields (t, k,
source, port, index), never by a clock, a process or the order of arrival. Everything that implements `Steppable` can be
a node: the local `Simulator` of one or several models, and the mechanics kernel.
"""

import warnings
from collections.abc import Mapping, Sequence
from typing import Annotated, NamedTuple, Protocol, Self, cast, runtime_checkable

import msgspec
from msgspec import Meta

from .messages import Message, decode, encode


class Tag(NamedTuple):
    """A logical time: time t [ns] and microstep k, ordered by t, then k. In a message neither may be negative."""

    t: Annotated[int, Meta(ge=0)]
    k: Annotated[int, Meta(ge=0)] = 0

    def __str__(self) -> str:
        """Return the tag as text such as `(1.5 s, 2)`, exact to the nanosecond."""
        if self.t == NEVER:
            return "(forever)"
        sign, (whole, part) = "-" * (self.t < 0), divmod(abs(self.t), 10**9)
        return f"({sign}{whole}{f'.{part:09d}'.rstrip('0') if part else ''} s, {self.k})"


Instant = tuple[int, int]  # a tag in the simulator's inner loop, where a plain tuple is made in a tenth of the time
NEVER = 2**63 - 1  # [ns] the time advance of a passive model
BEGIN = Tag(0)
FOREVER = Tag(NEVER, 0)


def tag_of(instant: Instant) -> Tag:
    """Return the `Tag` of a pair (t, k), faster than a call of `Tag`."""
    return tuple.__new__(Tag, instant)


def succ(tag: Tag) -> Tag:
    """Return the tag of the next microstep at the same time."""
    return tag if tag[0] == NEVER else tuple.__new__(Tag, (tag[0], tag[1] + 1))


def after(tag: Tag, wait: int) -> Tag:
    """Return the tag `wait` [ns] after `tag`; if `wait` is 0, the next microstep; if `tag` is FOREVER, FOREVER."""
    if wait == 0:
        return succ(tag)
    return tuple.__new__(Tag, (tag[0] + wait, 0)) if wait < NEVER - tag[0] else FOREVER


def beyond(wait: int) -> str:
    """Return the error message for a wait [ns] that ends after the largest representable time."""
    long = wait if wait <= NEVER else f"2**{wait.bit_length() - 1} or more"
    return (
        f"hold_in({long}) [ns] ends after the largest time, 2**63 ns or 292 years; hold for less, or call "
        "passivate() to wait for ever"
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
    warnings.warn(
        f"ns({t!r}) looks like nanoseconds but takes seconds; write seconds({t!r})", DeprecationWarning, stacklevel=2
    )
    return seconds(t)


Order = tuple[int, int, str, str, int]  # t, k, source, port, index: the total order of events


class Passed:
    """The message of an event within this process, which is encoded only when its bytes are needed."""

    __slots__ = ("_bytes", "value")

    def __init__(self, value: Message) -> None:
        self.value, self._bytes = value, b""

    @property
    def payload(self) -> bytes:
        """The canonical bytes of the message."""
        if not self._bytes:
            self._bytes = encode(self.value)
        return self._bytes

    def __eq__(self, other: object) -> bool:
        return self.payload == in_bytes(other)

    def __lt__(self, other: object) -> bool:
        return self.payload < in_bytes(other)

    def __gt__(self, other: object) -> bool:
        return self.payload > in_bytes(other)

    def __hash__(self) -> int:
        return hash(self.payload)


def in_bytes(content: object) -> bytes:
    """Return the content of an event as bytes; used as `enc_hook` by all encoders of events."""
    if isinstance(content, Passed):
        return content.payload
    if isinstance(content, bytes):
        return content
    raise NotImplementedError(f"an event cannot carry {type(content).__name__}; send a Message")


class Event(msgspec.Struct, frozen=True, order=True, array_like=True, gc=False):
    """A message as sent through an output port, with its logical time.

    `port` belongs to the model `source`; `index`: place of the message among those sent there at that time; `type` and
    `payload`: class name and encoded bytes of the message or, within a process, a `Passed`."""

    t: Annotated[int, msgspec.Meta(ge=0)]
    k: Annotated[int, msgspec.Meta(ge=0)]
    source: str
    port: str
    index: Annotated[int, msgspec.Meta(ge=0)]
    type: str
    content: bytes

    @classmethod
    def of(cls, t: int, k: int, source: str, port: str, index: int, value: Message) -> Self:
        """Return an event with a message that encoding and decoding would not change (see `ports.travelling`)."""
        # declared as bytes, which is what a decoder makes; the encoders' hook turns this into bytes
        return cls(t, k, source, port, index, type(value).__name__, cast(bytes, Passed(value)))

    @property
    def tag(self) -> Tag:
        """The logical time (time and microstep) at which the event is sent and received."""
        return tag_of((self.t, self.k))

    @property
    def order(self) -> Order:
        """The sort key of the event in the total order of events."""
        return self.t, self.k, self.source, self.port, self.index

    @property
    def payload(self) -> bytes:
        """The canonical bytes of the event's message."""
        return in_bytes(self.content)

    @property
    def value(self) -> Message:
        """The event's message, which is immutable; a message from another process is decoded anew."""
        content: object = self.content
        return content.value if isinstance(content, Passed) else decode(self.type, self.content)


class AtomicResult(msgspec.Struct, frozen=True):
    """Result of an atomic model at the end of a run: path of the model, class name and bytes of the result message."""

    path: str
    type: str
    payload: bytes

    @property
    def value(self) -> Message:
        """Return a new copy of the result message."""
        return decode(self.type, self.payload)


class Slack(msgspec.Struct, frozen=True):
    """The declared lookahead of an output port, and the shortest observed time [ns] from scheduling to sending."""

    port: str  # path of the atomic's port
    declared_ns: int
    observed_ns: int
    count: int  # outputs


class Steppable(Protocol):
    """Interface of the model that a node simulates; its state changes only in `start` and `advance`."""

    @property
    def lookahead(self) -> Mapping[str, int]:
        """Lookahead [ns] of the node's output ports, by "model.port".

        NEVER for a port that sends nothing to other nodes; a port that is not listed has 0."""

    @property
    def slack(self) -> list[Slack]:
        """The lookahead of each output port, as observed so far in the run."""

    @property
    def last(self) -> Tag:
        """The logical time of the last transition; (-1, 0) before the first one."""

    def results(self, end: Tag) -> Mapping[str, Message]:
        """Return the results of the node's atomic models at the end of a run, by the paths of the models."""

    @property
    def next_time(self) -> Tag:
        """The logical time of the next internal transition; FOREVER if none is scheduled."""

    @property
    def quiet(self) -> Tag:
        """The earliest logical time at which the node can send an event if no input arrives.

        This is next_time, or later if the outputs at next_time are known to be empty."""

    def start(self) -> None:
        """Set the initial state of the node at logical time (0, 0)."""

    def outputs(self) -> list[Event]:
        """Return the events that the node sends to other nodes at next_time, in their total order."""

    def advance(self, tag: Tag, bag: Sequence[Event], until: Tag) -> None:
        """Execute the node's transitions at `tag` (at most next_time) with the input events `bag`.

        Transitions before `until` are executed too, as long as no event is sent to another node."""

    def among(self) -> list[Event]:
        """Return the events sent within the node since the last call, which no other node receives, in total order."""


@runtime_checkable
class Keepable(Protocol):
    """A `Steppable` whose state can be saved after a transition and restored in another copy of the model."""

    def snapshot(self) -> bytes:
        """Return the complete state of the node as bytes; raises HeavyliftError if some part cannot be saved."""

    def restore(self, snapshot: bytes) -> None:
        """Restore the state of the node from a snapshot of the same model; `start` must have been called before."""
