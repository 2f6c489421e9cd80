"""Records of what a simulator did: a trace of all transitions, which is cheap to store, and a log, which is reported at
once.

A run is determined by the models due at each logical time and the messages sent. The trace stores only these short
lists; the transitions are reconstructed from them and the routes when somebody reads the trace.

Lookahead L of a port [ns]: after a transition at t, the port sends no output before t + L that was not already
scheduled. The conservative bounds of Chandy and Misra depend on this promise, so an output that breaks it ends the run
with an error that names the port; `Slack` reports the longest lookahead that would have held, for users who tune it.
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
    """A transition of an atomic model: logical time, kind, and received and sent messages as pairs (port, message)."""

    tag: Tag
    path: str
    kind: str  # "internal", "external" or "confluent"
    bag: tuple[tuple[str, Message], ...]
    sent: tuple[tuple[str, Message], ...]


class Trace:
    """All transitions of `Simulator(model, trace=Trace())`; iterate over the trace to get them in order."""

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
        """Record the transitions at one logical time by storing the imminent models and the delivered messages."""
        self._atomics = atomics
        self._sizes += (*tag, len(imminent), len(values))
        self._due += imminent
        self._sources += sources
        self._values += values

    def settle(self) -> None:
        """Convert the recorded data to transitions; must be called before the couplings of the model change."""
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
    """A trace that passes each transition to a function as soon as its logical time has been executed."""

    def __init__(self, tell: Callable[[Transition], None]) -> None:
        super().__init__()
        self._tell = tell

    def note(self, *instant: Any) -> None:
        """Pass all transitions at one logical time to the user's function."""
        for line in _transitions(*instant):
            self._tell(line)


def _transitions(
    tag: Instant,
    atomics: list[Atomic],
    imminent: list[int],
    sources: Sequence[Port[Message]],
    values: Sequence[Message],
) -> list[Transition]:
    """Return the transitions of one logical time in the order of the models' paths."""
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
    """Return the output ports of a model."""
    return [port for port in m.ports.values() if isinstance(port, OutPort)]


def leaving(sources: Iterable[Port[Message]]) -> bool:
    """Return whether an event sent from one of these output ports goes to another node."""
    for port in sources:  # noqa: SIM110 (`any` with a generator takes three times as long)
        if isinstance(port, OutPort) and port.exits:
            return True
    return False


def speakers(atomics: Iterable[Atomic]) -> list[tuple[Atomic, int]]:
    """Return the atomic models that send events to other nodes, each with the smallest lookahead of its ports [ns]."""
    found = ((m, [port.lookahead for port in outs(m) if port.exits]) for m in atomics)
    return [(m, min(aheads)) for m, aheads in found if aheads]


class Border:
    """The output ports of root models and the atomic models that feed them; valid until the model structure changes."""

    def __init__(self, roots: Iterable[Model], atomics: Iterable[Atomic]) -> None:
        ports = [port for m in atomics for port in outs(m)]
        # checks of promises cost time: only where a port has made one
        self.promises = any(port.lookahead for port in ports)
        """Whether any port has a lookahead, so that outputs must be checked."""
        self.noted = any(port.inner for port in ports)
        """Whether a port sends messages that stay in this node and are recorded."""
        self._speakers = speakers(atomics)
        self.spoken = bool(self._speakers) or self.noted
        self._least = min((ahead for _, ahead in self._speakers), default=NEVER)
        self._promised = {port: NEVER for root in roots for port in outs(root)}
        # a port of a coupled model promises no more than the least of the atomics behind it
        for port in ports:
            for exit, _ in (*port.exits, *port.inner):
                self._promised[exit] = min(self._promised[exit], port.lookahead)
        self.lookahead = {f"{port.owner.name}.{port.name}": ahead for port, ahead in self._promised.items()}
        """For each out port "model.port", the smallest lookahead [ns] of the atomic models' ports that lead there;
        NEVER if none does."""

    def quiet(self, tag: Tag) -> Tag:
        """Return the earliest logical time after `tag` at which an event can leave the node if no input arrives."""
        # nothing leaves at `tag`: by lookahead, or the next tag at which an atomic with outgoing ports is due
        soonest, t = after(tag, self._least), tag.t
        if soonest.t == t:
            return soonest
        return min(soonest, Tag(min((m._t for m, _ in self._speakers if m._t > t), default=NEVER)))

    def still_promises(self, at: Tag, before: "Border") -> None:
        """Raise ModelError if a change of the model structure has reduced a lookahead on which other nodes rely."""
        for port, ahead in before._promised.items():
            now = self._promised[port]
            if now < ahead:
                was = f"{ahead} ns" if ahead < NEVER else "unlimited, as it sent nothing to other nodes,"
                raise ModelError(
                    f"{port.owner.path} at {at}: the lookahead of port {port.name} drops from {was} to {now} ns, but "
                    "other nodes rely on it; give the added models at least the former lookahead"
                )


def keep_promises(tag: Instant, sources: Sequence[Port[Message]]) -> None:
    """Raise ModelError if an output follows its scheduling transition sooner than its port's lookahead allows."""
    for port in sources:
        if isinstance(port, OutPort) and port.lookahead and isinstance(m := port.owner, Atomic):
            # counted from the transition that scheduled the output: what had been scheduled before bounds nothing
            since = tag[0] - m._set
            if since < port.lookahead:
                raise ModelError(
                    f"{m.path} at {Tag(*tag)}: port {port.name} promises a lookahead of {port.lookahead} ns but sends "
                    f"{since} ns after the transition that scheduled the output; hold for longer or declare less"
                )


Said = tuple[Instant, Sequence[Port[Message]], Sequence[Message]]  # when, by which ports, what


class Observed:
    """The observed lookaheads of all ports that send events to other nodes."""

    def __init__(self) -> None:
        self._ports: dict[OutPort[Never], list[int]] = {}  # least wait [ns], and how often it has spoken
        self._among: list[Said] = []

    def among(self) -> list[Said]:
        """Return the outputs recorded since the last call, including those without a receiver in another node."""
        noted, self._among = self._among, []
        return noted

    def note(
        self, tag: Instant, sources: Sequence[Port[Message]], values: Sequence[Message], noted: bool = False
    ) -> None:
        """Record the outputs sent at a logical time.

        An output scheduled before the recording began does not count for the observed lookahead."""
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
        """Return the observed lookahead of each port, sorted by model path and port."""
        ports = sorted(self._ports, key=lambda port: (port.owner.path, port.name))
        return [Slack(f"{port!r}", port.lookahead, *self._ports[port]) for port in ports]


def speak(
    tag: Instant, imminent: list[int], atomics: Sequence[Atomic], present: Present, witness: Witness, promises: bool
) -> None:
    """Call the output functions of the imminent models and store their messages in `present`.

    Raises ModelError if an output function changes the state or violates a lookahead."""
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
    """Call `result` of each atomic model at the logical time `tag`; return the results that are not None, by path."""
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
