"""The samples of a run on its bus, for programs that subscribe to them; who is slow misses some and holds nobody up."""

from __future__ import annotations

from google.protobuf.descriptor import Descriptor  # type: ignore[import-untyped]
from heavylift.coordinator.transport.hub import Hub


class OnTheBus:
    """Puts messages on the keys sample/<topic> of a run, once there is a hub."""

    def __init__(self) -> None:
        self._hub: Hub | None = None
        self._schemas: dict[str, str] = {}

    def open(self, hub: Hub) -> None:
        """Put on this run's keys from now on."""
        self._hub = hub
        for topic in self._schemas:
            hub.heard_data(topic[1:])

    def announce(self, topic: str, descriptor: Descriptor) -> None:
        """There will be messages of this kind on the topic."""
        self._schemas[topic] = descriptor.full_name
        if self._hub is not None:
            self._hub.heard_data(topic[1:])

    def listens(self) -> bool:
        """Whether anybody subscribes to one of them."""
        hub = self._hub
        return hub is not None and any([hub.heard_data(topic[1:]) for topic in self._schemas])

    def put(self, topic: str, t_ns: int, data: bytes) -> None:
        """A message of this simulation time."""
        if self._hub is not None:
            self._hub.publish_data(topic[1:], data, self._schemas[topic], t_ns)
