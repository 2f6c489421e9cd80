"""What is said of a model that answers a replay otherwise than before."""

from __future__ import annotations

from heavylift.coordinator.protocol import messages as m
from heavylift.kernel.errors import ModelError
from heavylift.nodes.devs import Tag

__all__ = ["nondeterminism"]

_CURE = "let it depend on nothing but its inputs, time and its own random generator, not on clocks, sets or files"


def nondeterminism(node: str, before: bytes, now: bytes, last: Tag) -> ModelError:
    """`before` and `now`: its two answers to one message; `last`: what it had done before."""
    old, new = m.decode(before), m.decode(now)
    if isinstance(new, m.Fail):
        what = f"it failed where it had gone on before ({new.sentence})"
    elif type(old) is not type(new):
        what = f"it said {type(new).__name__.upper()} where it had said {type(old).__name__.upper()} before"
    else:
        fields = [f for f in old.__struct_fields__ if getattr(old, f) != getattr(new, f)]
        what = f"{', '.join(fields)} of its {type(old).__name__.upper()} differ from what it had said before"
    where = f"after {last}" if isinstance(old, m.Done) else "at its start"
    return ModelError(
        f"model {node} is not deterministic {where}: its successor was told the same, and {what}; {_CURE}"
    )
