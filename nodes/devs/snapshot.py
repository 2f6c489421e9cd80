"""The state of a simulator as bytes: models with their states, schedule and structure, but no routes.

Snapshots are made and read by one program on one machine; like every pickle they must not come from strangers.
"""

import pickle
from typing import Any

from heavylift.kernel.errors import ModelError

from .models import Model


def frozen(model: Model, rest: tuple[Any, ...]) -> bytes:
    """A model tree and what belongs to it as bytes."""
    try:
        return pickle.dumps((model, rest), protocol=pickle.HIGHEST_PROTOCOL)
    except (pickle.PicklingError, AttributeError, TypeError, RecursionError) as error:
        raise ModelError(
            f"{model.path}: no snapshot can be taken ({error}); keep only plain data and models' ports in states"
        ) from None


def thawed(snapshot: bytes) -> tuple[Model, Any]:
    """The model tree and what belongs to it."""
    model, rest = pickle.loads(snapshot)
    return model, rest
