"""What crosses the border of a node, and the face that a node process runs.

An event is one message on an out port of a coupled model. Its total order is that of its fields, (t, k, source, port,
index): no clock, process or arrival order enters. A node hears an event once; its couplings tell which in ports it
reaches there. Whatever implements `Steppable` can be a node: the local `Simulator`, which runs one model or several,
and the mechanics kernel.
"""

from collections.abc import Mapping, Sequence
from typing import Annotated, Protocol, runtime_checkable

import msgspec

from .messages import Message, decode
from .tags import Tag, tag_of

Order = tuple[int, int, str, str, int]  # t, k, source, port, index: the total order of events


class Event(msgspec.Struct, frozen=True, order=True, array_like=True, gc=False):
    """One message on an out port: tag, source model, port, index in that bag, class name, bytes."""

    t: Annotated[int, msgspec.Meta(ge=0)]
    k: Annotated[int, msgspec.Meta(ge=0)]
    source: str
    port: str
    index: Annotated[int, msgspec.Meta(ge=0)]
    type: str
    payload: bytes

    @property
    def tag(self) -> Tag:
        """When it is sent and received."""
        return tag_of((self.t, self.k))

    @property
    def order(self) -> Order:
        """Its place in the total order."""
        return self.t, self.k, self.source, self.port, self.index

    @property
    def value(self) -> Message:
        """A new copy of the message."""
        return decode(self.type, self.payload)


class AtomicResult(msgspec.Struct, frozen=True):
    """What an atomic tells when a run is over: its path, class name and bytes of the message."""

    path: str
    type: str
    payload: bytes

    @property
    def value(self) -> Message:
        """A new copy of the message."""
        return decode(self.type, self.payload)


class Slack(msgspec.Struct, frozen=True):
    """How long its outputs were scheduled before they left a port, at least: so long its lookahead could have been."""

    port: str  # path of the atomic's port
    declared_ns: int
    observed_ns: int
    count: int  # outputs


class Steppable(Protocol):
    """What a node runs. `outputs` is pure; `advance` is the only way forward."""

    @property
    def lookahead(self) -> Mapping[str, int]:
        """[ns] of each out port "model.port"; NEVER for one by which nothing can leave, 0 for one that is not named."""

    @property
    def slack(self) -> list[Slack]:
        """Observed lookaheads so far."""

    @property
    def last(self) -> Tag:
        """Tag of the last transition; before the first one (-1, 0)."""

    def results(self, end: Tag) -> Mapping[str, Message]:
        """What its atomics tell of a run that is over at `end`, by path."""

    @property
    def next_time(self) -> Tag:
        """Tag of the next internal transition; FOREVER when passive."""

    @property
    def quiet(self) -> Tag:
        """Earliest tag at which it can speak if nothing reaches it: next_time if the offer is not empty."""

    def start(self) -> None:
        """Set the initial state at (0, 0)."""

    def outputs(self) -> list[Event]:
        """The offer: what lambda of next_time says to other nodes, in total order."""

    def advance(self, tag: Tag, bag: Sequence[Event], until: Tag) -> None:
        """Transit at `tag` <= next_time; may then work ahead below `until` while it is silent."""

    def among(self) -> list[Event]:
        """What its models have said on ports that no other node hears, since this was asked last, in total order."""


@runtime_checkable
class Keepable(Protocol):
    """A `Steppable` whose state can be taken out between two tags, so that another one goes on from it."""

    def snapshot(self) -> bytes:
        """All that the future depends on; HeavyliftError if some of it cannot be kept."""

    def restore(self, snapshot: bytes) -> None:
        """Go on from a snapshot of the same model, after `start`."""
