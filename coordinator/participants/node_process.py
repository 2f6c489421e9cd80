"""A process of one or more nodes: take the ticket, join, answer until the run is over for all of them.

Its models are one node, and the kernel is another; neither has a thread of its own: each message is answered before
the next is looked at.
"""

from __future__ import annotations

import os
import traceback
from functools import partial

from heavylift.coordinator.transport.link import Link
from heavylift.coordinator.transport.session import Ticket
from heavylift.nodes.models import KERNEL

from .alive import life_sign
from .participant import Participant, version

version()  # which every node tells: read once, before processes are forked


def main(arguments: list[str]) -> int:
    """`arguments`: none, the ticket says all; 0 when the run ended in order."""
    ticket = Ticket.take()
    if KERNEL in ticket.nodes:  # while the others start: NumPy, LLVM
        from . import kernel_node  # noqa: F401
    with Link(ticket) as link:
        try:
            serve(link)
        except MemoryError:  # none is left to leave in order with; a successor may find some
            traceback.print_exc()
            os._exit(1)
    return 0


def serve(link: Link) -> str:
    """Answer the coordinator until every node of the link has said BYE or FAIL; what was said in the first FAIL."""
    failed = ""
    playing = {
        node: Participant(models, partial(link.send, node), partial(link.sample, node))
        for node, models in link.nodes.items()
    }
    everybody = list(playing.values())
    link.answer(life_sign(lambda: sum(participant.steps for participant in everybody)))
    while playing:
        name, message = link.receive()
        if name in playing:  # one that has failed is told to stop, too
            playing[name].handle(message)
            if playing[name].over:
                failed = failed or playing[name].failed
                del playing[name]
    return failed
