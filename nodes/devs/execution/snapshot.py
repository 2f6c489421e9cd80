"""The state of a simulator as bytes: models with their states, schedule and structure, but no routes (`canonical`).

What the models are a part of stays outside: a snapshot is restored in the same place."""

from collections.abc import Sequence
from typing import Any

import msgspec
from heavylift.kernel.errors import UNREADABLE, ModelError
from heavylift.nodes.devs.events import Instant
from heavylift.nodes.devs.messages import Message
from heavylift.nodes.devs.models import Model
from heavylift.nodes.devs.ports import InPort

from . import canonical

Staged = list[tuple[InPort[Message], Message]]  # messages on their way in


def frozen(models: Sequence[Model], last: Instant, staged: Staged) -> bytes:
    """Serialise model trees with their last tag and pending inputs."""
    parts = []
    for model in models:
        rest = last, [(port, value) for port, value in staged if port.owner is model]
        try:
            parts.append(canonical.frozen((model, rest), _around(model)))
        except (TypeError, RecursionError) as error:
            raise ModelError(
                f"{model.path}: no snapshot can be taken ({error}); keep only plain data and models' ports in states"
            ) from None
    return msgspec.msgpack.encode(parts)


def thawed(snapshot: bytes, former: Sequence[Model]) -> tuple[list[Model], Instant, Staged]:
    """Deserialise model trees in place of former ones, with last tag and pending inputs."""
    try:
        parts = msgspec.msgpack.decode(snapshot, type=list[bytes])
        found: list[Any] = [canonical.thawed(part, _around(m)) for part, m in zip(parts, former, strict=True)]
        staged = [put for _, (_, waiting) in found for put in waiting]
        return [model for model, _ in found], found[0][1][0], staged
    except (TypeError, ValueError, LookupError, AttributeError, *UNREADABLE) as error:
        raise ModelError(f"this is no snapshot of a model that is defined here ({error}); take a new one") from None


def _around(model: Model) -> list[object]:
    return [model._present, model.parent]
