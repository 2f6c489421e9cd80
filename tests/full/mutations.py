"""Ways to spoil bytes, texts and plain data, drawn from one random generator."""

from __future__ import annotations

from collections.abc import Callable
from random import Random
from typing import Any

import msgspec

NUMBERS = (0, 1, -1, -5, 7, 2**31, 2**63 - 1, -(2**63), 2**64 - 1, 0.0, -1.5, 1e-300, 1e300)
WORDS = ("", "x", "\0", "é" * 40, "../..", "os:system", "mine.py:push", "lift", "kernel", "9" * 5000, "a" * 70_000)
VALUES = (*NUMBERS, *WORDS, None, True, b"\xff\xfe", [], {}, [[[[]]]], {"x": 1})
TOKENS = (
    b"[",
    b"{",
    b"}",
    b"]",
    b":",
    b"- ",
    b"\n",
    b"\t",
    b"1e9",
    b"|\n",
    b"<<: ",
    b"\xc3",
    b" &a ",
    b" *a ",
    b"!!int ",
    b"9" * 5000,
    "\u00b2".encode(),
)
Folded = tuple[Callable[[bytes], Any], Callable[[Any], bytes]]

MSGPACK: Folded = (msgspec.msgpack.decode, msgspec.msgpack.encode)
JSON: Folded = (msgspec.json.decode, msgspec.json.encode)


def bytes_of(data: bytes, rng: Random) -> bytes:
    """The same with a few bytes changed, cut, doubled or put elsewhere."""
    for _ in range(rng.choice((1, 1, 2, 5, 20))):
        i, j = sorted(rng.randrange(len(data) + 1) for _ in range(2))
        part = data[i : min(j, i + 200)]
        distance = rng.randrange(7)
        if distance == 0:
            data = data[:i] + rng.randbytes(1) + data[i + 1 :]
        elif distance == 1:
            data = data[:i] + data[i + len(part) :]
        elif distance == 2:
            data = data[:i] + part * rng.choice((2, 3, 50)) + data[i + len(part) :]
        elif distance == 3:
            data = data[:i] + rng.choice(TOKENS) * rng.choice((1, 1, 1, 300)) + data[i:]
        elif distance == 4:
            data = data[:j] + part + data[j:]
        elif distance == 5:
            data = data[:i] + rng.choice((0, 1, 2**31 - 1, 2**63 - 1, 2**64 - 1)).to_bytes(8, "little") + data[i + 8 :]
        elif rng.random() < 0.2:
            data = data[:i]
    return data


def folded(data: bytes, how: Folded, rng: Random) -> bytes:
    """The same with a few of the values that are encoded in it replaced, left out or doubled."""
    decode, encode = how
    try:
        value = decode(data)
        for _ in range(rng.choice((1, 1, 2, 4))):
            value = _changed(value, rng)
        return encode(value)
    except (msgspec.MsgspecError, UnicodeError, RecursionError, OverflowError, TypeError, ValueError):
        return bytes_of(data, rng)


def spoiled(data: bytes, how: Folded, rng: Random) -> bytes:
    """One or the other."""
    return folded(data, how, rng) if rng.random() < 0.6 else bytes_of(data, rng)


def _changed(value: Any, rng: Random) -> Any:
    if isinstance(value, list | tuple) and value and rng.random() < 0.9:
        items, i = list(value), rng.randrange(len(value))
        if rng.random() < 0.1:
            return items[:i] + items[i + 1 :] * rng.choice((1, 2))
        items[i] = _changed(items[i], rng)
        return items
    if isinstance(value, dict) and value and rng.random() < 0.9:
        key = rng.choice(list(value))
        if rng.random() < 0.1:
            return {k: v for k, v in value.items() if k != key}
        return {**value, key: _changed(value[key], rng)}
    if isinstance(value, int | float) and rng.random() < 0.4:
        return value * rng.choice((-1, 2, 1000, 10**6)) if rng.random() < 0.7 else value + rng.choice((-1, 1))
    return rng.choice(VALUES)
