"""One run of a scene: start its models and the kernel, run the time protocol, record, end in order.

plan -> WELCOME(plan) of every model and the kernel -> HELLO of all, with the mechanics that the models declare
-> rounds until the commander has finished, the time bound is reached or nothing can happen any more
"""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import msgspec
from heavylift.coordinator.hosts.listener import RemoteListener
from heavylift.coordinator.ladder.choosing import chosen
from heavylift.coordinator.live.command_queue import CommandQueue, TimedCommand
from heavylift.coordinator.live.keys import Keyboard, Keys
from heavylift.coordinator.live.observers import EventPublisher, OnTheBus, shown
from heavylift.coordinator.live.pace import Pace, Tempo
from heavylift.coordinator.participants.configuration import PATIENCE_ns, kernel_config, postponed, wiring
from heavylift.coordinator.participants.external import externals
from heavylift.coordinator.participants.parts import KernelPart, ScenePart, encode as part, fingerprint
from heavylift.coordinator.protocol.distance import together
from heavylift.coordinator.protocol.messages import RunEnd
from heavylift.coordinator.record.run_record import Budget
from heavylift.coordinator.record.scene import Record, RunResult
from heavylift.coordinator.supervision.failover import DEADLINE_s
from heavylift.coordinator.supervision.processes import Processes
from heavylift.coordinator.transport.exchange import LocalHub
from heavylift.coordinator.transport.hub import Hub
from heavylift.coordinator.transport.link import LOCAL
from heavylift.coordinator.transport.placement import Placement
from heavylift.coordinator.verdict import prepare
from heavylift.kernel.description.mechanics import System
from heavylift.kernel.errors import ModelError, ProtocolError
from heavylift.nodes.devs import NEVER, Event, Tag, seconds
from heavylift.nodes.models import COMMANDER, KERNEL, NodeModel, build, divided, goes_on
from heavylift.nodes.models.machine import turning
from heavylift.nodes.models.parts.messages import OperatorCommand
from heavylift.nodes.plan.places import located
from heavylift.nodes.plan.plan import encode
from heavylift.recordings import Spectator, file_path
from heavylift.recordings.write.broadcast import Broadcast, Spectators

from .conversation import Conversation, joined
from .watch import Relay, RunObserver

if TYPE_CHECKING:
    from heavylift.coordinator.participants.recorded_kernel import RecordedKernel
    from heavylift.nodes.scene import LoadedScene

PUBLISH_Hz = 10.0  # samples per simulated second that whoever subscribes to them gets
AHEAD_ns = 10 * 10**9  # simulated time that may be decided at once, and that a command may have to wait for


def run(
    scene: LoadedScene | str | Path,
    output: str | Path,
    in_process: bool = False,
    watch: RunObserver | None = None,
    processes: Processes | None = None,
    order: list[str] | None = None,
    placement: Placement | None = None,
    listener: RemoteListener | None = None,
    page: Spectator | None = None,
    deadline: float = DEADLINE_s,
    pace: Pace | None = None,
    commands: Sequence[TimedCommand] = (),
    keyboard: Keyboard | None = None,
    force: bool = False,
    past: RecordedKernel | None = None,
    publish_hz: float = PUBLISH_Hz,
) -> RunResult:
    """Simulate a scene (loaded, or its path or name) into a recording.

    An existing recording of this name is kept, and the new one is run-2.mcap, as the result says; `force` replaces it.

    `order`: names of the nodes in the order in which they are started.

    `placement` assigns nodes to processes; without one each node has a process of its own. Its processes on other hosts
    connect to the `listener`. A process that does not answer for `deadline` [s] is probed, and replaced if it makes no
    progress. `page` shows the run in progress. Subscribers to samples on the bus get `publish_hz` of them per simulated
    second. `commands` are given at their tags, as those of an operator in another run; the keys of a `keyboard` are
    orders. `past`: recorded history for a kernel in this process; a run that ends within it leaves no recording.

    Raises HeavyliftError: one sentence, after the recording is finished and all processes are gone.
    """
    from heavylift.nodes.scene import loaded  # validators, which processes of nodes do without

    watch = watch or RunObserver()
    lift, file = chosen(loaded(scene), watch.say), file_path(output)
    models = build(lift.plan)
    angles = [name for model in models.values() for name in turning(model.declare())]
    names = order or [*models, KERNEL]
    placed = Placement({LOCAL: tuple(names)}) if in_process else placement or Placement.apart(names)
    started = time.perf_counter()
    tempo = Tempo(pace or Pace(NEVER if in_process else AHEAD_ns))
    bus = OnTheBus()
    observers = Spectators(page or Spectator(), Broadcast(bus, publish_hz))
    with (
        CommandQueue(
            lambda: record.recorder.path,
            tempo,
            lambda words: _order(lift, words),
            lambda answer: located(lift.plan, answer.refused, answer.at),
        ) as queue,
        Record(lift, models, file, placed, observers, force, past.facts if past else {}) as record,
        joined(placed, in_process, processes, listener, deadline, past, KERNEL) as hub,
        shown(hub, lift.plan.name, record.recorder.path, angles) as publisher,
    ):
        if isinstance(hub, Hub):
            queue.open(hub)
            bus.open(hub)
        played = _Run(lift, models, hub, record, watch, publisher, tempo, queue)
        played.talk.written_to(file, record.recorder.path)
        queue.repeat(commands, played.talk.core)
        record.worthless = lambda: past is not None and not past.over
        for sentence in lift.answer.notes if lift.answer else ():
            played.say(sentence)
        try:
            if isinstance(hub, Hub):
                hub.admit(fingerprint(encode(lift.plan)), played.say)
            played.greet()
            for at, state in past.checkpoints() if past and past.used else ():
                record.checkpoint(at, state)
            greeted = record.mark()
            with Keys(queue, keyboard or Keyboard(), played.say):
                played.play()
            done = record.mark()
            played.dismiss()
        except BaseException as error:
            played.talk.abort(error)
            raise
        seconds = time.perf_counter() - started
        result = record.finish(played.talk.grants, seconds, played.unfinished, tempo.pace.lateness)
    budget = Budget.of((started, 0.0), greeted, done, record.mark(), played.kernel_s)
    return replace(result, budget=budget)


class _Run(Relay):
    """The run of a scene: messages with its nodes from their start to the end."""

    def __init__(
        self,
        scene: LoadedScene,
        models: dict[str, NodeModel],
        hub: Hub | LocalHub,
        record: Record,
        watch: RunObserver,
        publisher: EventPublisher | None,
        tempo: Tempo,
        queue: CommandQueue,
    ) -> None:
        self._plan, self._models, self._record, self._watch = scene.plan, models, record, watch
        self._placement = hub.placement
        self.unfinished, self.kernel_s = "", 0.0
        self._outcome = RunEnd.BOUND
        end = Tag(seconds(self._plan.end)) if self._plan.end is not None else Tag(PATIENCE_ns)
        limit, wires = self._plan.microsteps, wiring(self._plan)
        stages = [] if self._plan.lists else [(COMMANDER, "stage")]  # of several lists they would cost all lifts each
        foreign = externals(hub.placement, models, wires.all, limit)
        self.talk = Conversation(hub, wires, end, record, self, publisher, tempo, queue, limit, KERNEL, stages, foreign)
        self._nodes = [node for node in hub.nodes if node != KERNEL]

    def event(self, event: Event) -> None:
        """Extend a run without a stated end whenever an event shows that the action list makes progress; forward the
        event."""
        if self._plan.end is None and goes_on(event):
            self.talk.core.extend(Tag(event.t + PATIENCE_ns))
        self._watch.event(event)

    def greet(self) -> None:
        """Start the nodes; the kernel gets the mechanics that the plan gives, as its models will declare them."""
        systems = {name: model.declare() for name, model in self._models.items()}
        agreed, config = fingerprint(encode(self._plan)), kernel_config(self._plan, self._models, systems.values())
        self.talk.welcome(KERNEL, part(KernelPart(config, agreed)), agreed)
        models = [self._placement.nodes[node] for node in self._nodes]
        for node, plan in zip(self._nodes, map(encode, divided(self._plan, models)), strict=True):
            self.talk.welcome(node, part(ScenePart(plan)), fingerprint(plan))
        prepare()  # while they get ready
        layout = b""
        for _ in (KERNEL, *self._nodes):  # they arrive in any order
            node, text = self.talk.hello()
            names = self._placement.nodes[node]
            if node == KERNEL:
                layout = text
            elif node not in self.talk.externals:  # whose mechanics are those of the model that they play
                _check_declared(together(names), text, [systems[name] for name in names])
        self._record.layout(layout, [*systems.values()])

    def play(self) -> None:
        """Grant time to the nodes, round by round, until the scene ends or no model that gives orders has an event
        left."""
        self._outcome = self.talk.play()
        while postponed(self.talk.core, self._plan):
            self._outcome = self.talk.play()

    def dismiss(self) -> None:
        """End the run after all nodes have finished; raises ModelError if a model still waits for a condition."""
        ended = self._outcome is RunEnd.QUIET and self._plan.end is None
        byes = self.talk.dismiss(Tag(self.talk.now.t + 1) if ended else self.talk.core.end)
        self.kernel_s = byes[KERNEL].busy_s
        sentences = [bye.sentence for bye in byes.values() if bye.sentence]
        if sentences and self._plan.end is None and self._outcome is not RunEnd.FINISHED:
            raise ModelError(sentences[0])
        self.unfinished = "; ".join(sentences)


def _order(scene: LoadedScene, words: str) -> OperatorCommand:
    """Return an operator's command, parsed for this scene."""
    from heavylift.nodes.scene.operator_command import spoken  # reads scenes, which a run without orders need not

    return OperatorCommand(words, msgspec.msgpack.encode(spoken(scene, words)))


def _check_declared(name: str, data: bytes, systems: list[System]) -> None:
    """Raise ProtocolError if the models of node `name`, which may be remote, declare other mechanics than the plan
    gives."""
    if data != msgspec.msgpack.encode(systems):
        raise ProtocolError(
            f"node {name} declares other mechanics than the coordinator's plan gives; use the same version of "
            "heavylift for node and coordinator, and models that declare the same each time"
        )
