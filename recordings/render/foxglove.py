"""The Foxglove websocket of a run that goes on: samples, poses, ropes, boxes and events for Foxglove and Lichtblick.

The server is foxglove-sdk's, an extra; its threads send, and drop what a slow viewer does not take.
"""

from __future__ import annotations

from typing import Any, Self

from google.protobuf.descriptor import Descriptor  # type: ignore[import-untyped]
from heavylift.kernel.errors import RecordingError, extra
from heavylift.recordings.format.schema import file_descriptor_set

PORT = 8765  # the one that viewers propose


class FoxgloveServer:
    """A `Listener` that serves viewers on this machine; a context manager around the whole run."""

    def __init__(self, name: str, port: int = PORT) -> None:
        """RecordingError if the package is missing or the port is taken."""
        missing = "--foxglove needs the package foxglove-sdk: pip install 'heavylift[foxglove]'"
        self._sdk = extra("foxglove", RecordingError(missing))
        self._context, self._channels = self._sdk.Context(), dict[str, Any]()
        try:
            self._server = self._sdk.start_server(name=name, port=port, context=self._context)
        except (OSError, RuntimeError) as error:
            raise RecordingError(f"--foxglove: port {port} cannot be served ({error}); end what uses it") from None
        self.url = f"ws://127.0.0.1:{self._server.port}"
        """Where viewers find it."""

    def announce(self, topic: str, descriptor: Descriptor) -> None:
        """There will be messages of this kind on the topic."""
        schema = self._sdk.Schema(name=descriptor.full_name, encoding="protobuf", data=file_descriptor_set(descriptor))
        self._channels[topic] = self._sdk.Channel(
            topic, schema=schema, message_encoding="protobuf", context=self._context
        )

    def listens(self) -> bool:
        """Whether a viewer has subscribed to one of them."""
        return any(channel.has_sinks() for channel in self._channels.values())

    def put(self, topic: str, t_ns: int, data: bytes) -> None:
        """A message of this simulation time."""
        self._channels[topic].log(data, log_time=t_ns)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self._server.stop()
