"""What a simulator did: a trace that is whole and yet costs little, and a log that is reported at once.

A run is determined by who was due at each tag and which messages were sent: these few lists are kept, and the
transitions are made from them by the routes when somebody reads.

Lookahead L of a port [ns]: after a transition at t, no output that was not already scheduled leaves by it before
t + L. The conservative bounds of Chandy and Misra live on it, so a broken promise ends a run by name; the longest
promise that would have held (`Slack`) is what a user tunes it with.
"""

from collections.abc import Callable, Iterable, Iterator, Sequence
from typing import Any, NamedTuple, Never

from heavylift.kernel.errors import ModelError
from heavylift.nodes.devs.events import NEVER, Instant, Slack, Tag, after
from heavylift.nodes.devs.messages import Message
from heavylift.nodes.devs.models import Atomic, Model, Present
from heavylift.nodes.devs.ports import OutPort, Owner, Port, travelling

from .rules import Witness, fail


class Transition(NamedTuple):
    """A transition of an atomic at a tag, with received and sent messages as (port, message)."""

    tag: Tag
    path: str
    kind: str  # "internal", "external" or "confluent"
    bag: tuple[tuple[str, Message], ...]
    sent: tuple[tuple[str, Message], ...]


class Trace:
    """Stores all transitions of `Simulator(model, trace=Trace())`; iterate over it in order."""

    def __init__(self) -> None:
        self._lines: list[Transition] = []
        self._atomics: list[Atomic] = []
        # of all tags not settled yet, end to end; lists of lists would keep the garbage collector busy
        self._sizes: list[int] = []  # t, k, number of those due, number of messages
        self._due: list[int] = []
        self._sources: list[Port[Message]] = []
        self._values: list[Message] = []

    def note(
        self,
        tag: Instant,
        atomics: list[Atomic],
        imminent: list[int],
        sources: Sequence[Port[Message]],
        values: Sequence[Message],
    ) -> None:
        """Record a tag: imminent atomics and delivered messages."""
        self._atomics = atomics
        self._sizes += (*tag, len(imminent), len(values))
        self._due += imminent
        self._sources += sources
        self._values += values

    def settle(self) -> None:
        """Build the stored transitions; called before routes change."""
        sizes, due, text = iter(self._sizes), 0, 0
        for t, k, n_due, n_said in zip(sizes, sizes, sizes, sizes, strict=True):
            imminent, now = self._due[due : due + n_due], slice(text, text + n_said)
            self._lines += _transitions((t, k), self._atomics, imminent, self._sources[now], self._values[now])
            due, text = due + n_due, text + n_said
        self._sizes, self._due, self._sources, self._values = [], [], [], []

    def __iter__(self) -> Iterator[Transition]:
        self.settle()
        return iter(self._lines)

    def __len__(self) -> int:
        self.settle()
        return len(self._lines)


class TransitionLog(Trace):
    """Calls a function with each transition at the end of its tag."""

    def __init__(self, tell: Callable[[Transition], None]) -> None:
        super().__init__()
        self._tell = tell

    def note(self, *instant: Any) -> None:
        """Record a tag and pass it on."""
        for line in _transitions(*instant):
            self._tell(line)


def _transitions(
    tag: Instant,
    atomics: list[Atomic],
    imminent: list[int],
    sources: Sequence[Port[Message]],
    values: Sequence[Message],
) -> list[Transition]:
    """Return the transitions of one tag in path order."""
    text: dict[Owner, list[tuple[str, Message]]] = {}
    heard: dict[int, list[tuple[int, str, Message]]] = {}
    for source, value in zip(sources, values, strict=True):
        if isinstance(source, OutPort):
            text.setdefault(source.owner, []).append((source.name, value))
        for m, port, place in source.routes:
            heard.setdefault(m._index, []).append((place, port.name, value))
    due = set(imminent)
    lines = []
    for i in sorted(due | heard.keys()):
        bag = sorted(heard.get(i, ()), key=lambda entry: entry[0])
        kind = "external" if i not in due else "confluent" if bag else "internal"
        m = atomics[i]
        received = tuple((port, value) for _, port, value in bag)
        lines.append(Transition(Tag(*tag), m.path, kind, received, tuple(text.get(m, ()))))
    return lines


def outs(m: Model) -> list[OutPort[Never]]:
    """Return the out ports of a model."""
    return [port for port in m.ports.values() if isinstance(port, OutPort)]


def leaving(sources: Iterable[Port[Message]]) -> bool:
    """Return whether an event on one of these ports leaves the node."""
    for port in sources:  # noqa: SIM110 (`any` with a generator takes three times as long)
        if isinstance(port, OutPort) and port.exits:
            return True
    return False


def speakers(atomics: Iterable[Atomic]) -> list[tuple[Atomic, int]]:
    """Return the atomics whose events leave the node, each with the least lookahead of its ports [ns]."""
    found = ((m, [port.lookahead for port in outs(m) if port.exits]) for m in atomics)
    return [(m, min(aheads)) for m, aheads in found if aheads]


class Border:
    """Out ports of root models and the atomics that feed them, for an unchanged model structure."""

    def __init__(self, roots: Iterable[Model], atomics: Iterable[Atomic]) -> None:
        ports = [port for m in atomics for port in outs(m)]
        # checks of promises cost time: only where a port has made one
        self.promises = any(port.lookahead for port in ports)
        """Whether there is one to keep."""
        self.noted = any(port.inner for port in ports)
        """Whether something is said that does not leave and yet is put on record."""
        self._speakers = speakers(atomics)
        self.spoken = bool(self._speakers) or self.noted
        self._least = min((ahead for _, ahead in self._speakers), default=NEVER)
        self._promised = {port: NEVER for root in roots for port in outs(root)}
        # a port of a coupled model promises no more than the least of the atomics behind it
        for port in ports:
            for exit, _ in (*port.exits, *port.inner):
                self._promised[exit] = min(self._promised[exit], port.lookahead)
        self.lookahead = {f"{port.owner.name}.{port.name}": ahead for port, ahead in self._promised.items()}
        """Of each out port "model.port" the smallest of the atomics' ports that lead there; NEVER without one [ns]."""

    def quiet(self, tag: Tag) -> Tag:
        """Return the earliest tag at which an event can leave after `tag`, at which none does."""
        # nothing leaves at `tag`: by lookahead, or the next tag at which an atomic with outgoing ports is due
        soonest, t = after(tag, self._least), tag.t
        if soonest.t == t:
            return soonest
        return min(soonest, Tag(min((m._t for m, _ in self._speakers if m._t > t), default=NEVER)))

    def still_promises(self, at: Tag, before: "Border") -> None:
        """Raise ModelError for a change of structure that reduces a promised lookahead."""
        for port, ahead in before._promised.items():
            now = self._promised[port]
            if now < ahead:
                was = f"{ahead} ns" if ahead < NEVER else "that of a port by which nothing leaves"
                raise ModelError(
                    f"{port.owner.path} at {at}: the lookahead of port {port.name} falls from {was} to {now} ns, but "
                    "others rely on it; give what is added no less lookahead"
                )


def keep_promises(tag: Instant, sources: Sequence[Port[Message]]) -> None:
    """Raise ModelError for an output sent earlier than its port's lookahead allows, counted from the transition that
    scheduled it."""
    for port in sources:
        if isinstance(port, OutPort) and port.lookahead and isinstance(m := port.owner, Atomic):
            # counted from the transition that scheduled the output: what had been scheduled before bounds nothing
            since = tag[0] - m._set
            if since < port.lookahead:
                raise ModelError(
                    f"{m.path} at {Tag(*tag)}: port {port.name} promises a lookahead of {port.lookahead} ns and speaks "
                    f"{since} ns after the transition that scheduled it; hold for longer or declare less"
                )


Said = tuple[Instant, Sequence[Port[Message]], Sequence[Message]]  # when, by which ports, what


class Observed:
    """Observed lookaheads of all ports with events to other nodes."""

    def __init__(self) -> None:
        self._ports: dict[OutPort[Never], list[int]] = {}  # least wait [ns], and how often it has spoken
        self._among: list[Said] = []

    def among(self) -> list[Said]:
        """Return the outputs since the last call that may have no receiver in another node."""
        noted, self._among = self._among, []
        return noted

    def note(
        self, tag: Instant, sources: Sequence[Port[Message]], values: Sequence[Message], noted: bool = False
    ) -> None:
        """Record the outputs at a tag; those scheduled before the start do not count as observed lookahead."""
        t = tag[0]
        if noted:
            self._among.append((tag, sources, values))
        for port in sources:
            m = port.owner
            # an output scheduled before the start of observation gives no bound
            if isinstance(port, OutPort) and (port.exits or port.inner) and isinstance(m, Atomic) and m._set >= 0:
                waited, known = t - m._set, self._ports.get(port)
                if known is None:
                    self._ports[port] = [waited, 1]
                else:
                    known[0], known[1] = min(waited, known[0]), known[1] + 1

    def table(self) -> list[Slack]:
        """Return the observed lookaheads in the order of paths and ports."""
        ports = sorted(self._ports, key=lambda port: (port.owner.path, port.name))
        return [Slack(f"{port!r}", port.lookahead, *self._ports[port]) for port in ports]


def speak(
    tag: Instant, imminent: list[int], atomics: Sequence[Atomic], present: Present, witness: Witness, promises: bool
) -> None:
    """Call the output functions of imminent atomics and store the messages in `present`. Raises ModelError for an
    atomic that changes its state or violates its lookahead."""
    present.now, present.sources, present.values = tag, [], []
    witness.left -= 1
    # now and then at random intervals, and always for new atomics: comparing states costs more than the transitions
    examined = witness.left < 0 or (witness.new and not witness.new.isdisjoint(imminent))
    seen = witness.before(imminent) if examined else None
    try:
        for i in imminent:
            present.speaker = m = atomics[i]
            try:
                m.output()
            except BaseException as error:
                fail(m, tag, "output", error)
            # a call of hold_in in output() would change the schedule
            if m._wait is not None:
                message = "output() must not change the state: call hold_in in a transition"
                fail(m, tag, "output", ModelError(message))
    finally:
        present.speaker = None
    if seen:
        witness.after(tag, seen)
    if promises:
        keep_promises(tag, present.sources)


def results_of(atomics: Iterable[Atomic], present: Present, tag: Tag) -> dict[str, Message]:
    """Return results by model path, omitting models without one; meanwhile `now` of the models is `tag`."""
    before, present.now = present.now, tag
    found: dict[str, Message] = {}
    for m in atomics:
        try:
            result = m.result()
            if m._wait is not None or present.changes:
                raise ModelError("result() must not change the model: do that in a transition")
            if result is not None:
                found[m.path] = travelling(_checked(result), "its result")
        except BaseException as error:
            m._wait, present.changes = None, []
            fail(m, tag, "result", error)
    present.now = before
    return found


def _checked(result: object) -> Message:
    if not isinstance(result, Message):
        raise ModelError(f"result() returned {type(result).__name__} {result!r:.60}; it must return a Message or None")
    return result
