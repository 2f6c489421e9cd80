"""What out ports promise of their outputs, that it is kept, and how much more could have been promised.

Lookahead L of a port [ns]: after a transition at t, no output that was not already scheduled leaves by it before
t + L. The conservative bounds of Chandy and Misra live on it, so a broken promise ends a run by name; the longest
promise that would have held (`Slack`) is what a user tunes it with.
"""

from collections.abc import Iterable, Mapping, Sequence
from typing import Never

from heavylift.kernel.errors import ModelError
from heavylift.nodes.devs.events import Slack
from heavylift.nodes.devs.messages import Message
from heavylift.nodes.devs.models import Atomic, Model
from heavylift.nodes.devs.ports import OutPort, Port
from heavylift.nodes.devs.tags import NEVER, Instant, Tag


def outs(m: Model) -> list[OutPort[Never]]:
    """The out ports of a model."""
    return [port for port in m.ports.values() if isinstance(port, OutPort)]


def leaving(sources: Iterable[Port[Message]]) -> bool:
    """Whether something of what is said by these ports leaves the root."""
    for port in sources:  # noqa: SIM110 (`any` with a generator takes three times as long)
        if isinstance(port, OutPort) and port.exits:
            return True
    return False


def speakers(atomics: Iterable[Atomic]) -> list[tuple[Atomic, int]]:
    """Those that something leaves the root from, each with the least lookahead of such a port [ns]."""
    found = ((m, [port.lookahead for port in outs(m) if port.exits]) for m in atomics)
    return [(m, min(aheads)) for m, aheads in found if aheads]


def promised(root: Model, atomics: Iterable[Atomic]) -> dict[str, int]:
    """Lookahead of each out port of the root: the smallest of the atomics' ports that lead there; NEVER without one."""
    ahead = {port.name: NEVER for port in outs(root)}
    for port in (port for m in atomics for port in outs(m)):
        for exit, _ in port.exits:
            ahead[exit.name] = min(ahead[exit.name], port.lookahead)
    return ahead


def still_promised(path: str, at: Tag, before: Mapping[str, int], now: Mapping[str, int]) -> None:
    """Refuse a change of structure by which a lookahead falls."""
    for port, ahead in before.items():
        if now[port] < ahead:
            was = f"{ahead} ns" if ahead < NEVER else "that of a port by which nothing leaves"
            raise ModelError(
                f"{path} at {at}: the lookahead of port {port} falls from {was} to {now[port]} ns, but others rely on "
                "it; give what is added no less lookahead"
            )


def keep_promises(tag: Instant, sources: Sequence[Port[Message]]) -> None:
    """Refuse what is said too soon after the transition that scheduled it."""
    for port in sources:
        if isinstance(port, OutPort) and port.lookahead and isinstance(m := port.owner, Atomic):
            since = tag[0] - m._set
            if since < port.lookahead:
                raise ModelError(
                    f"{m.path} at {Tag(*tag)}: port {port.name} promises a lookahead of {port.lookahead} ns and speaks "
                    f"{since} ns after the transition that scheduled it; hold for longer or declare less"
                )


class Observed:
    """For each port of an atomic that has spoken to the outside: what lookahead it could have had so far."""

    def __init__(self) -> None:
        self._ports: dict[tuple[str, str], Slack] = {}

    def note(self, t: int, sources: Sequence[Port[Message]]) -> None:
        """By which ports something is said at t [ns]; what was scheduled from the start bounds no promise."""
        for port in sources:
            m = port.owner
            if isinstance(port, OutPort) and port.exits and isinstance(m, Atomic) and m._set >= 0:
                key, waited = (m.path, port.name), t - m._set
                known = self._ports.get(key)
                least, n = (min(waited, known.observed_ns), known.count) if known else (waited, 0)
                self._ports[key] = Slack(f"{key[0]}.{key[1]}", port.lookahead, least, n + 1)

    def table(self) -> list[Slack]:
        """In the order of paths and ports."""
        return [self._ports[key] for key in sorted(self._ports)]
