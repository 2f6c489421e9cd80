"""Sees an `output` that changes the state of its model: lambda is a function of the state, called whenever asked for.

Looked at are the first outputs, the first of every class, and then all at the times that SPARSE divides, wherever the
model runs.  Attributes are compared by identity, and by their bytes where they can change in place; what has no bytes,
such as a generator, by identity alone.  The larger the states, the more of these looks are left out.
"""

import io
import pickle
from operator import is_
from typing import Any

from heavylift.kernel.errors import ModelError

from .messages import Message
from .models import Atomic, Model
from .ports import Port
from .rules import fail
from .tags import Instant

__all__ = ["Witness", "image"]

FIRST = 256  # outputs that are all looked at, fewer of large states
SPARSE = 251  # [ns], prime, so that few periods meet it always or never
BYTES = 4096  # of state for which one look is left out
_FIXED = (bool, int, float, str, bytes, type(None), Message, Port, Model)
_still: dict[type, bool] = {}  # whether values of a class cannot change in place


_State = tuple[Atomic, dict[str, Any], dict[str, bytes]]  # its attributes; the bytes of those that can change in place


class Witness:
    """Compares the states of atomics `before` and `after` they speak."""

    def __init__(self, atomics: list[Atomic]) -> None:
        self._atomics, self._first, self._skip = atomics, FIRST, 0
        self._new = {type(m) for m in atomics if type(m).output is not Atomic.output}
        self._seen: list[_State] = []
        self._t = -1  # [ns] of the last look

    def before(self, t: int, imminent: list[int]) -> None:
        """Take note of those who are about to speak at `t` [ns]."""
        self._seen = []
        some = [self._atomics[i] for i in imminent]
        if self._first > 0:
            some = some[: self._first]
            self._first -= len(some)
        elif self._new:
            some = [m for m in some if type(m) in self._new]
        elif self._skip or t == self._t:
            self._skip = max(self._skip - 1, 0)
            return
        self._t, self._skip = t, 0
        self._new.difference_update(map(type, some))
        self._seen = [(m, vars(m).copy(), _changeable(vars(m))) for m in some]

    def after(self, tag: Instant) -> int:
        """ModelError names who has changed which attribute; else what divides the next time [ns] to look at."""
        seen, self._seen = self._seen, []
        for m, was, kept in seen:
            now = vars(m)
            if len(now) == len(was) and all(map(is_, now.values(), was.values())):
                changed = set[str]()
            else:
                changed = {key for key in was.keys() | now.keys() if was.get(key, m) is not now.get(key, m)}
                changed = {key for key in changed if image(was.get(key, m)) != image(now.get(key, m))}
            if kept:
                cost = sum(map(len, kept.values())) // BYTES
                self._first, self._skip = self._first - cost, self._skip + cost
                if (then := _changeable(now)) != kept:
                    changed |= {key for key in kept if kept[key] != then.get(key)}
            if changed:
                told = f"output() must not change the state: it changed {min(changed)}, do that in a transition"
                fail(m, tag, "output", ModelError(told))
        return 1 if self._new or self._first > 0 else SPARSE


def _changeable(state: dict[str, Any]) -> dict[str, bytes]:
    """The bytes of attributes that can change in place."""
    found = {}
    for key, x in state.items():
        kind = type(x)
        if kind not in _still:
            _still[kind] = issubclass(kind, _FIXED)
        if not _still[kind]:
            found[key] = image(x)
    return found


def image(x: object) -> bytes:
    """The bytes of a value in this process, b"" if it has none; models and ports in it are told by identity."""
    file = io.BytesIO()
    try:
        _Pickler(file, 5).dump(x)
    except Exception:  # whatever a class of a user's raises here is no matter of the run
        return b""
    return file.getvalue()


class _Pickler(pickle.Pickler):
    """Models and ports in a state are no part of it."""

    def reducer_override(self, x: object) -> Any:
        return (int, (id(x),)) if isinstance(x, Model | Port) else NotImplemented
