"""What the atomics of a run tell of it when it is over, each by `result()`."""

from collections.abc import Iterable

from heavylift.kernel.errors import ModelError
from heavylift.nodes.devs.messages import Message
from heavylift.nodes.devs.models import Atomic, Present
from heavylift.nodes.devs.tags import Tag
from heavylift.nodes.devs.travelling import travelling

from .rules import fail


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
        except (Exception, SystemExit) as error:
            m._wait, present.changes = None, []
            fail(m, tag, "result", error)
    present.now = before
    return found


def _checked(result: object) -> Message:
    if not isinstance(result, Message):
        raise ModelError(f"result() returned {type(result).__name__} {result!r:.60}; it must return a Message or None")
    return result
