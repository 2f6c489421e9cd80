"""Rules that every HELLO and DONE must satisfy: a violation ends the run with a named error before it can do harm.

`says` (core.py) is the coordinator's previous bound of the node: without input it sends nothing earlier. Cycles of
messages between nodes without time advance are found from the messages of the second half of the allowed microsteps:
traced back from the last one, the first node that is met twice closes the cycle.
"""

from collections import deque
from collections.abc import Callable, Iterable, Sequence
from typing import NamedTuple

from heavylift.kernel.errors import ModelError, ProtocolError
from heavylift.nodes.devs import NEVER, Event, Tag, after
from heavylift.nodes.devs.execution.rules import LONGER

from .distance import Coupling, NodeState
from .messages import GrantDone, Hello


class Before(NamedTuple):
    """The state of a node before its next message, against which this message is checked."""

    node: NodeState
    says: Tag = Tag(0)


def check_hello(node: NodeState, hello: Hello) -> None:
    """Raise a ProtocolError that names the node and the rule if the node's HELLO violates a rule."""
    _check(Before(node), hello)


def check_done(node: NodeState, done: GrantDone, says: Tag) -> None:
    """Raise a ProtocolError that names the node and the rule if the node's DONE violates a rule."""
    if not node.running or done.gseq != node.gseq:
        raise ProtocolError(f"{node.who} sent DONE {done.gseq} out of order; its last GRANT was {node.gseq}")
    _check(Before(node, says), done)


def _check(before: Before, text: Hello | GrantDone) -> None:
    for events in (text.spoken if isinstance(text, GrantDone) else [], text.offer):
        for rule in EVENTS.values() if events else ():
            if message := rule(before, events):
                raise ProtocolError(f"{before.node.who} {message}")
    for row in WHOLE.values():
        if message := row(before, text):
            raise ProtocolError(f"{before.node.who} {message}")


def _own(before: Before, events: Sequence[Event]) -> str:
    for event in events:
        if event.source not in before.node.models:
            return f"sent an event of {event.source}: a node sends events of its own models only"
    return ""


def _port(before: Before, events: Sequence[Event]) -> str:
    ports = before.node.lookahead
    for event in events if ports else ():
        if f"{event.source}.{event.port}" not in ports and event.source in before.node.models:
            known = (port.partition(".") for port in sorted(ports))
            named = ", ".join(name for model, _, name in known if model == event.source)
            return f"sent an event on port {event.port} at {event.tag}: its out ports are {named}"
    return ""


def _order(before: Before, events: Sequence[Event]) -> str:
    last: Event | None = None
    for event in events:
        alone = last is None or event.order[:4] != last.order[:4]
        index = 0 if alone or last is None else last.index + 1
        if event.index != index or (last is not None and not last < event):
            return f"sent events out of order: {event.port} at {event.tag}, number {event.index}"
        last = event
    return ""


def _promise(before: Before, events: Sequence[Event]) -> str:
    node, says = before
    for event in events:
        at = event.t, event.k
        if at >= says:
            continue
        port = f"{event.source}.{event.port}"
        soonest = min(says, after(node.hears, node.lookahead.get(port, node.least)))
        if at < (node.first if port in node.inner else soonest):
            return (
                f"sent an event on port {event.port} at {event.tag}, earlier than the {soonest} that it had declared: "
                "the lookahead of that port is too long"
            )
    return ""


def _ahead(before: Before, text: Hello | GrantDone) -> str:
    ports = text.lookahead.items() if isinstance(text, Hello) else ()
    wrong = [f"{ahead} ns for port {port}" for port, ahead in ports if not 0 <= ahead <= NEVER]
    return f"declares a lookahead of {wrong[0]}, which is not between 0 and 2**63 ns" if wrong else ""


def _reaches(before: Before, text: Hello | GrantDone) -> str:
    until = before.node.until
    if isinstance(text, Hello) or (text.reached <= until and text.reached <= text.next):
        return ""
    return (
        f"has done all before {text.reached} and goes on at {text.next}: a DONE reaches at most the end of its GRANT, "
        f"{until}, and leaves nothing undone"
    )


def _progress(before: Before, text: Hello | GrantDone) -> str:
    if isinstance(text, Hello) or text.reached > before.node.first:
        return ""
    return f"has done all before {text.reached}: a DONE must include the first tag of its GRANT, {before.node.first}"


def _within(before: Before, text: Hello | GrantDone) -> str:
    spoken = text.spoken if isinstance(text, GrantDone) else []
    if isinstance(text, Hello) or not spoken or spoken[-1].tag < text.reached:
        return ""
    last = spoken[-1]
    return f"sent an event on port {last.port} at {last.tag}, but has only done all before {text.reached}"


def _last(before: Before, text: Hello | GrantDone) -> str:
    if isinstance(text, Hello) or (0, 0) <= text.last < text.reached:
        return ""
    return f"says that its last transition was at {tuple(text.last)}, but has done all before {text.reached} only"


def _tags(before: Before, text: Hello | GrantDone) -> str:
    wrong = [tag for tag in (text.next, text.quiet) if not (0 <= tag.t <= NEVER and tag.k >= 0)]
    return f"goes on at {tuple(wrong[0])}, which is not a valid tag" if wrong else ""


def _offer(before: Before, text: Hello | GrantDone) -> str:
    for event in text.offer:
        if event.tag != text.next or text.next.t == NEVER:
            at = f"{event.source}.{event.port} at {event.tag}"
            return f"offers {at}: an offer holds its own events at its next tag, {text.next}"
    return ""


def _quiet(before: Before, text: Hello | GrantDone) -> str:
    if text.quiet == text.next if text.offer else text.quiet >= text.next:
        return ""
    what = "offers something" if text.offer else "goes on"
    return f"{what} at {text.next} and is quiet until {text.quiet}: quiet must be the tag of its first possible event"


EVENTS: dict[str, Callable[[Before, Sequence[Event]], str]] = {
    "is the node's own": _own,
    "leaves by a port that HELLO named": _port,
    "comes in total order, numbered from 0 in each bag": _order,
    "comes no earlier than quiet and lookahead have declared": _promise,
}
"""The checked part of a message: each event that the node sent or offered."""

WHOLE: dict[str, Callable[[Before, Hello | GrantDone], str]] = {
    "a lookahead is a time": _ahead,
    "what is done ends with the GRANT and before what is next": _reaches,
    "the first tag is done": _progress,
    "what is spoken lies in what is done": _within,
    "so does the last transition": _last,
    "next and quiet are tags": _tags,
    "an offer is for the next tag": _offer,
    "quiet is the tag of an offer, and never earlier than the next tag": _quiet,
}
"""The checked part of a message: the HELLO or DONE as a whole."""


class CycleWatch:
    """Detector of zero-delay cycles: `note` must be called for every event, and `check` before time advances."""

    def __init__(self, couplings: Iterable[Coupling], microsteps: int) -> None:
        """Create a detector that allows at most `microsteps` (> 0) microsteps at one time."""
        self.microsteps = microsteps
        self._late: deque[Event] = deque(maxlen=4 * microsteps)
        self._reached: list[Event] = []
        self._into: dict[str, list[Coupling]] = {}
        for coupling in couplings:
            self._into.setdefault(coupling.target, []).append(coupling)

    def note(self, event: Event) -> None:
        """Record a committed event, to recognise a cycle if too many microsteps follow at one time."""
        if 2 * event.k >= self.microsteps:
            self._late.append(event)
            if event.k >= self.microsteps:
                self._reached.append(event)

    def check(self) -> None:
        """Raise ModelError if events have reached the allowed number of microsteps at one time."""
        if self._reached:
            last = min(self._reached, key=lambda event: event.order)
            raise ModelError(
                self.sentence(last.source, last.tag)
                or f"{last.source} at {last.tag}: port {last.port} has spoken at {self.microsteps} microsteps in which "
                f"no time passes; let it hold for more than 0 ns{LONGER}"
            )

    def sentence(self, node: str, tag: Tag) -> str:
        """Return an error sentence for the zero-delay cycle through `node` at logical time `tag`; "" if there is no
        other node in it."""
        distance = self._back(node, tag) if tag.k >= self.microsteps else []
        if not distance:
            return ""
        first = distance.index(min(distance))
        distance = distance[first:] + distance[:first]
        return (
            f"{', '.join(dict.fromkeys(hop.source for hop in distance))} at {tag}: zero-time loop between nodes, "
            f"{self.microsteps} microsteps in which no time passes: "
            f"{', '.join(f'{hop.source}.{hop.port} -> {hop.target}.{hop.into}' for hop in distance)}; "
            f"let one of them hold for more than 0 ns{LONGER}"
        )

    def _back(self, node: str, tag: Tag) -> list[Coupling]:
        """Return the couplings of the cycle that led to `node` at `tag`, in message order."""
        distance: list[Coupling] = []
        met: list[str] = []
        while node not in met:
            met.append(node)
            heard = [
                (event.order, hop)
                for event in self._late
                for hop in self._into.get(node, ())
                if (event.source, event.port) == (hop.source, hop.port) and event.t == tag.t and event.k < tag.k
            ]
            if not heard:
                return []
            (*at, _, _, _), hop = max(heard)
            node, tag = hop.source, Tag(*at)
            distance.append(hop)
        return distance[met.index(node) :][::-1]
