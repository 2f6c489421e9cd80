"""How what is said comes to lie in the bags of its receivers or leaves, in the order of the places of flattening.

Until its receiver takes it, the first message lies in the atomic itself, since most bags hold one: containers that
live through a whole instant would keep the garbage collector busy.
"""

from collections.abc import Sequence
from operator import itemgetter

from heavylift.kernel.errors import ModelError
from heavylift.nodes.devs.events import Event
from heavylift.nodes.devs.messages import Message, decode, encode
from heavylift.nodes.devs.models import Atomic, Model
from heavylift.nodes.devs.ports import Arrived, InPort, OutPort, Port
from heavylift.nodes.devs.tags import Instant

from .flatten import Entries

place = itemgetter(0)
model_port_and_place = itemgetter(0, 1, 2)


def deliver(sources: Sequence[Port[Message]], values: Sequence[Message], t: int) -> list[int]:
    """Put messages into the bags of their receivers; who of them is not due at `t` [ns], by index."""
    reached = []
    n = 0
    for source in sources:
        for m, port, place in source.routes:
            value = values[n]
            if m._port is None:
                m._port, m._place, m._value = port, place, value
                if m._t != t:
                    reached.append(m._index)
            elif m._more is None:
                m._more = [(place, port, value)]
            else:
                m._more.append((place, port, value))
        n += 1  # noqa: SIM113 (an enumerate costs as much as a transition where few speak at a time)
    return reached


def sorted_bag(m: Atomic) -> dict[InPort[Message], list[Message]]:
    """A bag of several messages: ports by name, values by place; nothing lies there any more."""
    assert m._port is not None
    assert m._more is not None
    bag = Arrived()
    for _, port, value in sorted([(m._place, m._port, m._value), *m._more], key=place):
        bag.setdefault(port, []).append(value)
    m._more = None
    return bag


def spoken(
    tag: Instant, sources: Sequence[Port[Message]], values: Sequence[Message], inner: bool = False
) -> list[Event]:
    """What leaves at a tag by the out ports of root models, or by their `inner` ones, in total order."""
    left = [
        (target.owner.name, target.name, number, value)
        for port, value in zip(sources, values, strict=True)
        if isinstance(port, OutPort)
        for target, number in (port.inner if inner else port.exits)
    ]
    if len(left) > 1:
        left.sort(key=model_port_and_place)
    (t, k), found, last, i = tag, [], ("", ""), 0
    for name, out, _, value in left:
        i = i + 1 if (name, out) == last else 0
        found.append(Event(t, k, name, out, i, type(value).__name__, encode(value)))
        last = name, out
    return found


def fitting(port: Port[Message], value: Message) -> Message:
    """The message, if the port carries its type."""
    if not isinstance(value, port.type):
        raise ModelError(f"{port!r} carries {port.type.__name__}, not {type(value).__name__}")
    return value


def entry(model: Model, name: str) -> InPort[Message]:
    """An in port of a model by its name."""
    port = model.ports.get(name)
    if not isinstance(port, InPort):
        ins = ", ".join(key for key, port in model.ports.items() if isinstance(port, InPort)) or "none"
        raise ModelError(f"{model.path}: there is no in port {name}; its in ports: {ins}")
    return port


def received(entries: Entries, event: Event) -> tuple[Port[Message], Message]:
    """Where a message from another node comes in, and the copy of it that the models here share."""
    if (event.source, event.port) not in entries:
        raise ModelError(f"{event.source}.{event.port} at {event.tag}: nothing here is coupled to it")
    start, targets = entries[event.source, event.port]
    target = targets[0]
    try:
        value = decode(event.type, event.payload)
        for target in targets:
            fitting(target, value)
    except ModelError as error:
        raise ModelError(f"{target!r} at {event.tag}: {error} (from {event.source}.{event.port})") from None
    return start, value
