"""Rules that a model can break while it runs, the error messages for them, and the state of a simulator as bytes.

An `output` function must not change the state of its model, since it is called whenever its messages are asked for.
This is checked for the first outputs, for the first output of every class, and then for all outputs at one logical time
in about EVERY. The intervals are pseudo-random, the same in every run, so that no cycle of models can always avoid the
check; they are longer for larger states. Attributes are compared by identity, and by their bytes if they can change in
place.

The bytes hold models with their states, schedule and structure, but neither routes (`canonical`) nor the models that
contain them: a snapshot must be restored in the same place.
"""

import io
import pickle
from collections import Counter
from collections.abc import Iterable, Sequence
from gc import get_referents
from operator import is_
from random import Random
from typing import Any, NoReturn

import msgspec
from heavylift.kernel.description.user_code import raised
from heavylift.kernel.errors import UNREADABLE, HeavyliftError, ModelError, error_text
from heavylift.nodes.devs.events import NEVER, Instant, Tag
from heavylift.nodes.devs.messages import Message
from heavylift.nodes.devs.models import Atomic, Model
from heavylift.nodes.devs.ports import InPort, Port

from . import canonical

LIMIT = 10_000  # microsteps at one time that are taken for a loop, unless a run sets another number
LONGER = ", or allow more microsteps (a scene's key microsteps, heavylift devs --microsteps)"
TAIL = 32  # microsteps before the limit whose models are named as the loop


class MicrostepLimit:
    """Detects zero-time loops: at the limit of microsteps, an error names the models in the loop."""

    def __init__(self, microsteps: int) -> None:
        """Set the limit; raises ModelError unless `microsteps` is an int between 1 and 2**31 - 1."""
        if type(microsteps) is not int or not 0 < microsteps < 2**31:
            raise ModelError(
                f"microsteps={microsteps!r}: the limit of microsteps at one time must be an int from 1 to 2**31 - 1"
            )
        self.microsteps, self.start = microsteps, microsteps - TAIL
        self._seen: set[str] = set()
        self._t = -1

    def watch(self, tag: Instant, paths: Iterable[str]) -> None:
        """Record the atomic models with a transition at this microstep; raises ModelError at the microstep limit."""
        t, k = tag
        if t != self._t:
            self._t, self._seen = t, set()
        self._seen.update(paths)
        if k >= self.microsteps:
            raise ModelError(
                f"{', '.join(sorted(self._seen))} at {Tag(t, k)}: zero-time loop: {self.microsteps} microsteps "
                f"without time passing; let one of these models hold for more than 0 ns{LONGER}"
            )


def fail(m: Atomic, tag: Instant, what: str, error: BaseException) -> NoReturn:
    """Raise a ModelError for an exception in a model's function, but re-raise one that ends the program."""
    ends = not isinstance(error, Exception) and type(error).__module__.startswith("heavylift.")
    if ends or isinstance(error, KeyboardInterrupt):
        raise error
    sentence = error_text(error, 10_000) if isinstance(error, HeavyliftError) else f"{what}() raised {raised(error)}"
    raise ModelError(f"{m.path} at {Tag(*tag)}: {sentence}") from error


FIRST = 256  # outputs that are all looked at, fewer of large states
EVERY = 251  # tags of which one is looked at, on average; at most twice as many pass by
BYTES = 4096  # of state for which one look is left out
_FIXED = (bool, int, float, str, bytes, type, type(None), Message, Port, Model)
_still: dict[type, bool] = {}  # whether values of a class cannot change in place


State = tuple[Atomic, list[object] | None, dict[str, object], dict[str, bytes]]
"""An atomic model; its referenced objects if none can be changed in place, else None; then its attributes by name, and
the bytes of those attributes that can be changed in place."""


class Witness:
    """Checks that output functions leave the states of atomic models unchanged.

    It checks models of classes that are `new` and, when the countdown `left` is negative, all models."""

    def __init__(self, candidates: bool = True) -> None:
        self.looks = candidates
        self.left = 0 if candidates else NEVER  # tags that are passed by
        self.new: set[int] = set()  # atomics of classes that have not spoken
        self._first, self._met, self._random = FIRST, set[type[Atomic]](), Random(EVERY)

    def meet(self, atomics: list[Atomic]) -> None:
        """Register the simulator's atomic models, so that their output functions can be checked."""
        if not self.looks:
            return
        self._atomics = atomics
        classes: set[type[Atomic]] = {*map(type, atomics)}
        unknown = {cls for cls in classes - self._met if cls.output is not Atomic.output}
        self.new = {m._index for m in atomics if type(m) in unknown} if unknown else set()

    def before(self, imminent: list[int]) -> list[State]:
        """Choose the imminent models to check, and return their states before their output functions are called."""
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
        """Raise ModelError for an atomic model whose output function has changed an attribute since `before`."""
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
                message = f"output() must not change the state: it changed {min(changed)}; do that in a transition"
                fail(m, tag, "output", ModelError(message))


def _state(m: Atomic) -> State:
    """Return the attributes of an atomic model, if possible without calling `vars(m)`, after which CPython 3.11 reads
    attributes more slowly."""
    known = get_referents(m)
    if all(_is_still(x) or x is m.ports or x is m._present for x in known):
        return m, known, {}, {}
    return m, None, vars(m).copy(), _changeable(vars(m))


def _named(now: dict[str, object], known: list[object], found: list[object]) -> set[str]:
    """Return the names of the attributes that now refer to a different object."""
    if len(known) > len(found):
        return {"an attribute, which it deleted"}
    if len(known) < len(found):
        was = {*map(id, known)}
        return {key for key, x in now.items() if id(x) not in was} or {"the set of attributes"}
    values = list(now.values())
    shift = next(
        (i for i in range(len(found)) if len(found) - i >= len(values) and all(map(is_, found[i:], values))), 0
    )
    places = [i for i, (x, y) in enumerate(zip(known, found, strict=True)) if x is not y and image(x) != image(y)]
    keys = {i + shift: key for i, key in enumerate(now)}
    more = Counter(map(id, found)) - Counter(map(id, known))  # an attribute in place of another moves those between
    new = [i for i in places if id(found[i]) in more]
    if len(new) > more.total() or (not new and len(places) > len(values)):
        return {"the set of attributes"}
    return {keys.get(i, "the set of attributes") for i in new or places}


def _is_still(x: object) -> bool:
    kind = type(x)
    if kind not in _still:
        _still[kind] = issubclass(kind, _FIXED) or getattr(kind, "__fixed__", False)
    return _still[kind]


def _changeable(state: dict[str, object]) -> dict[str, bytes]:
    """Return, by name, the bytes of those attributes that can be changed in place."""
    return {key: image(x) for key, x in state.items() if not _is_still(x)}


def image(x: object) -> bytes:
    """Serialise a value to compare states within this process, with references to models; b"" if impossible."""
    file = io.BytesIO()
    try:
        _Pickler(file, 5).dump(x)
    except Exception:  # whatever a class of a user's raises here is no matter of the run
        return b""
    return file.getvalue()


class _Pickler(pickle.Pickler):
    """Pickles a state without its models, ports and fixed data."""

    def reducer_override(self, x: object) -> Any:
        fixed = isinstance(x, Model | Port) or getattr(type(x), "__fixed__", False)
        return (int, (id(x),)) if fixed else NotImplemented


Staged = list[tuple[InPort[Message], Message]]  # messages on their way in


def frozen(models: Sequence[Model], last: Instant, staged: Staged) -> bytes:
    """Serialise model trees with the logical time of their last transition and their undelivered inputs."""
    parts = []
    for model in models:
        rest = last, [(port, value) for port, value in staged if port.owner is model]
        try:
            parts.append(canonical.frozen((model, rest), _around(model)))
        except (TypeError, RecursionError) as error:
            raise ModelError(
                f"{model.path}: no snapshot can be taken ({error}); keep only plain data and models' ports in states"
            ) from None
    return msgspec.msgpack.encode(parts)


def thawed(snapshot: bytes, former: Sequence[Model]) -> tuple[list[Model], Instant, Staged]:
    """Return the model trees of a snapshot, the logical time of their last transition, and their undelivered inputs.

    `former`: the model trees that they replace."""
    try:
        parts = msgspec.msgpack.decode(snapshot, type=list[bytes])
        found: list[Any] = [canonical.thawed(part, _around(m)) for part, m in zip(parts, former, strict=True)]
        staged = [put for _, (_, waiting) in found for put in waiting]
        return [model for model, _ in found], found[0][1][0], staged
    except (TypeError, ValueError, LookupError, AttributeError, *UNREADABLE) as error:
        raise ModelError(f"this is not a snapshot of a model that is defined here ({error}); take a new one") from None


def _around(model: Model) -> list[object]:
    return [model._present, model.parent]
