"""The messages of the time protocol, and what holds for each.

| message | way         | carries                             | invariant                                 |
|---------|-------------|-------------------------------------|-------------------------------------------|
| HELLO   | node -> hub | declaration, version, scene hash,   | once per node; nothing is granted before  |
|         |             | next, offer, quiet, lookahead of    | all have said it                          |
|         |             | each out port                       |                                           |
| WELCOME | hub -> node | epoch, config                       | once per incarnation; before HELLO where  |
|         |             |                                     | a node needs what the others declared     |
| GRANT   | hub -> node | gseq, until = B_i, echo = D[i][i],  | one outstanding per node; gseq counts up; |
|         |             | committed, inputs before B_i that   | a repeated gseq is answered with the      |
|         |             | were in no GRANT yet, sorted        | stored DONE                               |
| DONE    | node -> hub | gseq, reached, spoken, next, offer, | reached <= until, next >= reached; all    |
|         |             | quiet, hash, last                   | below `reached` is done, inputs from there|
|         |             |                                     | on the node keeps; nothing is spoken      |
|         |             |                                     | earlier than quiet and lookaheads declared|
| CHECK-  | both ways   | gseq; with a state: of the node and | asked for between grants, answered by the |
| POINT   |             | the inputs it keeps after that grant| state; told a state, the node goes on     |
|         |             |                                     | from it and answers with that grant's DONE|
| FAIL    | node -> hub | tag, path, sentence, traceback,     | ends the run; what was spoken under this  |
|         |             | spoken                              | GRANT before is still recorded            |
| STOP    | hub -> node | end, why                            | nothing at or after `end` counts          |
| BYE     | node -> hub | what the node still waits for,      | answers STOP; nothing follows             |
|         |             | observed slack of its lookaheads,   |                                           |
|         |             | results of its models               |                                           |

A node is one model or several that share a process. `offer` = what lambda(next) says to other nodes, computed ahead.
`quiet` = earliest tag at which the node can say something to others if nothing reaches it. `spoken` = outputs made
under this grant, not offered before, and what its models said among themselves or to nobody. `hash` chains (tag, bag,
outputs, next). `last` = tag of its last transition. An input is an event that another node has said, once for each
node that hears it.
ASK ("are you alive, where are you") is a query to a process, which a thread of its own answers by ALIVE.
Any other message, or one out of order, is refused by name. The wire form is MessagePack, one array per message.
"""

from typing import Annotated

import msgspec
from heavylift.kernel.errors import UNREADABLE, ProtocolError
from heavylift.nodes.devs import AtomicResult, Event, Slack, Tag

Count = Annotated[int, msgspec.Meta(ge=0)]
Delay = tuple[Count, Count]  # ns and microsteps


class Hello(msgspec.Struct, frozen=True, array_like=True, gc=False, tag="hello"):
    """A node has started: its declaration and first possible output."""

    next: Tag
    offer: list[Event]
    quiet: Tag
    lookahead: dict[str, Count] = {}  # by "model.port"
    declaration: bytes = b""
    version: str = ""
    scene: str = ""


class Welcome(msgspec.Struct, frozen=True, array_like=True, gc=False, tag="welcome"):
    """The hub has registered the node; `epoch` numbers its incarnations."""

    epoch: Annotated[int, msgspec.Meta(ge=1, le=255)]
    config: bytes = b""


class Grant(msgspec.Struct, frozen=True, array_like=True, gc=False, tag="grant"):
    """Permission to process all tags before `until`."""

    gseq: Count
    until: Tag
    echo: Delay | None
    committed: bool
    inputs: list[Event]


class Done(msgspec.Struct, frozen=True, array_like=True, gc=False, tag="done"):
    """Everything before `reached` is done."""

    gseq: Count
    reached: Tag
    spoken: list[Event]
    next: Tag
    offer: list[Event]
    quiet: Tag
    hash: bytes
    last: Tag = Tag(0)


class Checkpoint(msgspec.Struct, frozen=True, array_like=True, gc=False, tag="checkpoint"):
    """State of a node after GRANT `gseq`, canonical; without one a request for it, or `why` there is none."""

    gseq: Count
    state: bytes = b""
    why: str = ""


class Alive(msgspec.Struct, frozen=True, array_like=True, gc=False):
    """Progress counter of a process, and whether a debugger stops it."""

    steps: Count
    traced: bool = False


class Fail(msgspec.Struct, frozen=True, array_like=True, gc=False, tag="fail"):
    """The node has failed."""

    tag: Tag
    path: str
    sentence: str
    traceback: str
    spoken: list[Event] = []


class Stop(msgspec.Struct, frozen=True, array_like=True, gc=False, tag="stop"):
    """The run is over."""

    end: Tag
    why: str = ""


class Bye(msgspec.Struct, frozen=True, array_like=True, gc=False, tag="bye"):
    """The node ends; `sentence`: what it still waits for, `busy_s`: its working time."""

    sentence: str = ""
    busy_s: Annotated[float, msgspec.Meta(ge=0.0)] = 0.0
    slack: list[Slack] = []
    results: list[AtomicResult] = []


AnyMessage = Hello | Welcome | Grant | Done | Checkpoint | Fail | Stop | Bye

_ENCODER = msgspec.msgpack.Encoder()
_DECODER: msgspec.msgpack.Decoder[AnyMessage] = msgspec.msgpack.Decoder(AnyMessage)


def encode(message: AnyMessage) -> bytes:
    """The wire form of a message."""
    return _ENCODER.encode(message)


def decode(data: bytes) -> AnyMessage:
    """Decode a message; raises ProtocolError for anything else."""
    try:
        return _DECODER.decode(data)
    except UNREADABLE as error:
        raise ProtocolError(f"not a message of the time protocol: {error}") from None


def kind(data: bytes) -> str:
    """The kind of an encoded message, read from its first bytes."""
    return data[2 : 2 + (data[1] & 31)].decode(errors="replace") if len(data) > 1 else ""
