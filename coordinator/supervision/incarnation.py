"""One node whose process may be lost: its log, and how far its present incarnation has replayed it; what is said
of a model that answers the replay otherwise than before.
"""

from __future__ import annotations

import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field

from heavylift.coordinator.protocol import messages as m
from heavylift.coordinator.protocol.node_state import together
from heavylift.kernel.errors import ModelError
from heavylift.nodes.devs import Tag

from .replay_log import Story

_CURE = "let it depend on nothing but its inputs, time and its own random generator, not on clocks, sets or files"


@dataclass
class Life:
    """One node, through all incarnations of its process."""

    story: Story
    ready: bool = False  # has heard the whole story
    telling: Iterator[tuple[bytes, bytes]] = field(default_factory=lambda: iter(()))
    expected: bytes = b""
    heard: bytes = b""  # the last answer of the story that it has given
    asked: bytes = b""  # what it was told and has not answered
    since: float = 0.0  # when that was
    repeated: bool = False  # it was told something twice
    losses: list[str] = field(default_factory=list)  # at this point
    over: bool = False
    batches: int = 0  # of samples that were passed on
    batch: int = 0  # those of this incarnation
    kept_batch: int = 0  # those before the checkpoint
    keeps: bool = True
    grants: int = 0  # since the last checkpoint
    kept_at: float = field(default_factory=time.monotonic)

    def begin_again(self) -> None:
        """Its process is replaced; the next one has heard nothing, and begins with the samples of the checkpoint."""
        self.ready, self.repeated, self.asked, self.batch = False, False, b"", self.kept_batch

    def outdated(self, answer: bytes) -> bool:
        """Whether this is a DONE that was said before, of a node that was told something twice."""
        if not self.repeated:
            return False
        done, grant = m.decode(answer), m.decode(self.asked) if self.asked else None
        return isinstance(done, m.Done) and not (isinstance(grant, m.Grant) and grant.gseq == done.gseq)

    @property
    def reached(self) -> Tag:
        """How far it had come with the last answer of its story."""
        done = m.decode(self.heard) if self.heard else None
        return done.reached if isinstance(done, m.Done) else Tag(0)


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
