"""Lambda: what the atomics that are due say at a tag, in path order, each once, and changing nothing by it; and
what they tell of a run when it is over, each by `result()`.
"""

from collections.abc import Iterable, Sequence

from heavylift.kernel.errors import ModelError
from heavylift.nodes.devs.messages import Message
from heavylift.nodes.devs.models import Atomic, Present
from heavylift.nodes.devs.tags import Instant, Tag
from heavylift.nodes.devs.travelling import travelling

from .lookahead import keep_promises
from .purity import Witness
from .rules import fail


def speak(
    tag: Instant, imminent: list[int], atomics: Sequence[Atomic], present: Present, witness: Witness, promises: bool
) -> None:
    """Leave in `present` what they say; ModelError names who changes its state, or breaks a lookahead, if there is one
    to keep."""
    present.now, present.sources, present.values = tag, [], []
    witness.left -= 1
    looked_at = witness.left < 0 or (witness.new and not witness.new.isdisjoint(imminent))
    seen = witness.before(imminent) if looked_at else None
    try:
        for i in imminent:
            present.speaker = m = atomics[i]
            try:
                m.output()
            except BaseException as error:
                fail(m, tag, "output", error)
            if m._wait is not None:
                told = "output() must not change the state: call hold_in in a transition"
                fail(m, tag, "output", ModelError(told))
    finally:
        present.speaker = None
    if seen:
        witness.after(tag, seen)
    if promises:
        keep_promises(tag, present.sources)


def results_of(atomics: Iterable[Atomic], present: Present, tag: Tag) -> dict[str, Message]:
    """By path, without those that tell nothing; `now` is the tag meanwhile."""
    before, present.now = present.now, tag
    found: dict[str, Message] = {}
    for m in atomics:
        try:
            result = m.result()
            if m._wait is not None or present.changes:
                raise ModelError("result() must not change the model: do that in a transition")
            if result is not None:
                found[m.path] = travelling(_checked(result), "its result")
        except BaseException as error:
            m._wait, present.changes = None, []
            fail(m, tag, "result", error)
    present.now = before
    return found


def _checked(result: object) -> Message:
    if not isinstance(result, Message):
        raise ModelError(f"result() returned {type(result).__name__} {result!r:.60}; it must return a Message or None")
    return result
