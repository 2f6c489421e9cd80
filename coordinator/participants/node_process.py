"""A process of one or more nodes: read the ticket, join, answer until the run is over for all nodes.

Its models are one node, and the kernel is another; nodes have no threads of their own: each message is answered before
the next is read. A thread of the link reports that the process is alive, whatever its nodes are doing.
"""

import os
import sys
import threading
import traceback
from collections.abc import Callable
from functools import partial

import msgspec
from heavylift.coordinator.protocol.messages import Alive
from heavylift.coordinator.transport.link import NodeLink
from heavylift.coordinator.transport.session import Ticket
from heavylift.nodes.models import KERNEL

from .participant import Participant


def main(arguments: list[str]) -> int:
    """Run a node process from the ticket on its standard input; returns 0 if the run ends without failure."""
    ticket = Ticket.take()
    if KERNEL in ticket.nodes:  # while the others start: NumPy, LLVM
        from . import kernel_node  # noqa: F401
    with NodeLink(ticket) as link:
        try:
            serve(link)
        except MemoryError:  # none is left to leave in order with; a successor may find some
            traceback.print_exc()
            os._exit(1)
    return 0


def serve(link: NodeLink) -> str:
    """Answer the coordinator until all nodes have sent BYE or FAIL; return the sentence of the first FAIL, or ""."""
    failed = ""
    playing = {
        node: Participant(models, partial(link.send, node), partial(link.sample, node))
        for node, models in link.nodes.items()
    }
    everybody = list(playing.values())
    link.answer(life_sign(lambda: sum(participant.steps for participant in everybody)))
    while playing:
        name, message = link.receive()
        if name in playing:  # one that has failed is sent STOP, too
            playing[name].handle(message)
            if playing[name].over:
                failed = failed or playing[name].failed
                del playing[name]
    return failed


def life_sign(steps: Callable[[], int]) -> Callable[[], bytes]:
    """Return a function that encodes the answer of a process to a liveness query; `steps` returns a counter that grows
    with its progress."""
    return lambda: msgspec.msgpack.encode(Alive(steps(), _traced()))


def _traced() -> bool:
    """Return whether a Python or system debugger traces the main thread."""
    frame = sys._current_frames().get(threading.main_thread().ident or 0)
    while frame is not None:
        if frame.f_trace is not None:
            return True
        frame = frame.f_back
    try:
        with open("/proc/self/status", encoding="utf-8", errors="replace") as status:
            return any(line.startswith("TracerPid:") and line.split()[1] != "0" for line in status)
    except OSError:
        return False
