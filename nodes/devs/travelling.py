"""A message as each receiver gets it, whether it shares the sender's process or not: what its bytes say.

An annotation alone keeps nothing out of a field. What arrives otherwise than it was sent is refused, with its field:
text in an int, NumPy's scalars, ints of more than 64 bits, halves of characters, a derived message where its base is
declared. An int in a float field arrives as that float.
"""

from math import isnan
from typing import TypeVar

import msgspec
from heavylift.kernel.errors import ModelError
from msgspec.structs import astuple

from .messages import Message, decoder, encode, hints_of, shown

_NOT_SENT = (TypeError, ValueError, OverflowError, RecursionError, msgspec.MsgspecError)
M = TypeVar("M", bound=Message)


def travelling(value: M, port: object) -> M:
    """The message as it arrives; ModelError names the port and the field that would arrive otherwise."""
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
    """Equality to which NaN is NaN."""
    if isinstance(a, float) and isnan(a):
        return isinstance(b, float) and isnan(b)
    if isinstance(a, msgspec.Struct):
        return type(a) is type(b) and all(map(_same, astuple(a), astuple(b)))
    if isinstance(a, tuple):
        return isinstance(b, tuple) and len(a) == len(b) and all(map(_same, a, b))
    return bool(a == b)


def _misfit(value: msgspec.Struct, within: str = "") -> str:
    """What is wrong with the first field that would arrive otherwise."""
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
            told = f"of {x.bit_length()} bits" if big else f"{x!r:.60}"
            cure = "an int has at most 64" if big else f"convert it to {shown(hint)} first"
            return f"field {within}{name}: the {type(x).__name__} {told} does not travel as {shown(hint)}, {cure}"
    return "which does not arrive as it was sent"
