"""The scene of a recording simulated again, all models in this process: every event and every sample must come again.

Events are compared as they are committed, so a run that parts from its recording ends there.  A recording that was
stopped or cut off is compared as far as it goes.
"""

from __future__ import annotations

import msgspec
from heavylift.nodes.devs import Event, Simulator
from heavylift.nodes.models import COMMANDER, KERNEL, build
from heavylift.recordings import Digest, SampleLayout
from heavylift.recordings.samples import decode_batch

from ..core import Coordinator
from ..kernel_node import KernelNode
from ..memory import run_in_memory
from ..node import Node
from ..pause import configured
from .deviation import Deviation, Follower, Outcome
from .recorded import RecordedRun
from .sampled import first_of, sample_apart

__all__ = ["verify"]


class _Apart(Exception):
    """The new run has parted from the recorded one."""

    def __init__(self, deviation: Deviation) -> None:
        super().__init__(str(deviation))
        self.deviation = deviation


def verify(run: RecordedRun) -> Outcome:
    """Simulate again; the outcome has the digest of the new run if it came to the same end."""
    plan, end = run.plan, run.end
    models = build(plan)
    batches: list[bytes] = []
    kernel = KernelNode(configured(plan, models), batches.append)
    follower, digest = Follower(run.events), Digest()

    def hear(event: Event) -> None:
        if deviation := follower.hear(event):
            raise _Apart(deviation)
        digest.event(event.t, event.k, event.source, event.port, event.index, event.type, event.payload)

    core = Coordinator([*models, KERNEL], run.wiring, end, (COMMANDER, "finished"), hear)
    nodes = [Node(name, Simulator(model)) for name, model in models.items()]
    try:
        run_in_memory(core, [*nodes, Node(KERNEL, kernel)])
        found = follower.reach(end)
    except _Apart as apart:
        found = apart.deviation
    else:
        kernel.finish(end)
    found = first_of(found, sample_apart(run, kernel.layout(), batches))
    if found is not None or not run.complete:
        return Outcome(follower.count, found)
    width = msgspec.msgpack.decode(kernel.layout(), type=SampleLayout).width
    for batch in (decode_batch(data, width) for data in batches):
        for number, (t_ns, row) in enumerate(zip(batch.times, batch.rows, strict=True), batch.first):
            digest.samples(number, t_ns, row.tobytes())
    return Outcome(follower.count, None, digest.hexdigest())
