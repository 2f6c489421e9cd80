"""Nodes that external programs run: their WELCOME, and the checks of each of their messages.

Such a program builds no model of ours, so the declarations that heavylift's own nodes make are taken from the
coordinator's build, and the checks of their simulator are made here: ports, types, and canonical bytes (WIRE.md).
"""

from collections.abc import Iterable, Mapping, Sequence

import msgspec
from heavylift.coordinator.protocol import messages as m
from heavylift.coordinator.protocol.distance import Coupling
from heavylift.coordinator.transport.frame import WIRE
from heavylift.coordinator.transport.placement import Placement
from heavylift.kernel.errors import ModelError, ProtocolError, printable
from heavylift.nodes.devs import Event, Message, Model, OutPort, decode, encode

from .parts import ExternalModel, ExternalPart, encode as part

SPEAKS = f"wire {WIRE}"  # the version that such a node says in its HELLO
SHOWN = 64  # characters of what it says of itself
MESSAGES = 500  # characters of why it has failed


class External:
    """The models of one node that an external program runs: their declarations, and checks of the program's
    messages."""

    def __init__(self, node: str, models: Sequence[Model], couplings: Iterable[Coupling], microsteps: int) -> None:
        self.node = node
        self._types: dict[str, dict[str, type[Message]]] = {
            model.name: {port.name: port.type for port in model.ports.values() if isinstance(port, OutPort)}
            for model in models
        }
        self._paths = tuple(model.path for model in models)
        incoming = [wire for wire in couplings if wire[2] in self._types]
        self.config = part(ExternalPart({model.name: _message(model) for model in models}, incoming, microsteps))
        """Configuration that the WELCOME of the node carries."""

    def checked(self, message: m.AnyMessage) -> m.AnyMessage:
        """Return a message of an external program after checking it; raises ProtocolError that names the violated
        rule."""
        if isinstance(message, m.Hello):
            self._check_hello(message)
        for event in (*getattr(message, "spoken", ()), *getattr(message, "offer", ())):
            if event.source in self._types:
                self._check_event(event)
        if isinstance(message, m.Bye):
            for result in message.results:
                who = printable(result.path, SHOWN)
                if not any(f"{result.path}.".startswith(f"{path}.") for path in self._paths):
                    raise ProtocolError(
                        f"node {self.node} sent a result for {who}: a node may send results only for its own models"
                    )
                self._value(result.type, result.payload, f"node {self.node}, its result of {who}")
        if isinstance(message, m.Fail):
            return msgspec.structs.replace(
                message, sentence=f"node {self.node} has failed: {printable(message.sentence, MESSAGES)}"
            )
        return message

    def _check_hello(self, hello: m.Hello) -> None:
        if hello.version != SPEAKS:
            raise ProtocolError(
                f"node {self.node} uses protocol '{printable(hello.version, SHOWN)}', this heavylift "
                f"'{SPEAKS}'; use a program written for this protocol (WIRE.md)"
            )
        ports = {f"{model}.{port}" for model, types in self._types.items() for port in types}
        if wrong := sorted(ports ^ hello.lookahead.keys()):
            what = "does not declare" if wrong[0] in ports else "declares"
            raise ProtocolError(
                f"node {self.node} {what} a lookahead of {printable(wrong[0], SHOWN)}; its out ports are "
                f"{', '.join(sorted(ports)) or 'none'}, and HELLO must declare the lookahead of each"
            )

    def _check_event(self, event: Event) -> None:
        types = self._types[event.source]
        who = f"{event.source} at {event.tag}"
        if event.port not in types:
            named = ", ".join(sorted(types)) or "none"
            raise ProtocolError(
                f"{who} sent an event on port {printable(event.port, SHOWN)}: its out ports are {named}"
            )
        value = self._value(event.type, event.payload, f"{who}, port {event.port}")
        if not isinstance(value, types[event.port]):
            raise ProtocolError(f"{who}: port {event.port} carries {types[event.port].__name__}, not {event.type}")

    def _value(self, type_: str, payload: bytes, where: str) -> Message:
        """Decode a value as a message of type `type_`; raises ProtocolError if its bytes are not canonical."""
        try:
            value = decode(type_, payload)
        except ModelError as error:
            raise ProtocolError(f"{where}: {printable(str(error))}") from None
        if encode(value) != payload:
            raise ProtocolError(
                f"{where}: the bytes of its {type_} are not the canonical ones; write a MessagePack map of all fields "
                "in their order, numbers in their shortest form, floats in 64 bits"
            )
        return value


def externals(
    placement: Placement, models: Mapping[str, Model], couplings: Sequence[Coupling], microsteps: int
) -> list[External]:
    """Return the nodes that external programs run, each with the models that this process has built for comparison."""
    return [
        External(node, [models[name] for name in names], couplings, microsteps)
        for process in sorted(placement.external)
        for node, names in placement.hosted[process].items()
    ]


def _message(model: Model) -> ExternalModel:
    into = {p.name: p.type.__name__ for p in model.ports.values() if not isinstance(p, OutPort)}
    out = {p.name: (p.type.__name__, p.lookahead) for p in model.ports.values() if isinstance(p, OutPort)}
    parameters = dict[str, object]()
    for name, x in vars(model).items():
        try:
            msgspec.msgpack.encode(plain := msgspec.to_builtins(x))
        except (TypeError, ValueError, OverflowError):
            continue  # a model, a port, a generator: no data
        if name != "children" and not name.startswith("_"):
            parameters[name] = plain
    return ExternalModel(into, out, parameters)
