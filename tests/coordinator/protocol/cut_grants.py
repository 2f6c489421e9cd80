"""Nodes whose grants end earlier than the coordinator has said, as a slow transport might cut them."""

from __future__ import annotations

from random import Random
from typing import Any

import msgspec
from heavylift.coordinator.protocol import AnyMessage, Grant, Node
from heavylift.nodes.devs import after, succ


class Cut:
    """A node whose grants end earlier at random, yet late enough to do one tag."""

    def __init__(self, node: Node, chance: Random) -> None:
        self._node, self._chance = node, chance

    def __getattr__(self, name: str) -> Any:
        return getattr(self._node, name)

    def handle(self, message: AnyMessage) -> AnyMessage | None:
        if isinstance(message, Grant):
            tag = min([self._node.first, *(event.tag for event in message.inputs)])
            end = self._chance.choice([message.until, succ(tag), after(tag, 1 + self._chance.randrange(5))])
            message = msgspec.structs.replace(message, until=min(end, message.until))
        return self._node.handle(message)
