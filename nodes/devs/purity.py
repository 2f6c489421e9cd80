"""Sees an `output` that changes the state of its model: lambda is a function of the state, called whenever asked for.

Looked at are the first outputs, the first of every class, and then all of one tag in about EVERY, at distances that no
cycle of speakers can meet always or never, the same in every run.  Attributes are compared by identity, and by their
bytes where they can change in place; what has no bytes, such as a generator, by identity alone.  The larger the states,
the more of these looks are left out.
"""

import io
import pickle
from operator import is_
from random import Random
from typing import Any

from heavylift.kernel.errors import ModelError

from .messages import Message
from .models import Atomic, Model
from .ports import Port
from .rules import fail
from .tags import Instant

__all__ = ["Witness", "image"]

FIRST = 256  # outputs that are all looked at, fewer of large states
EVERY = 251  # tags of which one is looked at, on average; at most twice as many pass by
BYTES = 4096  # of state for which one look is left out
_FIXED = (bool, int, float, str, bytes, type(None), Message, Port, Model)
_still: dict[type, bool] = {}  # whether values of a class cannot change in place


State = tuple[Atomic, dict[str, Any], dict[str, bytes]]  # its attributes; the bytes of those that can change in place


class Witness:
    """Compares the states of atomics `before` and `after` a tag, once `left` is negative or if one of them is `new`."""

    def __init__(self) -> None:
        self.left = 0  # tags that are passed by
        self.new: set[int] = set()  # atomics of classes that have not spoken
        self._first, self._met, self._random = FIRST, set[type](), Random(EVERY)

    def meet(self, atomics: list[Atomic]) -> None:
        """Take note of who is there."""
        self._atomics = atomics
        unknown = {cls for cls in {*map(type, atomics)} - self._met if cls.output is not Atomic.output}
        self.new = {m._index for m in atomics if type(m) in unknown} if unknown else set()

    def before(self, imminent: list[int]) -> list[State]:
        """The states of those who are about to speak and are looked at."""
        if self.left >= 0:
            imminent = sorted(self.new.intersection(imminent))
        elif self._first > 0:
            self._first, self.left = self._first - len(imminent), 0
        else:
            self.left = self._random.randrange(2 * EVERY - 1)
        some = [self._atomics[i] for i in imminent]
        if not self.new.isdisjoint(imminent):
            self._met.update(map(type, some))
            self.meet(self._atomics)
        return [(m, vars(m).copy(), _changeable(vars(m))) for m in some]

    def after(self, tag: Instant, seen: list[State]) -> None:
        """ModelError names who has changed which attribute."""
        for m, was, kept in seen:
            now = vars(m)
            if len(now) == len(was) and all(map(is_, now.values(), was.values())):
                changed = set[str]()
            else:
                changed = {key for key in was.keys() | now.keys() if was.get(key, m) is not now.get(key, m)}
                changed = {key for key in changed if image(was.get(key, m)) != image(now.get(key, m))}
            if kept:
                cost = sum(map(len, kept.values())) // BYTES
                if self._first > 0:
                    self._first -= cost
                else:
                    self.left += cost * EVERY
                if (then := _changeable(now)) != kept:
                    changed |= {key for key in kept if kept[key] != then.get(key)}
            if changed:
                told = f"output() must not change the state: it changed {min(changed)}, do that in a transition"
                fail(m, tag, "output", ModelError(told))


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
