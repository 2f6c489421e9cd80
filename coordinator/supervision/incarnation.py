"""One node whose process may be lost: its log, and how far its present incarnation has replayed it."""

from __future__ import annotations

import time
from collections.abc import Iterator
from dataclasses import dataclass, field

from heavylift.coordinator.protocol import messages as m
from heavylift.nodes.devs import Tag

from .replay_log import Story


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
