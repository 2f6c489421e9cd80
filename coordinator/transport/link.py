"""The nodes' end of a run: `NodeLink` in a process of their own, `LocalLink` in the coordinator's process.

Contract of both: `send` never loses a message, and `receive` returns the coordinator's messages in order, each checked
(frame.py). When a message of `send` arrives at the coordinator, all batches sent before by `sample` have arrived: both
travel in one session, at one priority, in one order. A `NodeLink` serves all nodes of its process.
"""

import time
from collections import deque
from collections.abc import Callable
from contextlib import AbstractContextManager
from typing import Any

import zenoh
from heavylift.coordinator.stopping import whole
from heavylift.kernel.errors import ProtocolError
from zenoh.handlers import Callback, FifoChannel

from .frame import FIRST_EPOCH, FrameReader, FrameTopic, Writer, key
from .session import Ticket, node_session

FIFO = 4096  # messages that may wait at a receiver before its senders wait
JOIN_s = 10.0  # longest time from an open session to a coordinator that listens
LONGEST_s = 0.02  # between two looks whether it does
LEAVE_s = 10.0  # longest time that a process waits for its last messages to arrive
LOCAL = "local"  # in place of a process's name: the coordinator's own


def matched(publisher: zenoh.Publisher) -> bool:
    """Return whether a publisher has a subscriber that is connected."""
    status: Any = publisher.matching_status  # declared as bool in zenoh's type hints
    return bool(status.matching)


class _Sender:
    """The two topics on which a node sends: messages and samples."""

    def __init__(self, session: zenoh.Session, run: str, process: str, node: str, epoch: int) -> None:
        block = zenoh.CongestionControl.BLOCK
        self.run, self.node = run, node
        self._out = session.declare_publisher(key(run, "out", process, node), congestion_control=block)
        self._samples = session.declare_publisher(key(run, "samples", process, node), congestion_control=block)
        self._out_writer = Writer(run, node, FrameTopic.OUT, epoch)
        self._samples_writer = Writer(run, node, FrameTopic.SAMPLES, epoch)
        self.open = FrameReader(run, node, FrameTopic.IN, epoch).open

    @property
    def heard(self) -> bool:
        """Whether the coordinator already subscribes to the node's messages and samples."""
        return matched(self._out) and matched(self._samples)

    def send(self, payload: bytes) -> None:
        """Send a protocol message to the coordinator."""
        self._out.put(self._out_writer.frame(payload))

    def sample(self, payload: bytes) -> None:
        """Send a batch of samples to the coordinator."""
        self._samples.put(self._samples_writer.frame(payload))


class NodeLink(AbstractContextManager["NodeLink"]):
    """The connection of a process to its coordinator, which joins the run with all nodes of the ticket."""

    def __init__(self, ticket: Ticket, session: zenoh.Session | None = None) -> None:
        """`session`: the session that brought the ticket; without it, connect as the ticket states."""
        self.run, self.process = ticket.run, ticket.process
        self.nodes = ticket.nodes
        """Node -> its models."""
        self._session = session = session or node_session(ticket)
        self._senders = {n: _Sender(session, self.run, self.process, n, ticket.epoch) for n in self.nodes}
        self._addresses = {key(self.run, "in", self.process, n): self._senders[n] for n in self.nodes}
        channel: FifoChannel[zenoh.Sample] = FifoChannel(FIFO)
        self._inbox = session.declare_subscriber(key(self.run, "in", self.process, "*"), channel)
        self._join()
        self._epoch = str(ticket.epoch)
        self._alive = session.liveliness().declare_token(key(self.run, "alive", self.process, self._epoch))

    def answer(self, sign: Callable[[], bytes]) -> None:
        """Answer the coordinator's liveness queries with `sign()` in a separate thread."""

        def reply(query: zenoh.Query) -> None:
            query.reply(query.key_expr, sign())

        at = key(self.run, "ask", self.process, self._epoch)
        self._asked = self._session.declare_queryable(at, Callback(reply))

    def _join(self) -> None:
        """Wait until the coordinator has subscribed to all topics; earlier messages would be lost."""
        deadline, pause = time.monotonic() + JOIN_s, 0.001
        while not all(sender.heard for sender in self._senders.values()):
            if time.monotonic() > deadline:
                self.close()
                raise ProtocolError(
                    f"process {self.process} reached run {self.run} but no coordinator listened within "
                    f"{JOIN_s:g} s; start the run again"
                )
            time.sleep(pause)
            pause = min(1.5 * pause, LONGEST_s)  # many that wait at once would take the time for which they wait

    def send(self, node: str, payload: bytes) -> None:
        """Send a protocol message of a node to the coordinator."""
        self._senders[node].send(payload)

    def sample(self, node: str, payload: bytes) -> None:
        """Send a batch of samples of a node to the coordinator."""
        self._senders[node].sample(payload)

    def receive(self) -> tuple[str, bytes]:
        """Wait for the coordinator's next message; return it with the node to which it is addressed."""
        sample = self._inbox.recv()
        sender = self._addresses.get(str(sample.key_expr))
        if sender is None:
            raise ProtocolError(
                f"process {self.process}: a message arrived on {sample.key_expr}, but it hosts "
                f"{', '.join(self.nodes)}; end the process that sent it"
            )
        return sender.node, sender.open(sample.payload.to_bytes())

    def close(self) -> None:
        """Leave the run after all sent messages have arrived, since leaving earlier would lose them.

        The coordinator's session handles queries in the order of arrival, so its answer shows that everything has
        arrived.
        """
        if not self._session.is_closed():
            block = zenoh.CongestionControl.BLOCK
            at = key(self.run, "leave", self.process)
            list(self._session.get(at, FifoChannel(1), congestion_control=block, timeout=LEAVE_s))
            self._session.close()  # type: ignore[no-untyped-call]

    def __exit__(self, *_: object) -> None:
        self.close()


class LocalLink(_Sender):
    """Connects a node to a LocalHub in the same process, through the hub's own session.

    Messages are received by callbacks during the sender's put; exceptions of signals would be lost in this foreign
    code, so signals are deferred.
    """

    def __init__(
        self, session: zenoh.Session, run: str, node: str, ready: deque[str], sampled: Callable[[], None]
    ) -> None:
        super().__init__(session, run, LOCAL, node, FIRST_EPOCH)
        self._pending: deque[zenoh.Sample] = deque()
        self._ready, self._sampled = ready, sampled
        self._handler: Callable[[bytes], None] | None = None
        self._inbox = session.declare_subscriber(key(run, "in", LOCAL, node), Callback(self._enqueue, indirect=False))

    def send(self, payload: bytes) -> None:
        """Send a protocol message to the coordinator."""
        with whole():
            super().send(payload)

    def sample(self, payload: bytes) -> None:
        """Send a batch of samples to the coordinator, which handles the batch before this call returns."""
        with whole():
            super().sample(payload)
        self._sampled()

    def _enqueue(self, sample: zenoh.Sample) -> None:
        self._pending.append(sample)
        self._ready.append(self.node)

    def serve(self, handler: Callable[[bytes], None]) -> None:
        """Set the function that handles the messages to this node; exceptions that it raises reach the caller of the
        hub."""
        self._handler = handler

    def dispatch(self) -> bool:
        """Handle one message that waits for this node; return False if there is none."""
        if self._handler is None or not self._pending:
            return False
        self._handler(self.receive())
        return True

    def receive(self) -> bytes:
        """Return the coordinator's next message; raises ProtocolError if no message has been sent to this node."""
        if not self._pending:
            raise ProtocolError(
                f"node {self.node} waits for a message that nobody in this process has sent; send it before receiving"
            )
        return self.open(self._pending.popleft().payload.to_bytes())

    def close(self) -> None:
        """Leave the run: end the connection of this node to the hub."""
        self._handler = None
        for publisher in (self._out, self._samples):
            publisher.undeclare()  # type: ignore[no-untyped-call]
