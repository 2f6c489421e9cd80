"""A hub whose processes may be lost: each is replaced and brought to the same point, and the run continues unchanged.

    1  A process is lost: it has ended, or has left, or makes no progress (os_limits.py).
    2  It is killed and reaped, so that it cannot wake up beside its replacement; on another host, where that cannot
       be verified, messages with its old epoch are refused.
    3  The replacement gets all messages of each of its nodes again (incarnation.py) and must answer with the same
       bytes.  If it does not, the run ends: a model is not deterministic.
    4  Then it gets the message that its predecessor had not answered, and only this answer is passed on.
Samples that were sent before are dropped by their count.  Three losses of a process at one point end the run, and so
does a model that fails, as it would fail again.  Every few seconds of work a node is asked for a checkpoint.
"""

import time
from collections.abc import Callable, Iterable

import msgspec
from heavylift.coordinator.hosts.listener import RemoteListener
from heavylift.coordinator.protocol import messages as m
from heavylift.coordinator.protocol.distance import together
from heavylift.coordinator.transport.hub import Hub, REMOTE_s
from heavylift.coordinator.transport.link import JOIN_s
from heavylift.coordinator.transport.placement import Placement
from heavylift.kernel.errors import UNREADABLE, ProtocolError

from .incarnation import Life, ReplayLog, nondeterminism
from .journal import TicketFile
from .os_limits import StallDetector
from .processes import KEEPER, GRACE_s, Processes

DEADLINE_s = 60.0  # for an answer, before a process is probed
LOSSES = 3  # of one process at one point of the run
POLL_s = 0.05  # between two looks at the clock
SHARE, MOST_s = 20.0, 1.0  # times what a look took are added to that, at most so much
KEEP_s = 5.0  # wall time between two checkpoints of a node
KEEP_GRANTS = 64  # and at least so many grants


class Succession(Hub):
    """Hub that replaces each lost process by a new one, to which it repeats all earlier messages of the run."""

    def __init__(
        self,
        nodes: Iterable[str] | Placement,
        crew: Processes,
        listener: RemoteListener | None = None,
        deadline: float = DEADLINE_s,
    ) -> None:
        super().__init__(nodes, listener, crew.directory)
        self._crew, self._deadline = crew, deadline
        folder = self.directory.path
        self._lives = {node: Life(ReplayLog(folder / f"{node}.journal")) for node in self.nodes}
        self._stalls = StallDetector(deadline, crew, self._alive, lambda sentence: self.tell(sentence))
        self._begun = dict.fromkeys(self.placement.processes, time.monotonic())
        self._tickets = {process: TicketFile(process) for process in sorted(self.placement.external)}
        self._next_check = 0.0
        self._held: list[tuple[str, bytes]] = []

    # ---- what the conversation sees -----------------------------------------------------------------------------

    def send(self, node: str, payload: bytes) -> None:
        """Send a protocol message to a node, at once or when its process is ready."""
        life = self._lives[node]
        life.log.sent(payload)
        if life.ready:
            self._report(node, life, payload)

    def receive(self, timeout: float | None = None) -> tuple[str, bytes] | None:
        """Wait for the next message and return (node, message); return None after `timeout` [s] (None: wait without a
        limit)."""
        while True:
            self._look()
            got = super().receive(timeout)
            if got is None or self._take(*got):
                return got

    def samples(self) -> list[tuple[str, bytes]]:
        """Return all (node, batch) pairs received since the last call, each once, in order for each node."""
        if not self._held and not self._batches:
            return []
        held, self._held = self._held, []
        return held + self._fresh()

    def admit(self, scene: str, say: Callable[[str], None]) -> None:
        """Let processes join that users start themselves."""
        super().admit(scene, say)
        for process in self._tickets:
            self._begun[process] = time.monotonic()
            self._invite(process, say)

    def invitation(self, process: str) -> str:
        """Return a sentence that tells the user how to start an external process: where its ticket is, and how long the
        run waits."""
        if process not in self._tickets:
            return super().invitation(process)
        return f"its ticket is {self._tickets[process].path}, good for {self._deadline:g} s"

    def close(self) -> None:
        """End the session and remove the run's directory with its logs."""
        for ticket in self._tickets.values():
            ticket.remove()
        for life in self._lives.values():
            life.log.close()
        super().close()

    def __exit__(self, kind: object, error: BaseException | None, trace: object) -> None:
        self._crew.stop(GRACE_s if error is None else 0.0)
        super().__exit__(kind, error, trace)

    # ---- what nodes are told and say ----------------------------------------------------------------------------

    def _report(self, node: str, life: Life, payload: bytes) -> None:
        if payload == life.log.welcome:
            welcome = m.decode(payload)
            assert isinstance(welcome, m.Welcome), "every story begins with it"
            epoch = self.epoch(self.placement.process_of[node])
            payload = m.encode(msgspec.structs.replace(welcome, epoch=epoch))
        life.asked, life.since = payload, time.monotonic()
        super().send(node, payload)

    def _take(self, node: str, payload: bytes) -> bool:
        """Handle a message of supervision or replay; return True if the conversation must handle the message."""
        life, kind = self._lives[node], m.kind(payload)
        if life.over:
            return False  # the BYE of a successor that had nothing to do
        if kind == "checkpoint":
            return self._keep(node, life, payload)
        if life.outdated(payload):
            return False
        life.asked = b""
        if not life.ready:
            if payload != life.expected:
                raise nondeterminism(self.placement.nodes[node], life.expected, payload, life.reached)
            life.heard = payload
            self._go_on(node, life)
            return False
        life.log.answered(payload)
        life.losses.clear()
        if kind == "done":
            self._ask_for_checkpoint(node, life)
        elif kind in ("bye", "fail"):
            life.over = True
            process = self.placement.process_of[node]
            if all(self._lives[other].over for other in self.placement.hosted[process]):
                self.excuse(process)
        return True

    def _fresh(self) -> list[tuple[str, bytes]]:
        found = []
        for node, batch in super().samples():
            life = self._lives[node]
            life.batch += 1
            if life.batch > life.batches:
                life.batches = life.batch
                found.append((node, batch))
        return found

    # ---- checkpoints --------------------------------------------------------------------------------------------

    def _ask_for_checkpoint(self, node: str, life: Life) -> None:
        life.grants += 1
        if life.grants >= KEEP_GRANTS and time.monotonic() - life.kept_at > KEEP_s:
            self.keep(node, m.encode(m.Checkpoint(0)))

    def keep(self, node: str, request: bytes) -> None:
        """Request a checkpoint from a node if the node is ready and supports checkpoints."""
        life = self._lives[node]
        if life.ready and life.keeps and not life.over:
            life.grants, life.kept_at = 0, time.monotonic()
            super().keep(node, request)

    def _keep(self, node: str, life: Life, payload: bytes) -> bool:
        """Store a checkpoint; return whether the conversation also receives the checkpoint."""
        checkpoint = m.decode(payload)
        assert isinstance(checkpoint, m.Checkpoint), "its kind says so"
        if not checkpoint.state:
            life.keeps = False
            who = f"node {together(self.placement.nodes[node])}"
            self.tell(f"{who} would be replayed from the start if it were lost: {checkpoint.why}")
            return False
        self._held += self._fresh()
        life.log.kept(payload)
        life.kept_batch = life.batches
        return True

    # ---- losses -------------------------------------------------------------------------------------------------

    def on_join(self, process: str) -> None:
        """Begin the replay for the nodes of a process that has just joined."""
        for node in self.placement.hosted[process]:
            life = self._lives[node]
            if life.over:
                super().send(node, life.log.last)
            else:
                life.telling = life.log.retell()
                self._go_on(node, life)

    def _go_on(self, node: str, life: Life) -> None:
        """Send the next message of a node's replay; after the last one, the unanswered message."""
        part = next(life.telling, None)
        if part is not None:
            message, life.expected = part
            return self._report(node, life, message)
        life.ready = True
        if life.log.open:
            self._report(node, life, life.log.last)
        else:
            life.losses.clear()

    def on_loss(self, process: str, how: str) -> None:
        """Replace a lost process; raises ProtocolError after too many losses without progress of its nodes."""
        nodes = self.placement.hosted[process]
        lives = [life for node in nodes if not (life := self._lives[node]).over]
        if not lives:
            return  # it has left in order, and that is seen only now
        for life in lives:
            life.losses.append(how)
        if any(len(life.losses) >= LOSSES for life in lives):
            raise self.gone(process, f"{how}; {LOSSES} successive processes were lost at the same point of the run")
        self._held += self._fresh()
        self.tell(f"{self.loss(process, 'replaced')}: {how}")
        awaited = process in self.placement.awaited
        if not awaited:
            self._crew.kill(process, self._check_keeper)
        self.renew(process)
        for life in lives:
            life.begin_again()
        self._begun[process] = time.monotonic()
        if awaited:
            self._invite(process, self.tell)
        else:
            self._crew.begin(process)

    def _invite(self, process: str, say: Callable[[str], None]) -> None:
        if process in self._tickets:
            self._tickets[process].write(self.ticket(process))
        say(f"waiting for process {process}; {self.invitation(process)}")

    def _look(self) -> None:
        """Check from time to time whether answers are overdue."""
        now = time.monotonic()
        if now < self._next_check:
            return
        self._next_check = now + POLL_s
        self._check_keeper()
        self._check_processes(now)
        self._next_check += min(MOST_s, SHARE * (time.monotonic() - now))

    def _check_processes(self, now: float) -> None:
        for process, nodes in self.placement.hosted.items():
            if not self.joined(process):
                remote, external = (process in some for some in (self.placement.remote, self.placement.external))
                patience = REMOTE_s if remote else self._deadline if external else max(self._deadline, JOIN_s)
                if now - self._begun[process] > patience:
                    if external:
                        raise ProtocolError(
                            f"process {process}: nobody has joined with {self._tickets[process].path} within "
                            f"{patience:g} s; start its program while the run waits, or let it wait longer (--deadline)"
                        )
                    self.on_loss(process, f"it did not join within {patience:g} s")
                elif not (remote or external) and (how := self._stalls.lost(process, self._begun[process], now)):
                    self.on_loss(process, how)
                continue
            owing = [(node, life) for node in nodes if (life := self._lives[node]).asked and not life.over]
            if not owing:
                continue
            how = self._stalls.lost(process, min(life.since for _, life in owing), now)
            if how:
                self.on_loss(process, how)
            elif how is not None:
                self._repeat(owing)

    def _check_keeper(self) -> None:
        """Supervise the process manager like any other process: orders that it has not executed count as unanswered."""
        since = self._crew.owed_since
        if since is not None and (how := self._stalls.lost(KEEPER, since, time.monotonic())):
            self._crew.give_up(how)

    def _repeat(self, owing: list[tuple[str, Life]]) -> None:
        """Repeat unanswered messages; a node that has answered repeats its answer."""
        for node, life in owing:
            if not life.repeated and m.kind(life.asked) == "grant":
                life.repeated = True
                super().send(node, life.asked)

    def _alive(self, process: str) -> m.Alive | None:
        now = time.monotonic()
        if process == KEEPER or not self.joined(process):  # it cannot be asked: it may still import what it needs
            since = self._crew.owed_since if process == KEEPER else self._begun[process]
            waited = now - (now if since is None else since)
            return m.Alive(int(waited * 1e9)) if waited < max(self._deadline, JOIN_s) else None
        try:
            return msgspec.msgpack.decode(self.ask(process) or b"", type=m.Alive)
        except UNREADABLE:  # nothing, or nothing that it could say
            return None
