"""The scene of a recording simulated again, all models in this process: every event and every sample must come again.

Events are compared as they are committed, so a run that parts from its recording ends there.  What an operator ordered
is ordered again at its tag.  A recording that was stopped or cut off is compared as far as it goes.
"""

from __future__ import annotations

import msgspec
from heavylift.coordinator.participants.kernel_node import KernelNode
from heavylift.coordinator.protocol.memory import run_in_memory
from heavylift.coordinator.protocol.node import Node
from heavylift.coordinator.protocol.outside import OpenCoordinator
from heavylift.nodes.devs import Event
from heavylift.recordings import Digest, SampleLayout
from heavylift.recordings.format.columns import Columns
from heavylift.recordings.format.samples import decode_batch

from .deviation import Deviation, Follower, Outcome, first_of, sample_apart
from .recorded import RecordedRun


class _Apart(Exception):
    """The new run has parted from the recorded one."""

    def __init__(self, deviation: Deviation) -> None:
        super().__init__(str(deviation))
        self.deviation = deviation


def verify(run: RecordedRun) -> Outcome:
    """Simulate again; the outcome has the digest of the new run if it came to the same end."""
    cast, end = run.cast, run.end
    batches: list[bytes] = []
    models = {name: cast.make(name, batches.append) for name in cast.nodes}
    follower, digest = Follower(run.events), Digest()

    def hear(event: Event) -> None:
        if deviation := follower.hear(event):
            raise _Apart(deviation)
        digest.event(event.t, event.k, event.source, event.port, event.index, event.type, event.payload)

    wires, outside, finish, _ = cast.wiring
    core = OpenCoordinator(models, wires, end, finish, hear, outside, cast.microsteps)
    for event in run.events:
        if event.source not in models:  # an operator's, known from the beginning
            core.inject(event)
    kernel = next((model for model in models.values() if isinstance(model, KernelNode)), None)
    try:
        run_in_memory(core, [Node(name, model) for name, model in models.items()])
        found = follower.reach(end)
    except _Apart as apart:
        found = apart.deviation
    else:
        if kernel is not None:
            kernel.finish(end)
    layout = kernel.layout() if kernel is not None else b""
    if kernel is not None:
        found = first_of(found, sample_apart(run, layout, batches))
    if found is not None or not run.complete:
        return Outcome(follower.count, found)
    if kernel is not None:
        _digest_samples(digest, layout, batches)
    return Outcome(follower.count, None, digest.hexdigest())


def _digest_samples(digest: Digest, layout: bytes, batches: list[bytes]) -> None:
    """The samples as they would stand in the file."""
    announced = msgspec.msgpack.decode(layout, type=SampleLayout)
    columns = {"": Columns(announced)} | {name: Columns(own) for name, own in announced.lifts.items()}
    for batch in (decode_batch(data, announced) for data in batches):
        rounded = columns[batch.lift](batch.rows)
        for number, (t_ns, row) in enumerate(zip(batch.times, rounded, strict=True), batch.first):
            digest.samples(number, t_ns, row.tobytes(), batch.lift)
        for note in batch.notes:
            digest.note(note.number, note.t_ns, note.sentence)
