"""A node in its own process: take the ticket, join, answer until the run is over."""

from __future__ import annotations

from heavylift.nodes.models import KERNEL

from .link import Link
from .participant import Participant
from .session import Ticket

__all__ = ["main"]


def main(arguments: list[str]) -> int:
    """`arguments`: the node's name; 0 when the run ended in order."""
    (name,) = arguments
    if name == KERNEL:  # while the others start: NumPy, LLVM
        from . import kernel_node  # noqa: F401
    with Link(Ticket.take()) as link:
        participant = Participant(name, link.send, link.sample)
        while not participant.over:
            participant.handle(link.receive())
    return 0
