"""The coordinator's end of a run whose nodes are in other processes; for nodes in this process see `exchange`.

Contract of both: messages of one node arrive in order, each once, each checked; anything else raises a ProtocolError.
`samples` returns all batches that a node sent before the message that `receive` has returned last. If a process is lost
before `dismiss`, `receive` raises, after all messages that it had sent; a subclass replaces it instead (failover.py).
Messages of an earlier incarnation of a process are dropped. A monitoring thread wakes `receive` with a message to the
hub itself (liveness.py).
"""

import time
from collections.abc import Callable, Iterable, Mapping
from contextlib import suppress
from threading import Thread
from typing import Protocol

import zenoh
from heavylift.kernel.errors import ProtocolError
from zenoh.handlers import Callback, FifoChannel

from .exchange import Exchange
from .frame import HUB, OBSERVER, OPERATOR, FrameReader, FrameTopic, RunDirectory, Writer, check_names, key
from .link import FIFO, JOIN_s, matched
from .liveness import LivenessMonitor
from .placement import Placement
from .session import ListenAddress, Ticket, hub_session, new_password, new_run_id

ANSWER_s = 1.0  # in which a process says that it is alive
WAKE = HUB  # in place of a node's name: a message of the hub to itself
REMOTE_s = 600.0  # in which somebody starts a process on another host
ANSWERED_s = 0.5  # in which an answer reaches who has asked
BATCHES = 32  # of samples that may wait before their senders do
FULL_s = 0.5  # for which a batch that has come holds up the next at most
LEAVE_s = 2.0  # in which processes that somebody else has started leave a run that is over


class RemoteGate(Protocol):
    """Interface through which processes on other hosts join; `hosts`: remote process -> host from which it has
    joined."""

    hosts: dict[str, str]

    def free(self, process: str) -> None: ...


class RemoteAddress(ListenAddress, Protocol):
    """Interface of a listener for processes on other hosts: its address, and the gate that admits them."""

    @property
    def seen_from_afar(self) -> str: ...
    def gate(self, hub: "Hub", session: zenoh.Session, scene: str, say: Callable[[str], None]) -> RemoteGate: ...


class Hub(Exchange):
    """Connects the coordinator with node processes through a private unix socket, and with other hosts through a
    listener."""

    def __init__(
        self,
        nodes: Iterable[str] | Placement,
        listener: RemoteAddress | None = None,
        directory: RunDirectory | None = None,
    ) -> None:
        """`nodes`: names, one process each, or a placement; `directory`: the private directory of the run."""
        placement = nodes if isinstance(nodes, Placement) else Placement.apart(check_names(nodes, "node"))
        check_names(placement.models, "node")
        processes = check_names(placement.processes, "process")
        self.directory = directory or RunDirectory.chosen().make()
        local = [process for process in processes if process not in placement.remote]
        self._passwords = {user: new_password() for user in ("coordinator", OBSERVER, OPERATOR, *local)}
        run = new_run_id()
        try:
            session = hub_session(run, self.directory, self._passwords, listener, placement.remote)
            super().__init__(session, run, placement)
        except BaseException:  # Ctrl-C, too
            self.directory.remove()
            raise
        self._listener, self._gate = listener, None  # type: RemoteAddress | None, RemoteGate | None
        self._here = self._session.liveliness().declare_token(key(run, "alive", HUB))
        self.eager = False
        """Whether `receive` returns early when samples have arrived."""
        self._met: set[str] = set()
        self._served = False  # whether a guest has asked something
        self._liveness = LivenessMonitor(processes, self._wake, self.present)
        self._wake_key = key(run, "out", WAKE, WAKE)
        channel: FifoChannel[zenoh.Sample] = FifoChannel(FIFO)
        self._inbox = self._session.declare_subscriber(key(run, "out", "*", "*"), channel)
        tokens = Callback(self._liveness.token, indirect=False)
        self._tokens = self._session.liveliness().declare_subscriber(key(run, "alive", "*", "*"), tokens)
        leave = Callback(self._leave, indirect=False)
        self._leaving = self._session.declare_queryable(key(run, "leave", "*"), leave)
        self._liveness.start()

    def _arrived(self, sample: zenoh.Sample) -> None:
        """Queue a batch of samples; senders wait while many are queued, to bound memory."""
        super()._arrived(sample)
        if self.eager:
            self._liveness.hurry()
        deadline = time.monotonic() + FULL_s
        while len(self._batches) > BATCHES and time.monotonic() < deadline:
            time.sleep(0.001)

    def ticket(self, process: str) -> Ticket:
        """Return the ticket with which a process joins."""
        nodes, epoch = self.placement.hosted[process], self.epoch(process)
        return Ticket(self.run, process, nodes, epoch, self.directory.socket, self._passwords.get(process, ""))

    def admit(self, scene: str, say: Callable[[str], None]) -> None:
        """Admit processes on other hosts to a run of the scene with this fingerprint; `say` receives sentences for the
        user."""
        if self._listener is not None:
            self._gate = self._listener.gate(self, self._session, scene, say)
            for process in sorted(self.placement.remote):
                say(f"waiting for process {process}; {self.invitation(process)}")

    def invitation(self, process: str) -> str:
        """Return a sentence that tells the user how to start a process on another host."""
        assert self._listener is not None, "there is no other way for a remote process"
        at = f"--connect {self._listener.seen_from_afar} --certificates DIRECTORY --run {self.run}"
        return f"on its host type: heavylift node {process} {at}"

    def present(self, process: str) -> bool:
        """Return whether the process of this name is connected."""
        return any(matched(self._publishers[node]) for node in self.placement.hosted[process])

    def send(self, node: str, payload: bytes) -> None:
        """Send a message to a node; the first message waits until the node listens, unless its process is lost."""
        if node in self._met or self._meet(node):
            super().send(node, payload)

    def _meet(self, node: str) -> bool:
        """Wait until a process is connected (its token arrives after its subscription); returns False if it is lost."""
        process = self.placement.process_of[node]
        patience = REMOTE_s if process in self.placement.remote else JOIN_s
        deadline = time.monotonic() + patience
        while not self.joined(process) or not matched(self._publishers[node]):
            if not self.joined(process):
                self._hear()
            elif self._liveness.failure is not None or self._liveness.lost(process):
                return False
            if time.monotonic() > deadline:
                raise ProtocolError(f"node {node} did not join within {patience:g} s; start the run again")
            time.sleep(0.001)
        self._met.add(node)
        return True

    def receive(self, timeout: float | None = None) -> tuple[str, bytes] | None:
        """Wait for the next message and return (node, message); return None after `timeout` [s] (None: wait without a
        limit)."""
        self._liveness.deadline = deadline = None if timeout is None else time.monotonic() + timeout
        while True:
            sample = self._inbox.try_recv()
            if sample is None:
                self._hear()
                if deadline is not None and ((self.eager and self._batches) or time.monotonic() >= deadline):
                    self._liveness.deadline = None
                    return None
                sample = self._inbox.recv()
            at = str(sample.key_expr)
            if at != self._wake_key and (got := self._open(at, sample, self._out)) is not None:
                self._liveness.deadline = None
                return got

    def epoch(self, process: str) -> int:
        """Return the number of the process that now has this name, counted from 1."""
        return self._liveness.epochs[process]

    def joined(self, process: str) -> bool:
        """Return whether the process that now has this name has joined."""
        return process in self._liveness.joined

    def renew(self, process: str) -> None:
        """Prepare for a replacement process of this name: messages of the present one will be dropped."""
        self._liveness.renew(process)
        if self._gate is not None:
            self._gate.free(process)
        epoch = self.epoch(process)
        for node in self.placement.hosted[process]:
            self._met.discard(node)
            self._writers[node] = Writer(self.run, node, FrameTopic.IN, epoch)
            self._out[key(self.run, "out", process, node)] = node, FrameReader(self.run, node, FrameTopic.OUT, epoch)
            self._data[key(self.run, "samples", process, node)] = (
                node,
                FrameReader(self.run, node, FrameTopic.SAMPLES, epoch),
            )

    def ask(self, process: str) -> bytes | None:
        """Ask a process for a sign of life; return its encoded answer, or None if there is none."""
        at = key(self.run, "ask", process, str(self.epoch(process)))
        replies = self._session.get(at, FifoChannel(4), timeout=ANSWER_s)
        return next((reply.ok.payload.to_bytes() for reply in replies if reply.ok is not None), None)

    def _hear(self) -> None:
        """Handle reports of processes that have joined or are lost."""
        news = self._liveness.news
        if self._liveness.failure is not None:
            raise self._liveness.failure
        while news:
            process, epoch, how = known = news.popleft()  # first: what is done about it may hear news itself
            if epoch == self.epoch(process) and how is not None:
                try:
                    self.on_loss(process, how)
                except Exception:
                    news.appendleft(known)  # whoever asks again gets the same answer
                    raise
            elif epoch == self.epoch(process):
                self.on_join(process)

    def on_join(self, process: str) -> None:
        """Called when a process has joined; for subclasses to override."""

    def on_loss(self, process: str, how: str) -> None:
        """Handle the loss of a process; raises ProtocolError, since this hub cannot replace it."""
        raise self.gone(process, how)

    def gone(self, process: str, how: str) -> ProtocolError:
        """Return the error for a lost process."""
        return ProtocolError(f"{self.loss(process, 'gone')}: {how}; start the run again")

    def loss(self, process: str, what: str) -> str:
        """Return the start of an error sentence about a process: its nodes, what happened to them, and when."""
        host = self._gate.hosts.get(process, "") if self._gate else ""
        at = self.when()
        return f"{self.placement.described(process, host)} {what}{' at ' + at if at else ''}"

    def serve(self, topic: str, answer: Callable[[zenoh.Query], None]) -> None:
        """Answer the queries on a topic of the run with `answer`, which is called in a thread of the bus."""

        def heard(query: zenoh.Query) -> None:
            self._served = True
            answer(query)

        handler: Callback[zenoh.Query] = Callback(heard, indirect=False)
        self._queryable = self._session.declare_queryable(key(self.run, topic), handler)

    def supervise(self, deaths: Callable[[], Mapping[str, str]]) -> None:
        """Monitor the processes of the run; `deaths` returns how each process ended, and is called in a thread."""
        self._liveness.supervise(deaths)

    def notice(self) -> None:
        """Make the monitoring thread check the processes at once."""
        self._liveness.notice()

    def excuse(self, process: str) -> None:
        """Let a process leave without counting it as lost."""
        self._liveness.excuse(process)

    def dismiss(self, payload: bytes) -> None:
        """Send the last message to every node that has joined; nodes may leave from then on."""
        self._liveness.excuse(*self.placement.processes)
        for node in self.nodes:
            if matched(self._publishers[node]):
                super().send(node, payload)

    def close(self) -> None:
        """End the session and remove the run's directory."""
        self._liveness.excuse(*self.placement.processes)
        drain = Thread(target=self._drain, daemon=True)
        drain.start()
        deadline = time.monotonic() + LEAVE_s
        while any(self.present(process) for process in self.placement.awaited) and time.monotonic() < deadline:
            time.sleep(0.005)  # they close when all that they have said is here
        deadline = time.monotonic() + ANSWERED_s
        while self._served and self._session.info.links() and time.monotonic() < deadline:
            time.sleep(
                0.005
            )  # who has asked something closes when the answer is there; an earlier end would cut it off
        self._liveness.close()
        super().close()
        drain.join(LEAVE_s)  # a thread that comes out of foreign code while Python ends would abort the process
        self.directory.remove()

    def _drain(self) -> None:
        """Receive and discard remaining messages, as a full inbox would block the end of the session."""
        with suppress(zenoh.ZError):  # the session has ended
            while True:
                self._inbox.recv()

    def _leave(self, query: zenoh.Query) -> None:
        """Acknowledge the end of a process once all its messages have arrived."""
        query.reply(query.key_expr, b"")

    def _wake(self) -> None:
        self._session.put(self._wake_key, b"", congestion_control=zenoh.CongestionControl.BLOCK)
