"""State of a node whose process may be lost: its log, and how far its present process has replayed it.

The log holds all messages to a node and its answers: enough to bring a replacement to the same point. WELCOME and HELLO
stay in memory; all later messages are in a journal, each after the answer to the one before it, so that one write per
message suffices. A checkpoint replaces all messages before it.
"""

import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from struct import Struct

from heavylift.coordinator.protocol import messages as m
from heavylift.coordinator.protocol.distance import together
from heavylift.kernel.errors import ModelError
from heavylift.nodes.devs import Tag

from .journal import Journal, read

_LENGTH = Struct("<I")


class ReplayLog:
    """Log of the messages to a node and of its answers, which a replacement process repeats.

    `last`: the last message; `open`: whether it is unanswered; `answer`: the last answer after HELLO; `welcome` and
    `hello`: None until they are sent.
    """

    def __init__(self, path: Path) -> None:
        self._journal = Journal(path)
        self.welcome: bytes | None = None
        self.hello: bytes | None = None
        self.last, self.open = b"", False
        self.answer = b""

    def sent(self, message: bytes) -> None:
        """Record a message to the node before it is sent."""
        if self.welcome is None:
            self.welcome = message
        else:
            self._journal.append(_entry(self.answer, message))
        self.last, self.open = message, True

    def answered(self, message: bytes) -> None:
        """Record the node's answer to the last message."""
        if self.hello is None:
            self.hello = message
        else:
            self.answer = message
        self.open = False

    def kept(self, checkpoint: bytes) -> None:
        """Shorten the log: a checkpoint of the node replaces all messages before it."""
        rest = [_entry(self.answer, self.last)] if self.open else []
        self._journal.restart([_entry(b"", checkpoint), *rest])

    def retell(self) -> Iterator[tuple[bytes, bytes]]:
        """Yield the logged messages to repeat to a replacement process, WELCOME first, each with the recorded
        answer."""
        if self.welcome is None or self.hello is None:
            return
        yield self.welcome, self.hello
        message = None
        for entry in read(self._journal.path):
            length = _LENGTH.unpack_from(entry)[0]
            if message is not None:
                yield message, entry[_LENGTH.size : _LENGTH.size + length]
            message = entry[_LENGTH.size + length :]
        if message is not None and not self.open:
            yield message, self.answer

    def close(self) -> None:
        """Delete the log after the run."""
        self._journal.delete()


def _entry(answer: bytes, message: bytes) -> bytes:
    return _LENGTH.pack(len(answer)) + answer + message


_CURE = "let it depend on nothing but its inputs, time and its own random generator, not on clocks, sets or files"


@dataclass
class Life:
    """State of a node across all processes that have run it, needed to replace a lost process."""

    log: ReplayLog
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
        """Reset the node's state for a replacement process, whose samples begin after the last checkpoint."""
        self.ready, self.repeated, self.asked, self.batch = False, False, b"", self.kept_batch

    def outdated(self, answer: bytes) -> bool:
        """Return whether this DONE only repeats an earlier answer, because a replacement process received a message
        twice."""
        if not self.repeated:
            return False
        done, grant = m.decode(answer), m.decode(self.asked) if self.asked else None
        return isinstance(done, m.GrantDone) and not (isinstance(grant, m.Grant) and grant.gseq == done.gseq)

    @property
    def reached(self) -> Tag:
        """The logical time that the node has reached with the last message of its replayed log."""
        done = m.decode(self.heard) if self.heard else None
        return done.reached if isinstance(done, m.GrantDone) else Tag(0)


def nondeterminism(models: Sequence[str], before: bytes, now: bytes, last: Tag) -> ModelError:
    """Return the error for a node that answered a message differently when the message was repeated to its new process.

    `before`, `now`: both answers; `last`: last logical time.
    """
    old, new = m.decode(before), m.decode(now)
    if isinstance(new, m.Fail):
        what = f"it failed where the lost process had continued ({new.sentence})"
    elif type(old) is not type(new):
        what = f"it said {m.name_of(new)} where it had said {m.name_of(old)} before"
    else:
        fields = [f for f in old.__struct_fields__ if getattr(old, f) != getattr(new, f)]
        what = f"{', '.join(fields)} of its {m.name_of(old)} differ from what it had said before"
    where = f"after {last}" if isinstance(old, m.GrantDone) else "at its start"
    suspects = models if len(models) == 1 else _suspects(models, old, new)
    who = f"model {suspects[0]}" if len(suspects) == 1 else f"one of the models {together(suspects)}"
    return ModelError(f"{who} is not deterministic {where}: a replacement got the same messages, but {what}; {_CURE}")


def _suspects(models: Sequence[str], old: m.AnyMessage, new: m.AnyMessage) -> Sequence[str]:
    """Return the model whose output differs first; all models if no output differs."""
    text = ({*getattr(x, "spoken", ()), *getattr(x, "offer", ())} for x in (old, new))
    first = min(next(text) ^ next(text), default=None)
    return models if first is None else [first.source]
