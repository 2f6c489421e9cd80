"""One node of a run, from WELCOME to BYE, in its own process or in the coordinator's.

A node consists of the models of its process, run by one simulator, or of the kernel. WELCOME brings its configuration
(parts.py); the answer is HELLO with the node's declaration. A log of transitions is a data topic, one batch per grant:
[node's tag ns, [t, k, path, kind, bag, sent] ...], where bag and sent hold (port, type, bytes).
"""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from functools import partial
from typing import TYPE_CHECKING

import msgspec
from heavylift.coordinator.protocol import messages as m
from heavylift.coordinator.protocol.distance import together
from heavylift.coordinator.protocol.node import Node, failure
from heavylift.kernel.errors import UNREADABLE, ModelError, ProtocolError
from heavylift.kernel.version import __version__
from heavylift.nodes.devs import Message, Simulator, Tag, Transition, decode as decode_message, encode

from . import parts

if TYPE_CHECKING:
    from .recorded_kernel import Recalled, RecordedKernel


class Participant:
    """Message handling of one node: `send` answers the coordinator, `sample` publishes data; `over` becomes true after
    BYE or FAIL."""

    def __init__(
        self,
        models: Sequence[str],
        send: Callable[[bytes], None],
        sample: Callable[[bytes], None],
        past: RecordedKernel | None = None,
    ) -> None:
        """Create a participant for these models. `past`: the recorded history of the run, if the node is a kernel that
        replays it."""
        self._past = past
        self.models, self.name, self._send, self._put = models, together(models), send, sample
        self._node: Node | None = None
        self._flush: Callable[[], None] = lambda: None  # what goes to the data topic before an answer
        self._greeted: Callable[[], None] = lambda: None  # what goes there after HELLO
        self._pauses: Callable[[], int] = lambda: 0
        self._unchanged: Callable[[bool], None] = lambda now: None  # of what models share
        self._busy_s = self._put_s = 0.0
        self.over, self.failed = False, ""
        self._cause: BaseException | None = None

    @property
    def steps(self) -> int:
        """Counter that increases while the node makes progress; may be read from any thread."""
        return self._node.steps + self._pauses() if self._node is not None else 0

    def cause(self) -> BaseException | None:
        """Return the exception of a model because of which the node failed, if there is one."""
        return self._node.cause if self._node is not None else self._cause

    def handle(self, data: bytes) -> None:
        """Process one message from the coordinator and send the answer."""
        message = m.decode(data)
        if isinstance(message, m.Grant) and self._node is not None:
            answer: m.AnyMessage | None = self._work(self._node, message)
        elif isinstance(message, m.Welcome):
            answer = self._join(message)
        elif isinstance(message, m.StopRun) and self._node is None:
            answer = m.Bye()
        else:
            if self._node is None:
                raise ProtocolError(f"{self.name} was sent {type(message).__name__.upper()} before WELCOME")
            answer = self._work(self._node, message)
            if isinstance(answer, m.Bye):
                answer = msgspec.structs.replace(answer, busy_s=self._busy_s)
        if answer is not None:
            self._send(m.encode(answer))
            if isinstance(answer, m.Hello):
                self._greeted()
            self.over, self.failed = isinstance(answer, m.Bye | m.Fail), getattr(answer, "sentence", "")

    def _sample(self, data: bytes) -> None:
        """Publish data; its time does not count as the node's busy time if the coordinator is in this process."""
        began = time.perf_counter()
        self._put(data)
        self._put_s += time.perf_counter() - began

    def _work(self, node: Node, message: m.AnyMessage) -> m.AnyMessage | None:
        began, put = time.perf_counter(), self._put_s
        try:
            if isinstance(message, m.Grant):
                self._unchanged(False)
            answer = node.handle(message)
            if isinstance(answer, m.GrantDone | m.Bye):
                self._unchanged(isinstance(answer, m.Bye))
        except ModelError as error:
            answer = node.failure(error)
        self._busy_s += time.perf_counter() - began - (self._put_s - put)
        self._flush()
        return answer

    def _join(self, welcome: m.Welcome) -> m.AnyMessage:
        try:
            node, declaration, agreed = self._take(parts.decode(welcome.config))
        except Exception as error:
            self._cause = error
            return failure(self.name, error)
        self._node = node
        node.handle(welcome)
        return node.hello(declaration, __version__, agreed)

    def _take(self, part: parts.Part) -> tuple[Node, bytes, str]:
        """Create the node of a part; returns it with its declaration and the fingerprint of its configuration."""
        if isinstance(part, parts.KernelPart):
            from .kernel_node import KernelNode
            from .rows import RowFrames

            kernel: KernelNode | Recalled
            if self._past is None:
                kernel = KernelNode(part.config, RowFrames(self._sample), foretells=True)
            else:
                from .recorded_kernel import Recalled

                kernel = Recalled(part.config, self._sample, self._past)
            self._pauses, self._greeted = lambda: kernel.pauses, kernel.foretell
            return Node(self.name, kernel, kernel.finish, samples=True), kernel.layout(), part.agreed
        if isinstance(part, parts.ModelPart):
            from .building import couplings, declarations, with_children
            from .isolation import Commons, secluded

            rebuilt = partial(with_children, part.build, self.models, f"node {self.name}")
            root = rebuilt()
            wires, declared = couplings(root, part.finish), next(declarations(root, [self.models]))
            self._unchanged = Commons(root).unchanged
            log = Transitions(self._sample) if part.log else None
            if log is not None:
                self._flush = log.flush
            simulator = Simulator(secluded(root, self.models, rebuilt), log, part.microsteps, wires=wires)
            self._pauses = lambda: simulator.passed
            return Node(self.name, simulator), declared, parts.fingerprint(part.build.encode())
        from heavylift.nodes.models import build, together
        from heavylift.nodes.plan.plan import decode

        from .configuration import wiring

        plan = decode(part.plan)
        models = [*build(plan, self.models).values()]
        acting = Simulator(models, microsteps=plan.microsteps, wires=wiring(plan).all)
        self._pauses = lambda: acting.passed
        if len(plan.models) > 1:
            from .isolation import Commons

            self._unchanged = Commons(together(plan)).unchanged

        def waits(end: Tag) -> str:
            return "; ".join(text for m in acting.models if (text := str(getattr(m, "waiting_for", str)())))

        declared = msgspec.msgpack.encode([model.declare() for model in models])
        return Node(self.name, acting, waits), declared, parts.fingerprint(part.plan)


_Said = tuple[str, str, bytes]  # port, class name, canonical bytes
_Line = tuple[int, int, str, str, list[_Said], list[_Said]]
_DECODER: msgspec.msgpack.Decoder[list[_Line]] = msgspec.msgpack.Decoder(list[_Line])


class Transitions:
    """Log of the transitions of a node's models; `flush` publishes it."""

    def __init__(self, publish: Callable[[bytes], None]) -> None:
        self._publish = publish
        self._lines: list[_Line] = []

    def __call__(self, line: Transition) -> None:
        self._lines.append((*line.tag, line.path, line.kind, _wire(line.bag), _wire(line.sent)))

    def flush(self) -> None:
        """Publish the transitions logged since the last call."""
        if self._lines:
            self._publish(msgspec.msgpack.encode(self._lines))
            self._lines.clear()


def read(batch: bytes) -> list[Transition]:
    """Decode a batch of logged transitions; raises ProtocolError if it cannot be read."""
    try:
        message = _DECODER.decode(batch)
    except UNREADABLE as error:
        raise ProtocolError(f"a node sent a log of transitions that cannot be decoded ({error})") from None
    return [
        Transition(Tag(t, k), path, kind, _messages(bag), _messages(sent)) for t, k, path, kind, bag, sent in message
    ]


def _wire(text: tuple[tuple[str, Message], ...]) -> list[_Said]:
    return [(port, type(value).__name__, encode(value)) for port, value in text]


def _messages(text: list[_Said]) -> tuple[tuple[str, Message], ...]:
    return tuple((port, decode_message(name, payload)) for port, name, payload in text)
