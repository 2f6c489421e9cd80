"""One model for real against the recorded rest: it gets its recorded inputs at their tags and must say what it said.

The model is built by the code that is installed now, so a change of it shows as the first event that deviates.  For
the kernel the samples are compared, too.  After its first deviation a model would live in a past that never was: the
comparison ends there.
"""

from __future__ import annotations

from collections.abc import Sequence

from heavylift.coordinator.participants.kernel_node import KernelNode
from heavylift.kernel.errors import RecordingError
from heavylift.nodes.devs import Event, Steppable, Tag

from .deviation import Deviation, EventComparison, ReplayResult, first_of, sample_apart
from .recorded import RecordedRun


def single(run: RecordedRun, name: str) -> ReplayResult:
    """Run one model against the recording; RecordingError if the recording has no such model."""
    try:
        node = run.cast.node(name)
    except RecordingError as error:
        raise RecordingError(f"{run.path}: {error}") from None
    events, end, cast = run.events, run.end, run.cast
    heard = {(wire.source, wire.port) for wire in cast.wiring.all if wire.target == node}
    inputs = [e for e in events if (e.source, e.port) in heard]
    follower = EventComparison([e for e in events if e.source == node])
    batches: list[bytes] = []
    model = cast.make(node, batches.append)
    found = _play(model, inputs, end, follower)
    if isinstance(model, KernelNode):
        if found is None:
            model.finish(end)
        found = first_of(found, sample_apart(run, model.layout(), batches))
    return ReplayResult(follower.count, found)


def _play(model: Steppable, inputs: Sequence[Event], end: Tag, follower: EventComparison) -> Deviation | None:
    """Every tag of the model before `end`."""
    model.start()
    at = 0
    while True:
        due = model.next_time
        tag = min(due, inputs[at].tag) if at < len(inputs) else due
        missing = follower.reach(min(tag, end))
        if missing or tag >= end:
            return missing
        begin = at
        while at < len(inputs) and inputs[at].tag == tag:
            at += 1
        for event in model.outputs() if tag == due else []:
            if deviation := follower.hear(event):
                return deviation
        model.advance(tag, inputs[begin:at], inputs[at].tag if at < len(inputs) else end)
