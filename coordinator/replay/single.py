"""One model for real against the recorded rest: it gets its recorded inputs at their tags and must say what it said.

The model is built by the code that is installed now, so a change of it shows as the first event that deviates.  For
the kernel the samples are compared, too.  After its first deviation a model would live in a past that never was: the
comparison ends there.
"""

from __future__ import annotations

from collections.abc import Sequence

from heavylift.kernel.errors import RecordingError
from heavylift.nodes.devs import Delivery, Simulator, Steppable, Tag
from heavylift.nodes.models import COMMANDER, KERNEL, build, build_one

from ..kernel_node import KernelNode
from ..pause import configured
from .deviation import Deviation, Follower, Outcome
from .recorded import RecordedRun
from .sampled import first_of, sample_apart

__all__ = ["models_of", "single"]


def models_of(run: RecordedRun) -> dict[str, str]:
    """The models that can be run alone: node name by the name that a user gives, such as crane/west or west."""
    plan = run.plan
    kinds = (("crane", plan.cranes), ("loader", plan.loaders), ("mechanism", plan.mechanisms))
    found = {f"{kind}/{x.name}": x.name for kind, some in kinds for x in some}
    found |= {plan.block.name: plan.block.name} if plan.block else {}
    return {**found, COMMANDER: COMMANDER, KERNEL: KERNEL}


def single(run: RecordedRun, name: str) -> Outcome:
    """Run one model against the recording; RecordingError if the recording has no such model."""
    known = models_of(run)
    node = known.get(name) or (name if name in known.values() else None)
    if node is None:
        raise RecordingError(f"{run.path}: there is no model {name} in it, it has {', '.join(known)}")
    events = run.events
    into = [(source, port, entry) for source, port, target, entry in run.wiring if target == node]
    inputs = [
        Delivery(e, entry) for e in events for source, port, entry in into if (e.source, e.port) == (source, port)
    ]
    inputs.sort(key=lambda d: (d.event.order, d.port))
    follower = Follower([e for e in events if e.source == node])
    if node != KERNEL:
        found = _play(Simulator(build_one(run.plan, node)), inputs, run.end, follower)
        return Outcome(follower.count, found)
    batches: list[bytes] = []
    kernel = KernelNode(configured(run.plan, build(run.plan)), batches.append)
    found = _play(kernel, inputs, run.end, follower)
    if found is None:
        kernel.finish(run.end)
    return Outcome(follower.count, first_of(found, sample_apart(run, kernel.layout(), batches)))


def _play(model: Steppable, inputs: Sequence[Delivery], end: Tag, follower: Follower) -> Deviation | None:
    """Every tag of the model before `end`."""
    model.start()
    at = 0
    while True:
        due = model.next_time
        tag = min(due, inputs[at].event.tag) if at < len(inputs) else due
        missing = follower.reach(min(tag, end))
        if missing or tag >= end:
            return missing
        begin = at
        while at < len(inputs) and inputs[at].event.tag == tag:
            at += 1
        for event in model.outputs() if tag == due else []:
            if deviation := follower.hear(event):
                return deviation
        model.advance(tag, inputs[begin:at], inputs[at].event.tag if at < len(inputs) else end)
