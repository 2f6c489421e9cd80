"""Messages between models: frozen structs and their canonical bytes.

A message is a frozen struct whose fields are immutable at every depth (checked when the class is defined), so receivers
in one node can share it, and no receiver can change what another one sees. Between nodes a message travels as bytes,
and every receiver decodes its own copy. The canonical bytes are a MessagePack map in field order. The class name
identifies the type in a recording; two classes with the same name are refused. Receivers always get the message as its
bytes represent it (`ports`), so results do not depend on how a model tree is divided into nodes.
"""

import os
import re
import sys
import types
import typing
from collections.abc import Callable, Mapping
from contextlib import suppress
from enum import Enum, Flag
from importlib import import_module
from typing import Any

import msgspec
from heavylift.kernel.errors import UNREADABLE, ModelError
from msgspec.structs import astuple

_REGISTRY: dict[str, "type[Message]"] = {}
_DECODERS: dict[type, "msgspec.msgpack.Decoder[Message]"] = {}
_ENCODER = msgspec.msgpack.Encoder()
PLAIN = (bool, int, float, str, bytes, type(None))
_SCALARS = frozenset(PLAIN)


@typing.dataclass_transform(frozen_default=True, field_specifiers=(msgspec.field,))
class _MessageType(msgspec.StructMeta):
    """Metaclass of messages: registers classes by name and refuses mutable fields."""

    def __init__(cls, name: str, bases: tuple[type, ...], namespace: dict[str, object], **config: object) -> None:
        super().__init__(name, bases, namespace)
        if not bases or bases == (msgspec.Struct,):
            return
        known = _REGISTRY.get(name)
        if known is not None and _place(known) != _place(cls) and not _left(known):
            raise ModelError(
                f"message {name} is defined in {known.__module__} and again in {cls.__module__}: "
                f"recordings distinguish messages by class name; rename one of them"
            )
        if not cls.__struct_config__.frozen:
            raise ModelError(f"message {name} is not frozen: a receiver could change it; remove frozen=False")
        try:
            hints = hints_of(cls)
        except NameError as error:
            raise ModelError(
                f"message {name}: {error}; define the types of its fields at the top of its module"
            ) from None
        for field, hint in hints.items():
            if not _immutable(hint, cls):
                raise ModelError(
                    f"message {name}, field {field}: {shown(hint)} can be changed by a receiver; "
                    f"use numbers, str, bytes, tuple[...], enums or other messages"
                )
        cls.__plain__ = _plain
        _REGISTRY[name] = typing.cast("type[Message]", cls)


_HALVES = re.compile("[\ud800-\udfff]").search  # of characters, which no text may have


def _place(cls: type) -> tuple[str, str]:
    """Return the file (or module) and the qualified name of a class; a script that is imported again under its own name
    counts as the same place."""
    file: str | None = getattr(sys.modules.get(cls.__module__), "__file__", None)
    return os.path.realpath(file) if file else cls.__module__, cls.__qualname__


def _left(cls: type) -> bool:
    """Return whether a class is left over from an earlier version of its module and is no longer defined there."""
    found: object = sys.modules.get(cls.__module__)
    for part in cls.__qualname__.split("."):
        found = getattr(found, part, None)
    return "<" not in cls.__qualname__ and found is not cls


class Message(msgspec.Struct, frozen=True, metaclass=_MessageType):
    """Base class of all messages that ports carry; a subclass is declared as in `class HoistDone(Message): id: int`."""

    units: typing.ClassVar[Mapping[str, str]] = {}
    """SI units by field name, for displays; "m or rad" if the unit depends on the joint or actuator concerned."""

    def __reduce__(self) -> tuple[object, ...]:
        """Pickle the message as its encoded bytes, so that messages of earlier versions of a module can be
        unpickled."""
        cls = type(self)
        return _unpickled, (cls.__module__, cls.__name__, encode(self))

    def __deepcopy__(self, memo: object) -> typing.Self:
        """Return the message itself: it is immutable."""
        return self

    def __plain__(self) -> bool:
        """Return whether the fields certainly equal what their bytes decode to; False if encoding is needed to know."""
        return True

    def __post_init__(self) -> None:
        """Raise ModelError for mutable containers in the fields, which annotations do not exclude."""
        if self.__plain__():
            return
        for i, x in enumerate(astuple(self)):
            if type(x) not in _SCALARS and _changeable(x):
                raise ModelError(
                    f"message {type(self).__name__}, field {self.__struct_fields__[i]}: the {type(x).__name__} {x!r} "
                    "can be changed by a receiver; use numbers, str, bytes, tuples, enums or other messages"
                )


def _changeable(x: object) -> bool:
    if isinstance(x, tuple):
        return any(map(_changeable, x))
    if isinstance(x, msgspec.Struct):
        return not x.__struct_config__.frozen or any(_changeable(getattr(x, name)) for name in x.__struct_fields__)
    return isinstance(x, set) or hasattr(type(x), "__setitem__")


def hints_of(cls: type) -> dict[str, object]:
    """Return the annotated types of the fields of a message class."""
    hints = typing.get_type_hints(cls, localns={cls.__name__: cls}, include_extras=True)
    return {name: hints[name] for name in cls.__struct_fields__}  # type: ignore[attr-defined]


def _plain(self: Message) -> bool:
    """Replace `__plain__` of the class by a compiled check on first use, and return the result of that check."""
    cls = type(self)
    cls.__plain__ = _compiled({f"m.{name}": hint for name, hint in hints_of(cls).items()})  # type: ignore[assignment, method-assign]
    return self.__plain__()


class _Opaque(Exception):
    """A type whose values must be encoded to check whether they arrive unchanged."""


def _compiled(hints: dict[str, object]) -> Callable[[object], bool]:
    """Compile a check of message fields, since a loop over fields would cost more than the rest of sending."""
    names: dict[str, object] = {"halves": _HALVES}
    try:
        text = " and ".join(_check(x, hint, names) for x, hint in hints.items())
        return typing.cast("Callable[[object], bool]", eval(f"lambda m: {text or True}", names))
    except (_Opaque, SyntaxError):  # or a field called `from`
        return lambda m: False


def _check(x: str, hint: object, names: dict[str, object]) -> str:
    """Return a Python expression that is true if the value x is certain to arrive unchanged; raises _Opaque if no
    expression can decide this."""
    origin, args = typing.get_origin(hint), typing.get_args(hint)
    if origin in (typing.Union, types.UnionType):
        return f"({' or '.join(_check(x, arg, names) for arg in args)})"
    if origin is tuple and args[1:] == (Ellipsis,):
        return f"(type({x}) is tuple and all(map({_named(_compiled({'m': args[0]}), names)}, {x})))"
    if origin is tuple:
        parts = (_check(f"{x}[{i}]", arg, names) for i, arg in enumerate(args))
        return f"({' and '.join([f'type({x}) is tuple and len({x}) == {len(args)}', *parts])})"
    more = _MORE.get(hint) if origin is None else None
    if more is None and origin is None and isinstance(hint, type):
        whole = issubclass(hint, Enum) and not issubclass(hint, Flag) and all(map(_returns, hint))
        more = "and {x}.__plain__()" if issubclass(hint, Message) else "" if whole else None
    if more is None:
        raise _Opaque
    return f"(type({x}) is {_named(hint, names)} {more.format(x=x)})"


_MORE: dict[object, str] = {
    **dict.fromkeys((bool, float, bytes, type(None)), ""),
    int: f"and {-(2**63)} <= {{x}} < {2**64}",
    str: "and ({x}.isascii() or not halves({x}))",  # halves of characters have no bytes
}


def _returns(member: Enum) -> bool:
    try:
        return msgspec.msgpack.decode(encode(member), type=type(member)) is member  # type: ignore[arg-type]
    except (TypeError, ValueError, OverflowError):
        return False


def _named(x: object, names: dict[str, object]) -> str:
    names[name := f"_{len(names)}"] = x
    return name


def _immutable(hint: object, owner: type) -> bool:
    if hint in PLAIN or hint is owner or hint is Ellipsis:
        return True
    origin, args = typing.get_origin(hint), typing.get_args(hint)
    if origin is typing.Annotated:
        return _immutable(args[0], owner)
    if origin is typing.Literal:
        return True
    if origin in (tuple, typing.Union, types.UnionType):
        return all(_immutable(arg, owner) for arg in args)
    if isinstance(hint, type) and issubclass(hint, tuple) and hint is not tuple:
        return all(_immutable(part, owner) for part in typing.get_type_hints(hint).values())
    if isinstance(hint, type) and issubclass(hint, msgspec.Struct):
        parts = typing.get_type_hints(hint)
        return hint.__struct_config__.frozen and (
            issubclass(hint, Message) or all(_immutable(parts[f], owner) for f in hint.__struct_fields__)
        )
    return isinstance(hint, type) and issubclass(hint, Enum)


def shown(hint: object) -> str:
    return hint.__name__ if isinstance(hint, type) and not typing.get_args(hint) else str(hint)


def message_type(name: str) -> type[Message]:
    """Return the message class with the given name; raises ModelError if the name is unknown."""
    try:
        return _REGISTRY[name]
    except KeyError:
        raise ModelError(f"unknown message type {name!r}: import the module that defines it") from None


def encode(value: Message) -> bytes:
    """Return the canonical bytes of a message."""
    return _ENCODER.encode(value)


def decode(name: str, payload: bytes) -> Message:
    """Decode a message of the class `name` from its canonical bytes; all fields are checked."""
    try:
        return typing.cast(Message, decoder(message_type(name)).decode(payload))
    except UNREADABLE as error:
        raise ModelError(f"message {name} cannot be decoded: {error}") from None


def _unpickled(module: str, name: str, payload: bytes) -> Message:
    if name not in _REGISTRY:
        with suppress(ImportError):
            import_module(module)
    return decode(name, payload)


def decoder(cls: type[Message]) -> "msgspec.msgpack.Decoder[Any]":
    """Return the decoder of a message class; raises ModelError if the types of its fields are ambiguous."""
    if cls not in _DECODERS:
        try:
            _DECODERS[cls] = msgspec.msgpack.Decoder(cls)
        except (TypeError, NameError) as error:
            message = " ".join(str(error).split())
            raise ModelError(f"message {cls.__name__} cannot be read from its bytes: {message}") from None
    return _DECODERS[cls]
