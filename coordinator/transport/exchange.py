"""Common part of the hubs for nodes in other processes and in this one: messages, samples, events for observers.

One publisher and two readers per node check that all its messages are complete, in order, of this run and of the
present incarnation. Messages of an earlier incarnation are dropped, anything else wrong raises a ProtocolError.

Also the coordinator's end of a run whose nodes live in its own process; see `hub` for the contract.
"""

from collections import deque
from collections.abc import Callable, Iterable, Mapping
from typing import Any, Self

import zenoh
from heavylift.coordinator.stopping import whole
from heavylift.kernel.errors import ProtocolError
from zenoh.handlers import Callback

from .frame import FIRST_EPOCH, FrameReader, FrameTopic, Writer, check_names, key
from .link import LOCAL, LocalLink, matched
from .placement import Placement
from .session import local_session, new_run_id


class Exchange:
    """The coordinator's end of a session with its nodes; base class of the hubs."""

    def __init__(self, session: zenoh.Session, run: str, placement: Placement) -> None:
        block = zenoh.CongestionControl.BLOCK
        self.run, self.nodes, self.placement = run, tuple(placement.nodes), placement
        at = {node: (process, node) for node, process in placement.process_of.items()}
        self.when: Callable[[], str] = lambda: ""
        """Returns the simulation time for messages, such as "t = 12.5 s"; replaced by the conversation of a run."""
        self.tell: Callable[[str], None] = lambda sentence: None
        """Receives messages about survived losses of processes and about possible ones."""
        self.causes: dict[str, Callable[[], BaseException | None]] = {}
        """For each node in this process, a function that returns the exception of its model, if the node failed."""
        self._session = session
        self._publishers = {
            n: session.declare_publisher(key(run, "in", *at[n]), congestion_control=block) for n in self.nodes
        }
        self._writers = {n: Writer(run, n, FrameTopic.IN, FIRST_EPOCH) for n in self.nodes}
        self._out = {key(run, "out", *at[n]): (n, FrameReader(run, n, FrameTopic.OUT, FIRST_EPOCH)) for n in self.nodes}
        self._data = {
            key(run, "samples", *at[n]): (n, FrameReader(run, n, FrameTopic.SAMPLES, FIRST_EPOCH)) for n in self.nodes
        }
        self._batches: deque[zenoh.Sample] = deque()
        self._shown: dict[tuple[str, ...], _Shown] = {}
        keep = Callback(self._arrived, indirect=False)
        self._data_subscriber = session.declare_subscriber(key(run, "samples", "*", "*"), keep)

    def send(self, node: str, payload: bytes) -> None:
        """Send a protocol message to a node."""
        self._publishers[node].put(self._writers[node].frame(payload))

    def keep(self, node: str, request: bytes) -> None:
        """Request a checkpoint from a node; the answer arrives through `receive` like any other message."""
        Exchange.send(self, node, request)

    def _arrived(self, sample: zenoh.Sample) -> None:
        """Queue a batch of samples; called by a thread of the bus or of the sender."""
        self._batches.append(sample)

    def samples(self) -> list[tuple[str, bytes]]:
        """Return all (node, batch) pairs received since the last call, in order for each node."""
        if not self._batches:
            return []
        come = (self._batches.popleft() for _ in range(len(self._batches)))
        found = (self._open(str(sample.key_expr), sample, self._data) for sample in come)
        return [batch for batch in found if batch is not None]

    def publish_event(
        self, path: str, port: str, payload: bytes, type: str = "", t_ns: int = 0, k: int = 0, index: int = 0
    ) -> None:
        """Publish a committed event to observers (key event/<model path>/<port>); a slow observer misses some."""
        self._shown_at("event", path, port).put(payload, f"application/msgpack;{type}", t_ns, k, index)

    def heard_data(self, topic: str) -> bool:
        """Return whether observers subscribe to this topic of sample data."""
        return self._shown_at("sample", topic).heard

    def publish_data(self, topic: str, payload: bytes, schema: str = "", t_ns: int = 0) -> None:
        """Publish data of a topic to observers (key sample/<topic>); a slow observer misses some."""
        self._shown_at("sample", topic).put(payload, f"application/protobuf;{schema}", t_ns)

    def _shown_at(self, *chunks: str) -> "_Shown":
        if chunks not in self._shown:
            self._shown[chunks] = _Shown(self._session, key(self.run, *chunks))
        return self._shown[chunks]

    def _open(
        self, at: str, sample: zenoh.Sample, readers: Mapping[str, tuple[str, FrameReader]]
    ) -> tuple[str, bytes] | None:
        """Return node and payload of a message on the key `at`; None for a message of an earlier incarnation."""
        if at not in readers:
            raise ProtocolError(
                f"run {self.run}: a message arrived on {at}, but this run has no such node "
                f"({', '.join(self.nodes)}); end the process that sent it"
            )
        node, reader = readers[at]
        data = sample.payload.to_bytes()
        try:
            return node, reader.open(data)
        except ProtocolError:
            if reader.outdated(data):
                return None
            raise

    def dismiss(self, payload: bytes) -> None:
        """Send every node its last message; nodes may leave from then on."""
        for node in self.nodes:
            self.send(node, payload)

    def close(self) -> None:
        """End the session."""  # with publishers it stays in memory for ever; who does not read holds their end up
        alone = not self._session.is_closed() and not self._session.info.links()
        while alone and self._shown:
            self._shown.popitem()[1].close()
        while alone and self._publishers:
            self._publishers.popitem()[1].undeclare()  # type: ignore[no-untyped-call]
        self._session.close()  # type: ignore[no-untyped-call]

    def __enter__(self) -> Self:
        return self

    def __exit__(self, kind: object, error: BaseException | None, trace: object) -> None:
        self.close()


class _Shown:
    """Publisher of one key for observers; sends nothing without subscribers, as publishing costs as much as the rest of
    an event.

    Its encoding names the schema after a semicolon, and a JSON object is attached: {"t_ns", "k", "index", "s"}.
    """

    def __init__(self, session: zenoh.Session, at: str) -> None:
        self.publisher = session.declare_publisher(at, congestion_control=zenoh.CongestionControl.DROP)
        self._listener: Any = self.publisher.declare_matching_listener(Callback(self._turn, indirect=False))
        self.heard = matched(self.publisher)

    def put(self, payload: bytes, encoding: str, t_ns: int, k: int = 0, index: int = 0) -> None:
        if self.heard:
            at = f'{{"t_ns": {t_ns}, "k": {k}, "index": {index}, "s": {t_ns / 1e9!r}}}'
            self.publisher.put(payload, encoding=encoding, attachment=at)

    def close(self) -> None:
        self._listener.undeclare()
        self.publisher.undeclare()  # type: ignore[no-untyped-call]

    def _turn(self, status: zenoh.MatchingStatus) -> None:
        self.heard = status.matching


class LocalHub(Exchange):
    """Hub of a run in one process, which exchanges messages with its nodes in one thread, without a network.

    Each message is sent through Zenoh and queued by a synchronous callback; `receive` passes the queued messages to the
    nodes' handlers, in the order in which they were sent, until a node answers.
    """

    def __init__(self, models: Iterable[str]) -> None:
        super().__init__(local_session(), new_run_id(), Placement({LOCAL: check_names(models, "node")}))
        self._inbox: deque[zenoh.Sample] = deque()
        keep = Callback(self._inbox.append, indirect=False)
        self._subscriber = self._session.declare_subscriber(key(self.run, "out", "*", "*"), keep)
        self._ready: deque[str] = deque()
        self._links: dict[str, LocalLink] = {}
        self.sampled: Callable[[], None] = lambda: None
        """Called each time a node sends samples, which it does during its work."""

    def link(self, node: str) -> LocalLink:
        """Return the node's end of the connection, created on the first call."""
        if node not in self._links:
            self._links[node] = LocalLink(self._session, self.run, node, self._ready, lambda: self.sampled())
        return self._links[node]

    def send(self, node: str, payload: bytes) -> None:
        """Send a protocol message to a node; when this returns, the message is in the node's queue."""
        with whole():
            super().send(node, payload)

    def receive(self, timeout: float | None = None) -> tuple[str, bytes] | None:
        """Let nodes work until one sends a message; return (node, message), or None if none can and a `timeout` is
        given."""
        while not self._inbox:
            if self._ready:
                self._links[self._ready.popleft()].dispatch()
            elif timeout is not None:
                return None
            else:
                raise ProtocolError(
                    f"run {self.run}: the coordinator waits for a message, but no node of this "
                    "process has a message to answer; send one before receiving"
                )
        sample = self._inbox.popleft()
        got = self._open(str(sample.key_expr), sample, self._out)
        assert got is not None, "nodes of this process have no successors"
        return got

    def close(self) -> None:
        """End the network session of the run."""
        while self._links:
            self._links.popitem()[1].close()
        super().close()
