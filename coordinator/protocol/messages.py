"""The messages of the time protocol, with the invariant of each.

| message | way         | carries                             | invariant                                 |
|---------|-------------|-------------------------------------|-------------------------------------------|
| HELLO   | node -> hub | declaration, version, scene hash,   | once per node; nothing is granted before  |
|         |             | next, offer, quiet, lookahead of    | all nodes have sent it                    |
|         |             | each out port                       |                                           |
| WELCOME | hub -> node | epoch, config                       | once per incarnation; before HELLO if     |
|         |             |                                     | a node needs the others' declarations     |
| GRANT   | hub -> node | gseq, until = B_i, echo = D[i][i],  | one outstanding per node; gseq counts up; |
|         |             | committed, inputs before B_i that   | a repeated gseq is answered with the      |
|         |             | were in no GRANT yet, sorted        | stored DONE                               |
| DONE    | node -> hub | gseq, reached, spoken, next, offer, | reached <= until, next >= reached; all    |
|         |             | quiet, hash, last                   | before `reached` is done, later inputs    |
|         |             |                                     | are kept by the node; no output earlier   |
|         |             |                                     | than declared by quiet and lookaheads     |
| CHECK-  | both ways   | gseq; with a state: of the node and | requested between grants, answered with   |
| POINT   |             | the inputs it keeps after that grant| the state; a node that receives a state   |
|         |             |                                     | restores it and answers with its DONE     |
| FAIL    | node -> hub | tag, path, sentence, traceback,     | ends the run; outputs under this GRANT    |
|         |             | spoken                              | before the failure are still recorded     |
| STOP    | hub -> node | end, why                            | nothing at or after `end` counts          |
| BYE     | node -> hub | what the node still waits for,      | answers STOP; nothing follows             |
|         |             | observed slack of its lookaheads,   |                                           |
|         |             | results of its models               |                                           |

A node is one model or several that share a process. `offer` = lambda(next), the next outputs to other nodes, computed
ahead. `quiet` = earliest tag of an output to other nodes if no input arrives. `spoken` = outputs under this grant that
were not offered before, and events among its models or without receivers. `hash` chains (tag, bag, outputs, next).
`last` = tag of its last transition. An input is an event of another node, sent once to each node that receives it. ASK
(is the process alive, and where is it) is a query to a process, which a thread of its own answers by ALIVE. Any other
message, or one out of order, is refused by name. Messages are encoded by MessagePack, one array per message.
"""

from enum import Enum
from typing import Annotated

import msgspec
from heavylift.kernel.errors import UNREADABLE, ProtocolError
from heavylift.nodes.devs import AtomicResult, Event, Slack, Tag
from heavylift.nodes.devs.events import in_bytes

Count = Annotated[int, msgspec.Meta(ge=0)]
Delay = tuple[Count, Count]  # ns and microsteps


class RunEnd(Enum):
    """The reason why a run ended."""

    FINISHED = "the finish port has spoken, and its time is completed"
    BOUND = "the time bound is reached"
    QUIET = "all nodes are passive and nothing is pending"


class Hello(msgspec.Struct, frozen=True, array_like=True, gc=False, tag="hello"):
    """HELLO: a node has started; its declaration and its first offer."""

    next: Tag
    offer: list[Event]
    quiet: Tag
    lookahead: dict[str, Count] = {}  # by "model.port"
    declaration: bytes = b""
    version: str = ""
    scene: str = ""


class Welcome(msgspec.Struct, frozen=True, array_like=True, gc=False, tag="welcome"):
    """WELCOME: the hub has registered the node; `epoch` counts the processes that have run this node."""

    epoch: Annotated[int, msgspec.Meta(ge=1, le=255)]
    config: bytes = b""


class Grant(msgspec.Struct, frozen=True, array_like=True, gc=False, tag="grant"):
    """GRANT: permission to process everything before the logical time `until`."""

    gseq: Count
    until: Tag
    echo: Delay | None
    committed: bool
    inputs: list[Event]


class GrantDone(msgspec.Struct, frozen=True, array_like=True, gc=False, tag="done"):
    """Message DONE: the node has processed everything before the logical time `reached`."""

    gseq: Count
    reached: Tag
    spoken: list[Event]
    next: Tag
    offer: list[Event]
    quiet: Tag
    hash: bytes
    last: Tag = Tag(0)


class Checkpoint(msgspec.Struct, frozen=True, array_like=True, gc=False, tag="checkpoint"):
    """CHECKPOINT: canonical state of a node after it has processed the grant number `gseq`.

    Without a state the message is a request for one, or `why` is the reason why there is none.
    """

    gseq: Count
    state: bytes = b""
    why: str = ""


class Alive(msgspec.Struct, frozen=True, array_like=True, gc=False):
    """ALIVE: progress counter of a process, and whether a debugger has stopped the process."""

    steps: Count
    traced: bool = False


class Fail(msgspec.Struct, frozen=True, array_like=True, gc=False, tag="fail"):
    """Message FAIL: the node has failed."""

    tag: Tag
    path: str
    sentence: str
    traceback: str
    spoken: list[Event] = []


class StopRun(msgspec.Struct, frozen=True, array_like=True, gc=False, tag="stop"):
    """Message STOP: the run is over."""

    end: Tag
    why: str = ""


class Bye(msgspec.Struct, frozen=True, array_like=True, gc=False, tag="bye"):
    """BYE: the node ends; `sentence`: what the node still waits for, `busy_s`: its working time [s]."""

    sentence: str = ""
    busy_s: Annotated[float, msgspec.Meta(ge=0.0)] = 0.0
    slack: list[Slack] = []
    results: list[AtomicResult] = []


AnyMessage = Hello | Welcome | Grant | GrantDone | Checkpoint | Fail | StopRun | Bye

_ENCODER = msgspec.msgpack.Encoder(enc_hook=in_bytes)
_DECODER: msgspec.msgpack.Decoder[AnyMessage] = msgspec.msgpack.Decoder(AnyMessage)


def encode(message: AnyMessage) -> bytes:
    """Encode a message for the wire."""
    return _ENCODER.encode(message)


def decode(data: bytes) -> AnyMessage:
    """Decode a message; raises ProtocolError if it is not a message of the time protocol."""
    try:
        return _DECODER.decode(data)
    except UNREADABLE as error:
        raise ProtocolError(f"not a message of the time protocol: {error}") from None


def name_of(message: AnyMessage) -> str:
    """Return the name of a message in the protocol, such as GRANT."""
    return str(type(message).__struct_config__.tag).upper()


def kind(data: bytes) -> str:
    """Return the kind of an encoded message, read from its first bytes."""
    return data[2 : 2 + (data[1] & 31)].decode(errors="replace") if len(data) > 1 else ""
