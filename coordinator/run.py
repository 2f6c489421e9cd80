"""One run: start the nodes, let the protocol decide, record what happens, end in order.

    plan -> WELCOME(plan) -> HELLO(declaration) of every model -> WELCOME(declarations) -> HELLO of the kernel
    -> GRANT / DONE rounds -> STOP -> BYE
The same loop serves processes over a private socket and nodes in this process over a local session.
"""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import msgspec
from heavylift.kernel.describe import System
from heavylift.kernel.errors import ModelError, ProtocolError, Stopped
from heavylift.nodes.devs import FOREVER, Event, Tag, ns
from heavylift.nodes.models import COMMANDER, KERNEL, NodeModel, build, couplings, subscriptions
from heavylift.nodes.scene.plan import encode

from . import messages as m
from .budget import Budget
from .core import Coordinator, Outcome
from .hub import Hub, LocalHub
from .participant import NODE_MODULE, PRELOAD, Participant, Setup, fingerprint, version
from .processes import Processes
from .record import Record, Result
from .watch import Watch

if TYPE_CHECKING:
    from heavylift.nodes.scene import LoadedScene

__all__ = ["Result", "run"]

PATIENCE_s = 30.0  # for a node's HELLO
PATIENCE_ns = 4 * 3600 * 10**9  # simulated time without an order after which a scene without an end is stuck: a load
# that swings undamped never comes to rest, and a run must not go on for ever
LOOK_s = 0.2  # how often samples are taken while a node works


def run(
    scene: LoadedScene,
    output: Path,
    in_process: bool = False,
    watch: Watch | None = None,
    processes: Processes | None = None,
    order: list[str] | None = None,
) -> Result:
    """Simulate a scene into a recording; `order`: names of the nodes in the order in which they are started.

    Raises HeavyliftError: one sentence, after the recording is finished and all processes are gone.
    """
    plan = scene.plan
    models = build(plan)
    names = order or [*models, KERNEL]
    started = time.perf_counter()
    with Record(scene, models, output) as record, _nodes(names, in_process, processes) as hub:
        session = _Session(scene, models, hub, record, watch or Watch())
        try:
            session.play()
            played = record.mark()
            session.dismiss()
        except BaseException as error:
            session.abort()
            raise _named(error, session) from error
        result = record.finish(session.grants, time.perf_counter() - started, session.unfinished)
    budget = Budget.of((started, 0.0), session.greeted, played, record.mark(), session.kernel_s)
    return replace(result, budget=budget)


@contextmanager
def _nodes(names: list[str], in_process: bool, processes: Processes | None) -> Iterator[Hub | LocalHub]:
    if in_process:
        with LocalHub(names) as local:
            for name in names:
                link = local.link(name)
                link.serve(Participant(name, link.send, link.sample).handle)
            yield local
        return
    with Hub(names) as hub, processes or Processes(PRELOAD) as crew:
        crew.start(hub, {name: (NODE_MODULE, name) for name in names})
        yield hub


def _named(error: BaseException, session: _Session) -> BaseException:
    if isinstance(error, KeyboardInterrupt):
        at = session.now.t * 1e-9
        return Stopped(f"stopped by the user at {at:.3f} s; the recording is complete up to there")
    return error


class _Session:
    """The conversation with the nodes of one run."""

    def __init__(
        self,
        scene: LoadedScene,
        models: dict[str, NodeModel],
        hub: Hub | LocalHub,
        record: Record,
        watch: Watch,
    ) -> None:
        self._plan, self._models, self._hub, self._record, self._watch = (
            scene.plan,
            models,
            hub,
            record,
            watch,
        )
        self.now = Tag(0)
        self.grants = 0
        self.unfinished = ""
        self.greeted, self.kernel_s = record.mark(), 0.0
        self._outcome: Outcome | None = None
        end = Tag(ns(self._plan.end)) if self._plan.end is not None else Tag(PATIENCE_ns)
        self._core = Coordinator([*models, KERNEL], couplings(self._plan), end, (COMMANDER, "finished"), self._event)
        if isinstance(hub, Hub):
            hub.when = lambda: f"t = {self.now.t * 1e-9:.3f} s"

    def play(self) -> None:
        """HELLO of everybody, then rounds until nothing is left to do."""
        self._greet()
        self.greeted = self._record.mark()
        while True:
            for name, grant in self._core.ready():
                self._send(name, grant)
                self.grants += 1
            self._record.settle(self._core.floor.t)
            self._outcome = self._core.over
            if self._outcome is None:
                self._done(*self._receive())
            elif self._outcome is not Outcome.BOUND or self._plan.end is not None or not self._hope():
                return

    def _hope(self) -> bool:
        """Whether a scene without an end may go on: a model has something before it, not only a load that swings."""
        due = self._core.scheduled(self._models)
        if due < FOREVER:
            self._core.extend(Tag(due.t + PATIENCE_ns))
        return due < FOREVER

    def _greet(self) -> None:
        plan = encode(self._plan)
        self._fingerprint = fingerprint(plan)
        setup = Setup(plan)
        for name in self._models:
            self._send(name, m.Welcome(1, msgspec.msgpack.encode(setup)))
        declared: dict[str, bytes] = {}
        while len(declared) < len(self._models):  # they arrive in any order
            node, hello = self._receive(PATIENCE_s)
            declared[node] = self._hello(node, hello)
        systems = [msgspec.msgpack.decode(declared[name], type=System) for name in self._models]
        config = {
            "systems": systems,
            "gravity": self._plan.gravity,
            "tolerance": self._plan.tolerance,
            "sample_ns": round(1e9 / self._plan.samples_hz),
            "subscriptions": subscriptions(self._plan),
            "method": self._plan.method,
            "step": self._plan.step,
        }
        kernel = Setup(plan, msgspec.msgpack.encode(config))
        self._send(KERNEL, m.Welcome(1, msgspec.msgpack.encode(kernel)))
        self._record.layout(self._hello(*self._receive(PATIENCE_s)), systems)

    def _send(self, node: str, message: m.AnyMessage) -> None:
        data = m.encode(message)
        self._record.protocol(self.now.t, node, "to node", message, data)
        self._hub.send(node, data)

    def _receive(self, patience: float | None = None) -> tuple[str, m.AnyMessage]:
        deadline = time.monotonic() + patience if patience else None
        while True:
            got = self._hub.receive(LOOK_s)
            self._take_samples()
            if got is not None:
                node, data = got
                message = m.decode(data)
                self._record.protocol(self.now.t, node, "from node", message, data)
                if isinstance(message, m.Fail):
                    self._record.failed(message)
                    raise ModelError(message.sentence)
                return node, message
            if deadline is not None and time.monotonic() > deadline:
                raise ProtocolError(f"no node has said HELLO for {patience:.0f} s; start the run again")

    def _hello(self, node: str, message: m.AnyMessage) -> bytes:
        if not isinstance(message, m.Hello):
            raise ProtocolError(f"{node} sent {type(message).__name__.upper()} where HELLO was expected")
        if (message.version, message.scene) != (version(), self._fingerprint):
            raise ProtocolError(
                f"node {node} runs heavylift {message.version} with another scene or version than the coordinator's "
                f"{version()}; use one installation for all nodes"
            )
        self._core.hello(node, message)
        return message.declaration

    def _done(self, node: str, message: m.AnyMessage) -> None:
        if not isinstance(message, m.Done):
            raise ProtocolError(f"{node} sent {type(message).__name__.upper()} where DONE was expected")
        self._core.done(node, message)

    def _event(self, event: Event) -> None:
        self.now = max(self.now, event.tag)
        self._record.event(event)
        if event.source == COMMANDER and self._plan.end is None:
            self._core.extend(Tag(event.t + PATIENCE_ns))
        self._hub.publish_event(event.source, event.port, event.payload)
        self._watch.event(event)

    def _take_samples(self) -> None:
        for _, batch in self._hub.samples():
            self.now = max(self.now, Tag(self._record.samples(batch)))
            self._watch.progress(self.now.t)

    def dismiss(self) -> None:
        """The ordered end: STOP, the last samples, BYE; raises ModelError if a model still waits for something."""
        ended = (
            self._outcome is Outcome.QUIET and self._plan.end is None
        )  # where nothing moves, time goes on all the same
        end = Tag(self.now.t + 1) if ended else self._core.end
        self._hub.dismiss(m.encode(m.Stop(end)))
        staying = {*self._models, KERNEL}
        sentences = []
        while staying:
            node, message = self._receive(PATIENCE_s)
            if isinstance(message, m.Bye):
                staying.discard(node)
                if node == KERNEL:
                    self.kernel_s = message.busy_s
                sentences += [message.sentence] if message.sentence else []
        self._take_samples()
        if sentences and self._plan.end is None and self._outcome is not Outcome.FINISHED:
            raise ModelError(sentences[0])
        self.unfinished = "; ".join(sentences)

    def abort(self) -> None:
        """Nodes may go; what they sampled so far is kept."""
        self._hub.dismiss(m.encode(m.Stop(self.now, "aborted")))
        self._take_samples()
