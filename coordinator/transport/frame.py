"""Keys of a run on the bus, its users and names, and the frame of every message: sender, run, number, checksum.

heavylift/<run>/in | out | samples/<process>/<node>      one coordinator, one node per key
heavylift/<run>/alive | ask/<process>/<epoch>            is it there; does it make progress
heavylift/<run>/leave/<process>                          may it go
heavylift/join/<process>                                 where a process on another host asks whether it may join
heavylift/<run>/enter/<process>                          where it joins, if its certificate bears this name
heavylift/<run>/event/<model path>/<port>                committed events, for observers
heavylift/<run>/control                                  orders of an operator, as queries
heavylift/<run>/sample/<topic>                           data of a recording that is replayed, for observers

    crc32 | sequence | magic | topic | epoch | len(run) | len(node) | run | node | payload      little-endian

The CRC32 covers all that follows it. `Writer` numbers the messages of one node on one topic from 0 upwards;
`FrameReader` accepts exactly the next one and refuses any other by name, so that a lost, repeated, foreign or damaged
message ends a run with a sentence and never with a wrong trajectory. The epoch is the incarnation of a node: what a
dead process still had under way is refused when its successor has taken over.

The private directory of a run is where its processes meet; it goes with the run, also if that is killed.
"""

import fcntl
import os
import re
import secrets
import shutil
import struct
import tempfile
import weakref
from collections.abc import Iterable
from contextlib import suppress
from enum import IntEnum
from pathlib import Path
from typing import Self
from zlib import crc32

from heavylift.kernel.errors import ProtocolError, printable

WIRE = 1  # version of what travels, frames and messages: WIRE.md
MAGIC = b"HLF%d" % WIRE
FIRST_EPOCH, LAST_EPOCH = 1, 255
_START = struct.Struct("<IQ")  # crc32, sequence number
_IDENTITY = struct.Struct("<4sBIBB")  # magic, topic, epoch, lengths of the run id and of the node's name
_FIXED = _START.size + _IDENTITY.size


class FrameTopic(IntEnum):
    """Direction and use of a message; its lower-case name ends the Zenoh key of the topic."""

    IN = 0  # coordinator -> node
    OUT = 1  # node -> coordinator
    SAMPLES = 2  # node -> coordinator, data


def _identity(run: str, node: str, topic: FrameTopic, epoch: int) -> bytes:
    run_bytes, node_bytes = run.encode(), node.encode()
    head = _IDENTITY.pack(MAGIC, topic, epoch, len(run_bytes), len(node_bytes))
    return head + run_bytes + node_bytes


class Writer:
    """Writes the messages of one node on one topic as frames, numbered from 0."""

    def __init__(self, run: str, node: str, topic: FrameTopic, epoch: int) -> None:
        self._identity = _identity(run, node, topic, epoch)
        self._next = 0

    def frame(self, payload: bytes) -> bytes:
        """Return the next frame: header and payload in one piece."""
        head = self._next.to_bytes(8, "little") + self._identity
        self._next += 1
        return crc32(payload, crc32(head)).to_bytes(4, "little") + head + payload


class FrameReader:
    """Decodes the frames that one node sends on one topic, in order; raises ProtocolError for any other frame."""

    def __init__(self, run: str, node: str, topic: FrameTopic, epoch: int) -> None:
        self.run, self.node, self.topic, self.epoch = run, node, topic, epoch
        self._identity = _identity(run, node, topic, epoch)
        self._next = 0

    def open(self, data: bytes) -> bytes:
        """Check the header and checksum of the next frame, and return its payload."""
        head = self._next.to_bytes(8, "little") + self._identity
        payload = data[4 + len(head) :]
        if not data.startswith(head, 4) or crc32(payload, crc32(head)) != int.from_bytes(data[:4], "little"):
            raise self._refusal(data)
        self._next += 1
        return payload

    def outdated(self, data: bytes) -> bool:
        """Return whether a rejected frame is intact and was sent by an earlier process of the node."""
        at, end = _START.size + len(MAGIC) + 1, _START.size + len(self._identity)  # of the epoch; of the identity
        if len(data) < end or crc32(data[4:]) != int.from_bytes(data[:4], "little"):
            return False
        same = data[_START.size : at] + bytes([self.epoch]) + data[at + 1 : end]
        return same == self._identity and data[at] < self.epoch

    def _refusal(self, data: bytes) -> ProtocolError:
        """Return the error for a frame that is not the next one of its node, topic, epoch and run."""
        where = f"node {self.node}, message {self._next} on '{self.topic.name.lower()}'"
        magic = data[_START.size : _START.size + 4]
        if magic.startswith(b"HLF") and magic != MAGIC:
            return ProtocolError(
                f"{where}: a frame of wire version {printable(magic[3:].decode(errors='replace'))} arrived, and this "
                f"heavylift speaks version {WIRE}; use a program that was written for it"
            )
        if len(data) < _FIXED or magic != MAGIC:
            return ProtocolError(
                f"{where}: {len(data)} bytes arrived that are no heavylift message ({data[:16]!r}); "
                "another program writes to this run's keys, end it and start the run again"
            )
        crc, number = _START.unpack_from(data)
        if crc32(memoryview(data)[4:]) != crc:
            return ProtocolError(
                f"{where}: a message of {len(data)} bytes arrived damaged (its CRC32 does not match), "
                "start the run again"
            )
        _, topic, epoch, n_run, n_node = _IDENTITY.unpack_from(data, _START.size)
        run = printable(data[_FIXED : _FIXED + n_run].decode(errors="replace"))
        node = printable(data[_FIXED + n_run : _FIXED + n_run + n_node].decode(errors="replace"))
        if run != self.run:
            what = f"a message of run {run} arrived in run {self.run}, end the other run's processes"
        elif node != self.node:
            what = f"a message of node {node} arrived in its place, each node must use its own name and key"
        elif topic != self.topic:
            name = FrameTopic(topic).name.lower() if topic in tuple(FrameTopic) else str(topic)
            what = f"a message of topic '{name}' arrived, each topic must be written to its own key"
        elif epoch != self.epoch:
            what = f"a message of epoch {epoch} arrived in epoch {self.epoch}, end the node's older process"
        else:
            how = "messages were lost" if number > self._next else "it had arrived before"
            what = f"message {number} arrived out of sequence ({how}), start the run again"
        return ProtocolError(f"{where}: {what}")


OPERATOR = "operator"  # the user name that may give orders to a run and nothing else
OBSERVER = "observer"  # the user name that may watch committed events and nothing else
AFAR = "afar"  # user name and password of everybody at the door: there, certificates tell who is who
JOIN = "join"  # in place of a run's id: where a process on another host asks to join whatever runs
HUB = "~hub"  # in place of a process's name: the coordinator itself
# Users and topics of a run, so no names of nodes or processes.
RESERVED = ("coordinator", "event", "sample", "control", OBSERVER, OPERATOR, AFAR)


def key(run: str, *chunks: str) -> str:
    """Return the Zenoh key on which a topic of a run is exchanged, such as `key(run, "in", "yard-a", "west")`."""
    return "/".join(("heavylift", run, *chunks))


def check_names(names: Iterable[str], kind: str) -> tuple[str, ...]:
    """Return names of nodes or processes after checking that they are distinct and can be part of a key; raises
    ProtocolError."""
    checked = tuple(names)
    for name in checked:
        if not re.fullmatch(r"[A-Za-z0-9_-]{1,200}", name) or name in RESERVED:
            raise ProtocolError(
                f"{kind} name {name!r} cannot be used; choose 1 to 200 letters, digits, _ or - "
                f"other than {', '.join(repr(word) for word in RESERVED)}"
            )
        if checked.count(name) > 1:
            raise ProtocolError(f"two of the {kind} names are {name!r}; give each {kind} its own name")
    return checked


PREFIX = "heavylift-"  # of the private directory of a run
SOCKET_PATH_LIMIT = 104  # bytes with the closing zero: the smaller of Linux (108) and macOS (104)


class RunDirectory:
    """The private directory (mode 0700) of one run, with its socket, passwords and output of nodes.

    It is locked while its coordinator is alive; the directory of a killed run is removed when the next run begins.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self.socket = str(path / "hub.sock")
        self._lock = -1
        self._removal = weakref.finalize(self, _remove, path, os.getpid())  # a signal may come before anybody owns it

    @classmethod
    def chosen(cls) -> Self:
        """Return a run directory with a new unique path; it is not created yet."""
        for place in places():
            path = Path(place) / f"{PREFIX}{secrets.token_hex(4)}"
            if len(os.fsencode(path / "hub.sock")) < SOCKET_PATH_LIMIT and os.access(place, os.W_OK | os.X_OK):
                return cls(path)
        raise ProtocolError(
            "no temporary directory is writable and short enough for a unix socket "
            f"({tempfile.gettempdir()} is not); set TMPDIR to a shorter path"
        )

    def make(self) -> Self:
        """Create and lock the directory of the run."""
        _sweep(self.path.parent)
        try:
            made = self.path.with_name(f".{self.path.name}")  # nobody sweeps it before it is locked
            os.mkdir(made, 0o700)
            self._lock = os.open(made, os.O_RDONLY | os.O_CLOEXEC)
            fcntl.flock(self._lock, fcntl.LOCK_EX)
            os.rename(made, self.path)
        except OSError as error:
            raise ProtocolError(
                f"{self.path}: the run's directory cannot be made ({error.strerror}); set TMPDIR to another folder"
            ) from None
        return self

    def write(self, name: str, text: str) -> Path:
        """Write a file that only this user can read."""
        path = self.path / name
        with open(os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600), "w", encoding="utf-8") as file:
            file.write(text)
        return path

    def log(self, node: str) -> Path:
        """Return the path of the file for a node's standard output and error."""
        return self.path / f"{node}.log"

    def remove(self) -> None:
        """Delete the directory of the run with its contents."""
        self._removal()
        lock, self._lock = self._lock, -1  # before it is closed: what a signal interrupts may come here again
        if lock >= 0:
            os.close(lock)


def _remove(path: Path, maker: int) -> None:
    if os.getpid() == maker:  # not a fork of it
        shutil.rmtree(path, ignore_errors=True)


def _sweep(place: Path) -> None:
    """Remove directories of this user's killed runs."""
    for left in place.glob(f"{PREFIX}{'[0-9a-f]' * 8}"):
        try:
            lock = os.open(left, os.O_RDONLY | os.O_NOFOLLOW | os.O_DIRECTORY | os.O_CLOEXEC)
        except OSError:
            continue
        with suppress(OSError):  # locked: it lives
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
            names = set(os.listdir(lock))
            ours = "hub.sock" in names or names <= {"users", OBSERVER, OPERATOR}  # ended before it could listen
            if ours and os.fstat(lock).st_uid == os.getuid():
                shutil.rmtree(left, ignore_errors=True)
        os.close(lock)


def places() -> list[str]:
    """Return the folders in which directories of runs may be created, the preferred one first."""
    return list(dict.fromkeys((tempfile.gettempdir(), os.environ.get("XDG_RUNTIME_DIR", "/tmp"), "/tmp")))
