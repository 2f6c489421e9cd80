"""The keys of a run on the bus, the users that it knows, and the names that nodes and processes may have.

heavylift/<run>/in | out | samples/<process>/<node>      one coordinator, one node per key
heavylift/<run>/alive | ask/<process>/<epoch>            is it there; does it make progress
heavylift/<run>/leave/<process>                          may it go
heavylift/join/<process>                                 where a process on another host asks whether it may join
heavylift/<run>/enter/<process>                          where it joins, if its certificate bears this name
heavylift/<run>/event/<model path>/<port>                committed events, for observers
heavylift/<run>/control                                  orders of an operator, as queries
heavylift/<run>/sample/<topic>                           data of a recording that is replayed, for observers
"""

from __future__ import annotations

import re
from collections.abc import Iterable

from heavylift.kernel.errors import ProtocolError

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
    """The names of nodes or processes, refused unless they can stand in a key and differ from each other."""
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
