"""Configurations of nodes, as sent in their WELCOME.

ScenePart    a machine or the commander of a scene         KernelPart      the mechanics of all of them
ModelPart    a child of the model that a function builds   ExternalPart    what an external program must know
"""

from hashlib import blake2b

import msgspec
from heavylift.coordinator.protocol.distance import Coupling
from heavylift.kernel.description.mechanics import System
from heavylift.kernel.description.signals import ScalarSignal
from heavylift.kernel.trust import named
from heavylift.nodes.devs.execution.rules import LIMIT


class ScenePart(msgspec.Struct, frozen=True, tag="scene"):
    """Configuration of a node of a scene: its models, and the encoded plan reduced to the parts that these models
    need."""

    plan: bytes


class SignalSubscription(msgspec.Struct, frozen=True):
    """Signals that a model receives as samples, by input port, and the sampling period [ns]."""

    period: int
    signals: dict[str, ScalarSignal]


class KernelConfig(msgspec.Struct, frozen=True):
    """Configuration of the kernel, which it receives after all other nodes have declared themselves."""

    systems: list[System]
    gravity: float
    tolerance: float
    sample_ns: int
    subscriptions: dict[str, list[str]]  # element -> models that hear of its events
    method: str = "dopri5"
    step: float | None = None
    ties: list[str] = []  # ropes that the list will hook: what they tie is one island from the start
    apart: bool = True  # islands are solved apart
    listening: dict[str, SignalSubscription] = {}  # models that hear signals
    lifts: dict[str, list[str]] = {}  # bodies of each of several lifts, whose events are shown apart


class KernelPart(msgspec.Struct, frozen=True, tag="kernel"):
    """Configuration of the kernel's node; `agreed`: fingerprint of the plan."""

    config: KernelConfig
    agreed: str


class ModelPart(msgspec.Struct, frozen=True, tag="model"):
    """Configuration of a node that runs children of a DEVS model; `finish`: port (child, port) whose first message
    ends the run."""

    build: str
    log: bool = False
    microsteps: int = LIMIT
    finish: tuple[str, str] | None = None


class ExternalModel(msgspec.Struct, frozen=True):
    """Declaration of an external model: input ports with their types, output ports with types and lookaheads [ns], and
    attributes."""

    into: dict[str, str]
    out: dict[str, tuple[str, int]]
    parameters: dict[str, object]


class ExternalPart(msgspec.Struct, frozen=True, tag="external"):
    """Configuration of an external node: its models, and couplings (source, port, model, its port) into them."""

    models: dict[str, ExternalModel]
    couplings: list[Coupling]
    microsteps: int


Part = ScenePart | KernelPart | ModelPart

_DECODER: msgspec.msgpack.Decoder[Part] = msgspec.msgpack.Decoder(Part)


def encode(part: Part | ExternalPart) -> bytes:
    """Encode a node's configuration, which the coordinator sends in its WELCOME message."""
    return msgspec.msgpack.encode(part)


def decode(data: bytes) -> Part:
    """Decode a node's configuration from the coordinator's WELCOME message."""
    part = _DECODER.decode(data)
    if isinstance(part, KernelPart):
        named(function for system in part.config.systems for function in system.functions)
    return part


def fingerprint(what: bytes) -> str:
    """Return a hash by which coordinator and nodes compare their configurations."""
    return blake2b(what, digest_size=16).hexdigest()
