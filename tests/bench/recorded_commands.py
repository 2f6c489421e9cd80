"""A run in one process, then its kernel alone, driven by the grants and commands that it got then."""

import tempfile
import time
from pathlib import Path

import heavylift.coordinator.kernel_node as room
import heavylift.coordinator.run as runner
from heavylift.nodes.scene import load


class Noting(room.KernelNode):
    """Notes what the kernel is told."""

    def __init__(self, config, publish):
        super().__init__(config, publish)
        self.config, self.history, self.end = config, [], None
        Noting.last = self

    def advance(self, tag, bag, until):
        self.history.append((tag, bag, until))
        super().advance(tag, bag, until)

    def finish(self, end):
        self.end = end
        return super().finish(end)


class Clock:
    """CPU seconds inside a function."""

    def __init__(self, owner, name):
        self.seconds, self._work = 0.0, getattr(owner, name)
        setattr(owner, name, self)

    def __call__(self, *arguments):
        began = time.thread_time()
        result = self._work(*arguments)
        self.seconds += time.thread_time() - began
        return result


def kernel_alone(scene):
    """Simulated seconds, degrees of freedom, attempted steps, and CPU seconds by what they were spent on."""
    began = time.process_time()
    original, room.KernelNode = room.KernelNode, Noting
    try:
        with tempfile.TemporaryDirectory() as folder:
            runner.run(load(scene), Path(folder) / "run.mcap", in_process=True)
    finally:
        room.KernelNode = original
    whole = time.process_time() - began
    noted = Noting.last

    began = time.thread_time()
    kernel = room.KernelNode(noted.config, lambda batch: None)
    start = time.thread_time() - began
    simulation = kernel.simulation
    native, samples = Clock(simulation._code, "call"), Clock(kernel, "_flush")
    began = time.thread_time()
    kernel.start()
    for step in noted.history:
        kernel.advance(*step)
    kernel.finish(noted.end)
    alone = time.thread_time() - began
    spent = {
        "start": start,
        "kernel, machine code": native.seconds,
        "kernel, events and commands": alone - native.seconds - samples.seconds,
        "samples": samples.seconds,
        "rounds, recording, exit": whole - start - alone,
    }
    steps = simulation["accepted"] + simulation["rejected"]
    return noted.end.t * 1e-9, simulation.program.nv, steps, alone - samples.seconds, spent
