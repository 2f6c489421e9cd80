"""The coordinator's end of a run whose nodes live in its own process; see `hub` for the contract."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterable

import zenoh
from heavylift.coordinator.stopping import whole
from heavylift.kernel.errors import ProtocolError
from zenoh.handlers import Callback

from .exchange import Exchange
from .keys import check_names, key
from .link import LOCAL, LocalLink
from .placement import Placement
from .session import local_session, new_run_id


class LocalHub(Exchange):
    """Connects the coordinator with nodes in this process: one thread, one session, no end point.

    Each message is put through Zenoh and enqueued by a synchronous callback; `receive` is the one loop that
    hands the queued messages to the nodes' handlers, in the order in which they were sent, until one speaks.
    """

    def __init__(self, models: Iterable[str]) -> None:
        super().__init__(local_session(), new_run_id(), Placement({LOCAL: check_names(models, "node")}))
        self._inbox: deque[zenoh.Sample] = deque()
        keep = Callback(self._inbox.append, indirect=False)
        self._subscriber = self._session.declare_subscriber(key(self.run, "out", "*", "*"), keep)
        self._ready: deque[str] = deque()
        self._links: dict[str, LocalLink] = {}
        self.sampled: Callable[[], None] = lambda: None
        """Called when a node has sampled, in the middle of its work."""

    def link(self, node: str) -> LocalLink:
        """The node's end; made on the first call."""
        if node not in self._links:
            self._links[node] = LocalLink(self._session, self.run, node, self._ready, lambda: self.sampled())
        return self._links[node]

    def send(self, node: str, payload: bytes) -> None:
        """Send a protocol message to a node, which has it when this returns."""
        with whole():
            super().send(node, payload)

    def receive(self, timeout: float | None = None) -> tuple[str, bytes] | None:
        """The next (node, message); lets nodes work until there is one; None if none can come in time."""
        while not self._inbox:
            if self._ready:
                self._links[self._ready.popleft()].dispatch()
            elif timeout is not None:
                return None
            else:
                raise ProtocolError(
                    f"run {self.run}: the coordinator waits for a message, but no node of this process "
                    "has one to answer, send a message before receiving"
                )
        sample = self._inbox.popleft()
        got = self._open(str(sample.key_expr), sample, self._out)
        assert got is not None, "nodes of this process have no successors"
        return got

    def close(self) -> None:
        """End the session."""
        while self._links:
            self._links.popitem()[1].close()
        super().close()
