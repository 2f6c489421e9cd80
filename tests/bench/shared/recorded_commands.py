"""A run in one process, then its kernel alone with the recorded grants and commands.

The same commands at the same times also drive a pruned scene: the loaders' hinges locked, upper and lower part one body
(nothing orders a hinge, and it decides neither the loads of the ropes nor the way of the block).
"""

import tempfile
import time
from dataclasses import replace
from pathlib import Path

import heavylift.coordinator.participants.kernel_node as room
import heavylift.coordinator.run.scene as runner
import msgspec
import numpy as np
from heavylift.coordinator.participants import RowFrames
from heavylift.nodes.scene import load


class Noting(room.KernelNode):
    """Notes what the kernel is reported."""

    def __init__(self, config, publish, **how):
        super().__init__(config, publish, **how)
        self.config, self.history, self.end = config, [], None
        Noting.newest = self

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


def noted_in(scene):
    """What the kernel of a loaded scene is reported in a run."""
    original, room.KernelNode = room.KernelNode, Noting
    try:
        with tempfile.TemporaryDirectory() as folder:
            runner.run(scene, Path(folder) / "run.mcap", in_process=True)
    finally:
        room.KernelNode = original
    return Noting.newest


def played_again(noted, kernel):
    """Let a new kernel hear what another was reported."""
    kernel.start()
    for step in noted.history:
        kernel.advance(*step)
    kernel.finish(noted.end)


def kernel_alone(scene, *overrides):
    """What the kernel was reported; its tensions; attempted steps; and CPU seconds by what they were spent on."""
    began = time.process_time()
    noted = noted_in(load(scene, overrides))
    whole = time.process_time() - began

    began = time.thread_time()
    tensions = Tensions()
    kernel = room.KernelNode(noted.config, RowFrames(tensions.take))
    start = time.thread_time() - began
    simulation = kernel.simulation
    native, samples = Clock(simulation.native, "call"), Clock(kernel, "_flush")
    began = time.thread_time()
    played_again(noted, kernel)
    alone = time.thread_time() - began
    spent = {
        "start": start,
        "kernel, machine code": native.seconds,
        "kernel, events and commands": alone - native.seconds - samples.seconds,
        "samples": samples.seconds,
        "rounds, recording, exit": whole - start - alone,
    }
    steps = simulation["accepted"] + simulation["rejected"]
    return noted, tensions.of(kernel), steps, alone - samples.seconds, spent


class Tensions:
    """Times [s] and rope tensions (n, ropes) [N] out of the batches that a kernel publishes."""

    def __init__(self):
        self.batches = []

    def take(self, batch):
        self.batches.append(msgspec.msgpack.decode(batch))

    def of(self, kernel):
        channels = msgspec.msgpack.decode(kernel.layout())["channels"]
        at = next(c for c in channels if c["topic"] == "rope/tension")
        t = np.concatenate([np.array(times) for _, times, _ in self.batches]) * 1e-9
        rows = [np.frombuffer(rows, "<f8").reshape(len(times), -1) for _, times, rows in self.batches]
        return t, np.concatenate(rows)[:, at["start"] : at["stop"]]


def without_hinges(system):
    """The declarations of a node with its hinges locked, and the names of the brakes that are spared."""
    hinges = {j.name for j in system.joints if j.name.endswith("hinge")}
    joints = tuple(replace(j, kind="fixed", q0=(), v0=()) if j.name in hinges else j for j in system.joints)
    kept = {
        group: tuple(x for x in getattr(system, group) if x.joint not in hinges)
        for group in ("springs", "stops", "brakes")
    }
    return replace(system, joints=joints, **kept), {b.name for b in system.brakes if b.joint in hinges}


def pruned_alone(noted, method):
    """Tensions, degrees of freedom and CPU seconds of the pruned scene under the same commands at the same times."""
    pruned = [without_hinges(s) for s in noted.config.systems]
    spared = {name for _, names in pruned for name in names}
    config = msgspec.structs.replace(noted.config, systems=[s for s, _ in pruned], method=method)
    tensions = Tensions()
    kernel = room.KernelNode(config, RowFrames(tensions.take))
    simulation, samples = kernel.simulation, Clock(kernel, "_flush")

    def run(until):
        simulation.run(until)
        while simulation.event and simulation.next_ns <= until:
            simulation.fire()
            simulation.settle()
            simulation.run(until)

    began = time.thread_time()
    kernel.start()
    for tag, bag, _ in noted.history:
        orders = [event.value for event in bag if getattr(event.value, "brake", None) not in spared]
        if orders:
            run(tag.t)
            simulation.interrupt(tag.t)
            for order in orders:
                order.apply(simulation)
            simulation.settle()
            kernel._before = tag.t
            kernel._flush()
    run(noted.end.t - 1)
    kernel.finish(noted.end)
    alone = time.thread_time() - began - samples.seconds
    return tensions.of(kernel), simulation.program.nv, alone
