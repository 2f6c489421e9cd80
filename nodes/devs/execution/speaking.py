"""Lambda: what the atomics that are due say at a tag, in path order, each once, and changing nothing by it."""

from collections.abc import Sequence

from heavylift.kernel.errors import ModelError
from heavylift.nodes.devs.models import Atomic, Present
from heavylift.nodes.devs.tags import Instant

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
            except (Exception, SystemExit) as error:
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
