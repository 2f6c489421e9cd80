"""What one node was told and what it answered: enough to bring a successor to the same point.

WELCOME and HELLO stay in memory; all later messages stand in a journal, each behind the answer to the one before it, so
that one write per message does.  A checkpoint takes the place of all that was told before it.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from struct import Struct

from .journal import Journal, read

_LENGTH = Struct("<I")


class Story:
    """`last`: what was told last; `open`: it waits for an answer; `answer`: the last one after HELLO; `welcome` and
    `hello` are None until they are said."""

    def __init__(self, path: Path) -> None:
        self._journal = Journal(path)
        self.welcome: bytes | None = None
        self.hello: bytes | None = None
        self.last, self.open = b"", False
        self.answer = b""

    def told(self, message: bytes) -> None:
        """The node is about to be told this."""
        if self.welcome is None:
            self.welcome = message
        else:
            self._journal.append(_entry(self.answer, message))
        self.last, self.open = message, True

    def answered(self, message: bytes) -> None:
        """The node has answered what it was told last."""
        if self.hello is None:
            self.hello = message
        else:
            self.answer = message
        self.open = False

    def kept(self, checkpoint: bytes) -> None:
        """A successor given this answers as the node did last; all messages before may be forgotten."""
        rest = [_entry(self.answer, self.last)] if self.open else []
        self._journal.restart([_entry(b"", checkpoint), *rest])

    def retell(self) -> Iterator[tuple[bytes, bytes]]:
        """All messages answered so far, from WELCOME on, each with its answer, and those logged meanwhile."""
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
        """The run is over."""
        self._journal.delete()


def _entry(answer: bytes, message: bytes) -> bytes:
    return _LENGTH.pack(len(answer)) + answer + message
