"""What is said of a model that answers a replay otherwise than before."""

from __future__ import annotations

from collections.abc import Sequence

from heavylift.coordinator.protocol import messages as m
from heavylift.coordinator.protocol.node_state import together
from heavylift.kernel.errors import ModelError
from heavylift.nodes.devs import Tag

_CURE = "let it depend on nothing but its inputs, time and its own random generator, not on clocks, sets or files"


def nondeterminism(models: Sequence[str], before: bytes, now: bytes, last: Tag) -> ModelError:
    """Of the models of a node. `before` and `now`: its two answers to one message; `last`: what it had done before."""
    old, new = m.decode(before), m.decode(now)
    if isinstance(new, m.Fail):
        what = f"it failed where it had gone on before ({new.sentence})"
    elif type(old) is not type(new):
        what = f"it said {type(new).__name__.upper()} where it had said {type(old).__name__.upper()} before"
    else:
        fields = [f for f in old.__struct_fields__ if getattr(old, f) != getattr(new, f)]
        what = f"{', '.join(fields)} of its {type(old).__name__.upper()} differ from what it had said before"
    where = f"after {last}" if isinstance(old, m.Done) else "at its start"
    suspects = models if len(models) == 1 else _suspects(models, old, new)
    who = f"model {suspects[0]}" if len(suspects) == 1 else f"one of the models {together(suspects)}"
    return ModelError(f"{who} is not deterministic {where}: its successor was told the same, and {what}; {_CURE}")


def _suspects(models: Sequence[str], old: m.AnyMessage, new: m.AnyMessage) -> Sequence[str]:
    """Who has said the first thing that differs; all if nobody has."""
    said = ({*getattr(x, "spoken", ()), *getattr(x, "offer", ())} for x in (old, new))
    first = min(next(said) ^ next(said), default=None)
    return models if first is None else [first.source]
