"""The state of a simulator as bytes: models with their states, schedule and structure, but no routes (`canonical`).

What the model is a part of stays outside: a snapshot is restored in the same place."""

from typing import Any

from heavylift.kernel.errors import UNREADABLE, ModelError
from heavylift.nodes.devs.models import Model

from . import canonical


def frozen(model: Model, rest: tuple[object, ...]) -> bytes:
    """A model tree and what belongs to it as bytes."""
    try:
        return canonical.frozen((model, rest), _around(model))
    except (TypeError, RecursionError) as error:
        raise ModelError(
            f"{model.path}: no snapshot can be taken ({error}); keep only plain data and models' ports in states"
        ) from None


def thawed(snapshot: bytes, former: Model) -> tuple[Model, Any]:
    """The model tree, in the place of a former one, and what belongs to it."""
    try:
        model, rest = canonical.thawed(snapshot, _around(former))
    except (TypeError, ValueError, LookupError, AttributeError, *UNREADABLE) as error:
        raise ModelError(f"this is no snapshot of a model that is defined here ({error}); take a new one") from None
    return model, rest


def _around(model: Model) -> list[object]:
    return [model._present, model.parent]
