"""Sees an `output` that changes the state of its model: lambda is a function of the state, called whenever asked for.

Looked at are the first outputs, the first of every class, and then all of one tag in about EVERY, at distances that no
cycle of speakers can meet always or never, the same in every run.  Attributes are compared by identity, and by their
bytes where they can change in place; what has no bytes, such as a generator, by identity alone.  The larger the states,
the more of these looks are left out.
"""

import io
import pickle
from collections import Counter
from collections.abc import Iterable
from gc import get_referents
from operator import is_
from random import Random
from typing import Any

from heavylift.kernel.errors import ModelError
from heavylift.nodes.devs.events import NEVER, Instant
from heavylift.nodes.devs.messages import Message
from heavylift.nodes.devs.models import Atomic, Model
from heavylift.nodes.devs.ports import Port

from .rules import fail

FIRST = 256  # outputs that are all looked at, fewer of large states
EVERY = 251  # tags of which one is looked at, on average; at most twice as many pass by
BYTES = 4096  # of state for which one look is left out
_FIXED = (bool, int, float, str, bytes, type, type(None), Message, Port, Model)
_still: dict[type, bool] = {}  # whether values of a class cannot change in place


State = tuple[Atomic, list[object] | None, dict[str, object], dict[str, bytes]]
"""What a model refers to if nothing of it can change in place; else its attributes, and the bytes of those that can."""


class Witness:
    """Compares the states of atomics `before` and `after` output functions, once `left` is negative or for `new`
    atomics."""

    def __init__(self, candidates: bool = True) -> None:
        self.looks = candidates
        self.left = 0 if candidates else NEVER  # tags that are passed by
        self.new: set[int] = set()  # atomics of classes that have not spoken
        self._first, self._met, self._random = FIRST, set[type[Atomic]](), Random(EVERY)

    def meet(self, atomics: list[Atomic]) -> None:
        """Register the present atomics."""
        if not self.looks:
            return
        self._atomics = atomics
        classes: set[type[Atomic]] = {*map(type, atomics)}
        unknown = {cls for cls in classes - self._met if cls.output is not Atomic.output}
        self.new = {m._index for m in atomics if type(m) in unknown} if unknown else set()

    def before(self, imminent: list[int]) -> list[State]:
        """States of imminent atomics that are compared."""
        atomics, unmet = self._atomics, self.new.intersection(imminent)
        examined: Iterable[int] = {type(atomics[i]): i for i in sorted(unmet)}.values()  # one of each new class
        if self.left < 0 and self._first > 0:
            examined = {*examined, *imminent[: self._first]}
            self._first, self.left = self._first - len(examined), 0
        elif self.left < 0:
            examined, self.left = imminent, self._random.randrange(2 * EVERY - 1)
        some = [atomics[i] for i in sorted(examined)]
        if unmet:
            self._met.update(map(type, some))
            self.meet(atomics)
        return [_state(m) for m in some]

    def after(self, tag: Instant, seen: list[State]) -> None:
        """Raise ModelError for an atomic whose output function changed an attribute."""
        for m, known, was, kept in seen:
            changed = set[str]()
            if known is not None:
                found = get_referents(m)
                if len(found) == len(known) and all(map(is_, found, known)):
                    continue
                changed = _named(vars(m), known, found)
            now = vars(m)
            if known is None and not (len(now) == len(was) and all(map(is_, now.values(), was.values()))):
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
                message = f"output() must not change the state: it changed {min(changed)}, do that in a transition"
                fail(m, tag, "output", ModelError(message))


def _state(m: Atomic) -> State:
    """Attributes of an atomic, without `vars(m)` where possible: CPython 3.11 reads attributes more slowly after it."""
    known = get_referents(m)
    if all(_is_still(x) or x is m.ports or x is m._present for x in known):
        return m, known, {}, {}
    return m, None, vars(m).copy(), _changeable(vars(m))


def _named(now: dict[str, object], known: list[object], found: list[object]) -> set[str]:
    """Attributes that refer to a different object with a different value."""
    if len(known) > len(found):
        return {"an attribute, which it deleted"}
    if len(known) < len(found):
        was = {*map(id, known)}
        return {key for key, x in now.items() if id(x) not in was} or {"what attributes there are"}
    values = list(now.values())
    shift = next(
        (i for i in range(len(found)) if len(found) - i >= len(values) and all(map(is_, found[i:], values))), 0
    )
    places = [i for i, (x, y) in enumerate(zip(known, found, strict=True)) if x is not y and image(x) != image(y)]
    keys = {i + shift: key for i, key in enumerate(now)}
    more = Counter(map(id, found)) - Counter(map(id, known))  # an attribute in place of another moves those between
    new = [i for i in places if id(found[i]) in more]
    if len(new) > more.total() or (not new and len(places) > len(values)):
        return {"what attributes there are"}
    return {keys.get(i, "what attributes there are") for i in new or places}


def _is_still(x: object) -> bool:
    kind = type(x)
    if kind not in _still:
        _still[kind] = issubclass(kind, _FIXED)
    return _still[kind]


def _changeable(state: dict[str, object]) -> dict[str, bytes]:
    """The bytes of attributes that can change in place."""
    return {key: image(x) for key, x in state.items() if not _is_still(x)}


def image(x: object) -> bytes:
    """Serialise a value within this process, b"" if that fails; models and ports are identified, not copied."""
    file = io.BytesIO()
    try:
        _Pickler(file, 5).dump(x)
    except Exception:  # whatever a class of a user's raises here is no matter of the run
        return b""
    return file.getvalue()


class _Pickler(pickle.Pickler):
    """Pickles a state without models and ports."""

    def reducer_override(self, x: object) -> Any:
        return (int, (id(x),)) if isinstance(x, Model | Port) else NotImplemented
