"""Typed ports: declared on the class, bound to each model.

`command = In(HoistCommand)` and `done = Out(HoistDone, lookahead=ms(10))` declare X and Y of the DEVS. On an instance
the same name is the bound port, which is the key into the bag of inputs or the port that sends. Lookahead L [ns] is a
promise: after a transition at t, the port sends no output before t + L that was not already scheduled. The promise is
checked; it does not delay outputs.

Every receiver gets a message as its bytes represent it, whether or not it shares the sender's process. Annotations
alone do not restrict a field, so a message that would arrive changed is refused with an error that names the field:
text in an int field, NumPy scalars, ints of more than 64 bits, lone surrogates, an instance of a derived class where
its base is declared. An int in a float field arrives as that float.
"""

from collections.abc import ItemsView, Iterator, Mapping, ValuesView
from functools import cache
from math import isnan
from typing import Any, Generic, Never, Protocol, Self, TypeVar, overload

import msgspec
from heavylift.kernel.errors import ModelError
from msgspec.structs import astuple

from .messages import Message, decoder, encode, hints_of, shown

_NOT_SENT = (TypeError, ValueError, OverflowError, RecursionError, msgspec.MsgspecError)
M = TypeVar("M", bound=Message)


def travelling(value: M, port: object) -> M:
    """Return a message in the form in which its receiver gets it: encoded and decoded again.

    Raises ModelError, which names the port and the field, if encoding and decoding would change the message."""
    cls = type(value)
    read = decoder(cls)
    if value.__plain__():
        return value
    try:
        arrived: M | None = read.decode(encode(value))
    except _NOT_SENT:
        arrived = None
    if arrived is None or not _same(arrived, value):
        raise ModelError(f"{port}: message {cls.__name__}, {_misfit(value)}")
    return arrived


def _same(a: object, b: object) -> bool:
    """Return whether values are equal, with NaN equal to NaN."""
    if isinstance(a, float) and isnan(a):
        return isinstance(b, float) and isnan(b)
    if isinstance(a, msgspec.Struct):
        return type(a) is type(b) and all(map(_same, astuple(a), astuple(b)))
    if isinstance(a, tuple):
        return isinstance(b, tuple) and len(a) == len(b) and all(map(_same, a, b))
    return bool(a == b)


def _misfit(value: msgspec.Struct, within: str = "") -> str:
    """Describe the first field of a message that would arrive changed."""
    for name, hint in hints_of(type(value)).items():
        x = getattr(value, name)
        try:
            fits = _same(msgspec.msgpack.decode(msgspec.msgpack.encode(x), type=hint), x)
        except _NOT_SENT:
            fits = False
        if not fits and isinstance(x, msgspec.Struct) and type(x) is hint:
            return _misfit(x, f"{within}{name}.")
        if not fits:
            big = isinstance(x, int) and not -(2**63) <= x < 2**64
            message = f"of {x.bit_length()} bits" if big else f"{x!r:.60}"
            cure = "an int has at most 64" if big else f"convert it to {shown(hint)} first"
            where = f"field {within}{name}: the {type(x).__name__} {message}"
            return f"{where} does not arrive unchanged as {shown(hint)}; {cure}"
    return "which does not arrive as it was sent"


Carried = TypeVar("Carried", bound=Message, covariant=True)
Sent = TypeVar("Sent", bound=Message, contravariant=True)
D = TypeVar("D")
Bound = TypeVar("Bound")


class Said(Protocol):
    """Interface that ports need from `models.Present`: messages sent at the present logical time, and their ports."""

    sources: "list[Port[Message]]"
    values: list[Message]

    @property
    def speaker(self) -> object: ...


class Owner(Protocol):
    """Interface that ports need from `models.Model`: the name, path, parent and ports of the model that owns a port."""

    name: str

    @property
    def _present(self) -> Said: ...
    @property
    def path(self) -> str: ...
    @property
    def parent(self) -> object: ...
    @property
    def ports(self) -> "Mapping[str, Port[Message]]": ...


class _Nothing:
    """Marker for a port that has sent nothing; a class, because ports must not share an object."""


class Port(Generic[Carried]):
    """A named input or output of a model for messages of one type."""

    __slots__ = ("name", "owner", "routes", "type")

    def __init__(self, owner: "Owner", name: str, type: type[Carried]) -> None:
        self.owner, self.name, self.type = owner, name, type
        self.routes: tuple[tuple[Any, InPort[Message], int], ...] = ()  # the simulator's ways to atomics

    def __repr__(self) -> str:
        return f"{self.owner.path}.{self.name}"

    def __reduce__(self) -> tuple[object, ...]:
        """Pickle the port without the simulator's routes, which would pull in the whole model."""
        return object.__new__, (type(self),), self.__getstate__()

    def __getstate__(self) -> tuple[object, ...]:
        return self.owner, self.name, self.type

    def __setstate__(self, state: tuple[object, ...]) -> None:
        self.__init__(*state)  # type: ignore[misc]


class InPort(Port[Carried]):
    """An input port of a model instance; also the key to its messages in the bag of inputs."""

    __slots__ = ()


class OutPort(Port[Message], Generic[Sent]):
    """An output port of a model instance. `exits`: routes to other nodes, `inner`: routes within the node."""

    __slots__ = ("_sent", "exits", "inner", "lookahead")

    def __init__(self, owner: "Owner", name: str, type: type[Sent], lookahead: int) -> None:
        super().__init__(owner, name, type)
        self.lookahead = lookahead
        self.exits: tuple[tuple[OutPort[Never], int], ...] = ()
        self.inner: tuple[tuple[OutPort[Never], int], ...] = ()
        self._sent: object = _Nothing

    def __getstate__(self) -> tuple[object, ...]:
        return self.owner, self.name, self.type, self.lookahead

    def send(self, value: Sent) -> None:
        """Send a message to all receivers at the present logical time; allowed only in `output()`."""
        owner = self.owner
        present = owner._present
        if present.speaker is not owner:
            if present.speaker is None:
                raise ModelError(f"port {self.name} was used outside output(); only output() may send")
            raise ModelError(f"{self!r} was used by another model; output() may send only on ports of its own model")
        if value is not self._sent:  # what is sent over and over is looked at once
            if type(value) is not self.type or not value.__plain__():
                if not isinstance(value, self.type):
                    message = f"port {self.name} carries {self.type.__name__}, not {type(value).__name__}: {value!r}"
                    raise ModelError(message)
                value = travelling(value, f"port {self.name}")
            self._sent = value
        present.sources.append(self)
        present.values.append(value)


class _Declared(Generic[Bound]):
    @overload
    def __get__(self, model: None, owner: type) -> Self: ...
    @overload
    def __get__(self, model: "Owner", owner: type) -> Bound: ...
    def __get__(self, model: "Owner | None", owner: type) -> Self | Bound:
        """Return the declaration itself on a class, and the bound port on a model instance."""
        if model is not None:
            raise ModelError(f"{owner.__name__}: call super().__init__(name) before using ports")
        return self


class In(_Declared[InPort[M]], Generic[M]):
    """Declaration of an input port as a class attribute."""

    def __init__(self, type: type[M]) -> None:
        self.type = checked_type(type)


class Out(_Declared[OutPort[M]], Generic[M]):
    """Declaration of an output port as a class attribute, with its lookahead [ns]."""

    def __init__(self, type: type[M], lookahead: int = 0) -> None:
        self.type = checked_type(type)
        self.lookahead = lookahead


@cache
def checked_type(type: type[M]) -> type[M]:
    """Return the message type of a port; raises ModelError if ports cannot carry messages of this type."""
    if not issubclass(type, Message):
        raise ModelError(f"a port cannot carry {type!r}: derive it from Message")
    decoder(type)
    return type


class Bag(Protocol):
    """The inputs at one logical time: x[port] is the list of messages at an input port, in order; may be empty."""

    def __getitem__(self, port: InPort[M], /) -> list[M]: ...
    def __contains__(self, port: object, /) -> bool: ...
    @overload
    def get(self, port: InPort[M], /) -> list[M] | None: ...
    @overload
    def get(self, port: InPort[M], default: D, /) -> "list[M] | D": ...
    def __iter__(self) -> Iterator[InPort[Message]]: ...
    def __len__(self) -> int: ...
    def items(self) -> ItemsView[InPort[Message], list[Message]]: ...
    def values(self) -> ValuesView[list[Message]]: ...


class Arrived(dict[InPort[Message], list[Message]]):
    """The bag of inputs that a simulator passes to a model: a dict from input port to list of messages."""

    __slots__ = ()

    def __missing__(self, port: object) -> list[Message]:
        owner = next((known.owner for known in self), None)
        if isinstance(port, InPort) and owner in (None, port.owner):
            return []
        ports = ", ".join(f"self.{name}" for name, x in (owner.ports if owner else {}).items() if isinstance(x, InPort))
        raise ModelError(f"x[{port!r:.60}]: this is not an input port of the model, which has {ports}")
