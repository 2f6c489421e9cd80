"""Keys of a run on the bus, its users and names, and the frame of every message: who says it, in which run, undamaged.

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
"""

import re
import struct
from collections.abc import Iterable
from enum import IntEnum
from zlib import crc32

from heavylift.kernel.errors import ProtocolError, printable

WIRE = 1  # version of what travels, frames and messages: WIRE.md
MAGIC = b"HLF%d" % WIRE
FIRST_EPOCH, LAST_EPOCH = 1, 255
_START = struct.Struct("<IQ")  # crc32, sequence number
_IDENTITY = struct.Struct("<4sBIBB")  # magic, topic, epoch, lengths of the run id and of the node's name
_FIXED = _START.size + _IDENTITY.size


class FrameTopic(IntEnum):
    """Direction and use of a message; the lower-case name is the last chunk of its key."""

    IN = 0  # coordinator -> node
    OUT = 1  # node -> coordinator
    SAMPLES = 2  # node -> coordinator, data


def _identity(run: str, node: str, topic: FrameTopic, epoch: int) -> bytes:
    run_bytes, node_bytes = run.encode(), node.encode()
    head = _IDENTITY.pack(MAGIC, topic, epoch, len(run_bytes), len(node_bytes))
    return head + run_bytes + node_bytes


class Writer:
    """Frames the messages of one node on one topic, numbered from 0."""

    def __init__(self, run: str, node: str, topic: FrameTopic, epoch: int) -> None:
        self._identity = _identity(run, node, topic, epoch)
        self._next = 0

    def frame(self, payload: bytes) -> bytes:
        """The next message: header and payload in one piece."""
        head = self._next.to_bytes(8, "little") + self._identity
        self._next += 1
        return crc32(payload, crc32(head)).to_bytes(4, "little") + head + payload


class FrameReader:
    """Decodes the frames of one node on one topic in order; raises ProtocolError for anything else."""

    def __init__(self, run: str, node: str, topic: FrameTopic, epoch: int) -> None:
        self.run, self.node, self.topic, self.epoch = run, node, topic, epoch
        self._identity = _identity(run, node, topic, epoch)
        self._next = 0

    def open(self, data: bytes) -> bytes:
        """The payload of the next message."""
        head = self._next.to_bytes(8, "little") + self._identity
        payload = data[4 + len(head) :]
        if not data.startswith(head, 4) or crc32(payload, crc32(head)) != int.from_bytes(data[:4], "little"):
            raise self._refusal(data)
        self._next += 1
        return payload

    def outdated(self, data: bytes) -> bool:
        """Whether a refused message is an undamaged one of an earlier incarnation."""
        at, end = _START.size + len(MAGIC) + 1, _START.size + len(self._identity)  # of the epoch; of the identity
        if len(data) < end or crc32(data[4:]) != int.from_bytes(data[:4], "little"):
            return False
        same = data[_START.size : at] + bytes([self.epoch]) + data[at + 1 : end]
        return same == self._identity and data[at] < self.epoch

    def _refusal(self, data: bytes) -> ProtocolError:
        """The error for a frame that is not the next one of its node, topic, epoch and run."""
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
    """The key of a topic of a run: `key(run, "in", "yard-a", "west")`."""
    return "/".join(("heavylift", run, *chunks))


def check_names(names: Iterable[str], kind: str) -> tuple[str, ...]:
    """Check names of nodes or processes: valid in a key and distinct."""
    checked = tuple(names)
    for name in checked:
        if not re.fullmatch(r"[A-Za-z0-9_-]{1,200}", name) or name in RESERVED:
            raise ProtocolError(
                f"{kind} name {name!r} cannot be used, choose 1 to 200 letters, digits, _ or - "
                f"other than {', '.join(repr(word) for word in RESERVED)}"
            )
        if checked.count(name) > 1:
            raise ProtocolError(f"two of the {kind} names are {name!r}, give each {kind} its own name")
    return checked
