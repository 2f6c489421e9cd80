"""Messages with the nodes of one run, whatever they model, and the start of their processes.

    WELCOME(config) -> HELLO(declaration) of every node -> rounds of GRANT and DONE -> STOP -> BYE

Uses the hub, the protocol's core and a recorder, but nothing of scenes: the caller gives each node its config, checks
the declarations, and decides when the run is over. `watch` is notified of committed events and of the time reached.
"""

import time
from collections.abc import Collection, Iterable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import TYPE_CHECKING

from heavylift.coordinator.hosts.listener import RemoteListener
from heavylift.coordinator.live.command_queue import CommandQueue
from heavylift.coordinator.live.observers import EventPublisher
from heavylift.coordinator.live.pace import Tempo
from heavylift.coordinator.participants import NODE_MODULE, PRELOAD
from heavylift.coordinator.participants.configuration import Wiring
from heavylift.coordinator.participants.external import External
from heavylift.coordinator.participants.participant import Participant
from heavylift.coordinator.protocol import messages as m
from heavylift.coordinator.protocol.messages import RunEnd
from heavylift.coordinator.protocol.node import kept
from heavylift.coordinator.protocol.outside import OpenCoordinator
from heavylift.coordinator.record.run_record import RunRecorder
from heavylift.coordinator.stopping import whole
from heavylift.coordinator.supervision.failover import DEADLINE_s, Succession
from heavylift.coordinator.supervision.processes import Processes
from heavylift.coordinator.transport.exchange import LocalHub
from heavylift.coordinator.transport.hub import Hub
from heavylift.coordinator.transport.placement import Placement
from heavylift.kernel.errors import ProtocolError, RecordingError, Stopped
from heavylift.kernel.version import __version__
from heavylift.nodes.devs import Event, Tag
from heavylift.nodes.devs.execution.rules import LIMIT

from .watch import RunObserver

if TYPE_CHECKING:
    from heavylift.coordinator.participants.recorded_kernel import RecordedKernel

POLL_s = 0.2  # how often samples are taken while a node works
KEEP_s = 5.0  # wall time between two checkpoints on record


@contextmanager
def joined(
    placement: Placement,
    in_process: bool,
    processes: Processes | None = None,
    listener: RemoteListener | None = None,
    deadline: float = DEADLINE_s,
    past: "RecordedKernel | None" = None,
    first: str = "",
) -> Iterator[Hub | LocalHub]:
    """Start the nodes of a placement and yield their hub; when the context ends, all processes have ended.

    Processes on other hosts, which connect to the `listener`, and external ones are not started here. A process that
    does not answer for `deadline` [s] is asked for a sign of life. `past`: the recorded history for a kernel in this
    process; `first`: the node whose process is started first.
    """
    if in_process:
        with LocalHub(placement.models) as local:
            for node, models in local.placement.nodes.items():
                link = local.link(node)
                participant = Participant(models, link.send, link.sample, past)
                link.serve(participant.handle)
                local.causes[node] = participant.cause
            yield local
        return
    crew = processes or Processes(PRELOAD)
    with crew, Succession(placement, crew, listener, deadline) as hub:  # the keeper is the last to leave
        here = (p for p in placement.processes if p not in placement.awaited)
        crew.start(hub, {p: (NODE_MODULE,) for p in sorted(here, key=lambda p: first not in placement.processes[p])})
        yield hub


class Conversation:
    """The coordinator's exchange of messages with the nodes of a run.

    Call `welcome` and `hello` for each node, then `play` and `dismiss`; after an error `abort`.
    """

    def __init__(
        self,
        hub: Hub | LocalHub,
        wiring: Wiring,
        end: Tag,
        recorder: RunRecorder,
        watch: RunObserver,
        publisher: EventPublisher | None = None,
        tempo: Tempo | None = None,
        queue: CommandQueue | None = None,
        microsteps: int = LIMIT,
        sampler: str = "",
        marks: Collection[tuple[str, str]] = (),
        externals: Iterable[External] = (),
    ) -> None:
        """`end`: time bound; `sampler`: the node that publishes samples; its checkpoints are recorded every few seconds
        and before events on the ports `marks`; `queue` receives orders, which may change the `tempo`."""
        self._hub, self._recorder, self._watch, self._publisher = hub, recorder, watch, publisher
        self._tempo, self._queue = tempo or Tempo(), queue
        nodes = hub.placement.nodes
        wires, outside, finish, _ = wiring
        self.core = OpenCoordinator(nodes, wires, end, finish, self._event, outside, microsteps, nodes)
        self.now = Tag(0)
        """Tag of the last event, or time of the last sample."""
        self.grants = self._noted = 0
        self._begun = False  # before, samples wait until it is known what they are
        self._sampler, self._marks = sampler, set(marks)
        self._due, self._kept_at = list[Tag](), time.monotonic()  # marks that the sampler has not passed
        self.externals = {external.node: external for external in externals}
        """External nodes by name: nodes that programs other than heavylift run."""
        self._agreed = dict[str, str]()  # by node, the fingerprint of what it is
        if isinstance(hub, Hub):
            hub.when = lambda: f"t = {self.now.t * 1e-9:.3f} s"
            hub.tell = self._tell
            hub.eager = True
        else:
            hub.sampled = self._take_samples

    def written_to(self, wanted: str | Path | None, given: Path | None) -> None:
        """Report the file name `given` of the recording to the user if the name `wanted` was taken."""
        if given is not None and given != Path(wanted or ""):
            self._watch.say(f"{wanted} exists; writing {given}")

    def welcome(self, node: str, config: bytes, fingerprint: str) -> None:
        """Send a node its WELCOME with its configuration, or with that of the external program that runs it."""
        self._agreed[node] = fingerprint
        self._send(node, m.Welcome(1, self.externals[node].config if node in self.externals else config))

    def hello(self) -> tuple[str, bytes]:
        """Receive the next HELLO; return the node and its declaration. Raises ProtocolError for any other message."""
        node, message = self._receive()
        if not isinstance(message, m.Hello):
            raise ProtocolError(f"{node} sent {type(message).__name__.upper()} where HELLO was expected")
        if node not in self.externals and (message.version, message.scene) != (__version__, self._agreed.get(node)):
            raise ProtocolError(
                f"node {node} runs heavylift {message.version}, the coordinator {__version__}, or they have read "
                "different files; start the run again from a single installation, "
                "and do not change its files during the run"
            )
        self.core.hello(node, message)
        return node, message.declaration

    def play(self) -> RunEnd:
        """Grant time to the nodes, round by round, until no event is left before the end.

        It may be called again after the end was moved to a later time.
        """
        core, tempo, outstanding = self.core, self._tempo, 0
        self._begun = True
        while True:
            if self._queue is not None:
                self._queue.attend(core)
            grants = core.ready(tempo.horizon(core))
            if self._publisher is not None:
                self._publisher.show()
            if grants:
                tempo.granted()
            for name, grant in grants:
                if name == self._sampler:
                    self._keep(grant)
                self._send(name, grant)
                self.grants += 1
            outcome = core.over
            if outcome is not None:
                return outcome
            outstanding += len(grants)
            self._watch.waiting()
            got = self._hear(0.0)
            if got is None:  # who is granted works while samples are recorded
                self._take_samples()
                got = self._hear(min(POLL_s, tempo.rest(core)))
            while got is not None:
                node, message = got
                if not isinstance(message, m.GrantDone):
                    raise ProtocolError(f"{node} sent {type(message).__name__.upper()} where DONE was expected")
                core.done(node, message)
                self._due += [e.tag for e in (*message.spoken, *message.offer) if (e.source, e.port) in self._marks]
                outstanding -= 1
                got = self._hear(0.0) if outstanding else None  # one decision for all that have come meanwhile

    def dismiss(self, end: Tag) -> dict[str, m.Bye]:
        """End the run without an error: send STOP, receive the last samples and the BYE of every node."""
        self._close()
        self._take_samples()
        self._recorder.settle(end.t)
        for node in self._hub.nodes:
            self._send(node, m.StopRun(end))
        left: dict[str, m.Bye] = {}
        while len(left) < len(self._hub.nodes):
            node, message = self._receive()
            if isinstance(message, m.Bye):
                left[node] = message
        self._take_samples()
        self._recorder.slack = [slack for node in sorted(left) for slack in left[node].slack]
        return {node: left[node] for node in self._hub.nodes}

    def abort(self, error: BaseException) -> None:
        """Dismiss the nodes after an error and keep their samples; raises Stopped if a signal was the reason."""
        self._close()
        self._hub.dismiss(m.encode(m.StopRun(self.now, "aborted")))
        with suppress(RecordingError):  # what follows on samples that the error has cut; the error itself is reported
            self._take_samples()
        if isinstance(error, KeyboardInterrupt):
            at = self.now.t * 1e-9
            by = "the user" if str(error) in ("", "SIGINT") else error
            raise Stopped(f"stopped by {by} at {at:.3f} s; the recording is complete up to there") from error

    def _close(self) -> None:
        """Close the queue of orders."""
        if self._queue is not None:
            self._queue.close()

    def _keep(self, grant: m.Grant) -> None:
        """Request a checkpoint of the sampler before this GRANT, if one is due."""
        passed = [tag for tag in self._due if tag < grant.until]
        if grant.gseq > 1 and (passed or time.monotonic() - self._kept_at > KEEP_s):
            self._due = [tag for tag in self._due if tag >= grant.until]
            self._kept_at = time.monotonic()
            self._hub.keep(self._sampler, m.encode(m.Checkpoint(0)))

    def _send(self, node: str, message: m.AnyMessage) -> None:
        data = m.encode(message)
        held = self.core.held(node) if isinstance(message, m.Grant) else []
        self._hub.send(node, data)
        self._recorder.protocol(self.now.t, node, "to node", message, data, held)

    def _receive(self) -> tuple[str, m.AnyMessage]:
        while True:
            got = self._hear(POLL_s)
            self._take_samples()
            if got is not None:
                return got

    def _tell(self, sentence: str) -> None:
        self._recorder.note(self.now.t, sentence)
        self._watch.say(sentence)

    def _hear(self, timeout: float) -> tuple[str, m.AnyMessage] | None:
        """Return the next message of a node, with its name; None after `timeout` [s], or if samples came first."""
        got = self._hub.receive(timeout)
        if got is None:
            return None
        node, data = got
        message = self._read(node, data)
        if isinstance(message, m.Checkpoint):
            if node == self._sampler and message.state:
                self._take_samples()
                self._recorder.checkpoint(*kept(message.state))
            return None
        self._recorder.protocol(self.now.t, node, "from node", message, data)
        if isinstance(message, m.Fail):
            self._recorder.failed(message)
            raise self.core.failed(node, message) from self._hub.causes.get(node, lambda: None)()
        return node, message

    def _read(self, node: str, data: bytes) -> m.AnyMessage:
        try:
            message = m.decode(data)
        except ProtocolError as error:
            raise ProtocolError(f"node {node} sent invalid data: {error}") from None
        return self.externals[node].checked(message) if node in self.externals else message

    def _event(self, event: Event) -> None:
        if (event.t, event.k) > self.now:
            self.now = event.tag
        self._recorder.event(event)
        if self._publisher is not None:
            self._publisher.event(event)
        if self._queue is not None:
            self._queue.event(event)
        self._tempo.event()
        self._watch.event(event)

    def _take_samples(self) -> None:
        before = self.now
        with whole():  # what the hub has handed over is nowhere else
            for node, batch in self._hub.samples() if self._begun else ():
                reached = self._recorder.samples(node, batch)
                self.now = max(self.now, Tag(reached))
                if node == self._sampler:
                    self.core.working(node, reached)
        if self.now > before:
            self._watch.progress(self.now.t)
        self._recorder.settle(self.core.floor.t)
        for sentence in self._recorder.notes[self._noted :]:
            self._noted += 1
            self._watch.say(sentence)
        if self._publisher is not None:
            self._publisher.last_ns = self.now.t
