"""One node of a run, from WELCOME to BYE, whether it lives in its own process or in the coordinator's.

WELCOME brings the plan (models) or the declarations of all models (kernel); the answer is HELLO with what this node
declares: its part of the mechanics, or the kernel's sample layout.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from hashlib import blake2b
from importlib import metadata

import msgspec
from heavylift.nodes.devs import Simulator

from . import messages as m
from .node import Node

__all__ = ["NODE_MODULE", "PRELOAD", "Participant", "Setup", "fingerprint", "version"]

NODE_MODULE = "heavylift.coordinator.node_process"
PRELOAD = (NODE_MODULE, "heavylift.nodes.models", "heavylift.nodes.scene.plan")  # what every node imports


def version() -> str:
    """The version of heavylift that this process runs."""
    return metadata.version("heavylift")


def fingerprint(plan: bytes) -> str:
    """What two nodes of one run must agree on."""
    return blake2b(plan, digest_size=16).hexdigest()


class Setup(msgspec.Struct, frozen=True):
    """Config of a WELCOME: the plan, and for the kernel what the models have declared."""

    plan: bytes
    kernel: bytes = b""


class Participant:
    """`send` answers the coordinator, `sample` puts on the data topic; `over` after BYE or FAIL."""

    def __init__(self, name: str, send: Callable[[bytes], None], sample: Callable[[bytes], None]) -> None:
        self.name, self._send, self._sample = name, send, sample
        self._node: Node | None = None
        self._busy_s = 0.0
        self.over = False

    def handle(self, data: bytes) -> None:
        """Answer one message of the coordinator."""
        message = m.decode(data)
        if isinstance(message, m.Welcome):
            answer: m.AnyMessage | None = self._join(message)
        elif isinstance(message, m.Stop) and self._node is None:
            answer = m.Bye()
        else:
            assert self._node is not None, "WELCOME comes first"
            began = time.perf_counter()
            answer = self._node.handle(message)
            self._busy_s += time.perf_counter() - began
            if isinstance(answer, m.Bye):
                answer = msgspec.structs.replace(answer, busy_s=self._busy_s)
        if answer is not None:
            self._send(m.encode(answer))
        self.over = isinstance(answer, m.Bye | m.Fail)

    def _join(self, welcome: m.Welcome) -> m.AnyMessage:
        setup = msgspec.msgpack.decode(welcome.config, type=Setup)
        try:
            if setup.kernel:
                from .kernel_node import KernelConfig, KernelNode

                kernel = KernelNode(msgspec.msgpack.decode(setup.kernel, type=KernelConfig), self._sample)
                self._node, declaration = Node(self.name, kernel, kernel.finish), kernel.layout()
            else:
                from heavylift.nodes.models import build_one
                from heavylift.nodes.scene.plan import decode

                model = build_one(decode(setup.plan), self.name)
                waits = getattr(model, "waiting_for", lambda: "")
                self._node = Node(self.name, Simulator(model), lambda end: waits())
                declaration = msgspec.msgpack.encode(model.declare())
        except Exception as error:
            return Node.failure(self.name, error)
        self._node.handle(welcome)
        return self._node.hello(declaration, version(), fingerprint(setup.plan))
