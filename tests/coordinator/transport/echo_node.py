"""Nodes for the transport's tests: do what their arguments say, then answer each message until b"stop" for each."""

import os
import signal
import sys
import time
from pathlib import Path

from heavylift.coordinator.transport import OBSERVER, NodeLink, Ticket, guest_session, key
from zenoh.handlers import FifoChannel


def main(arguments: list[str]) -> int:
    what = arguments[0] if arguments else "echo"
    if what == "raise-early":
        raise ValueError("the model has no mass")
    ticket = Ticket.take()
    link = NodeLink(ticket)
    for node in ticket.nodes:
        link.send(node, b"hello")
    if what == "say-and-die":
        link.send(node, b"my last words")
        sys.exit(3)
    if what == "burst":
        link.receive()
        for number in range(int(arguments[1])):
            link.send(node, number.to_bytes(4, "little"))
        link.close()
        return 0
    if what == "observe":
        watching = guest_session(Path(ticket.socket).parent, OBSERVER)
        watching.declare_subscriber(key(ticket.run, "event", "**"), FifoChannel(1))
    if what == "deaf":
        signal.signal(signal.SIGTERM, signal.SIG_IGN)
        time.sleep(60)
    staying = set(ticket.nodes)
    while staying:
        node, message = link.receive()
        if message == b"stop":
            staying.discard(node)
            continue
        if message == b"sample":
            for number in range(3):
                link.sample(node, b"batch %d" % number)
        elif message == b"raise":
            raise RuntimeError("a rope was pushed")
        elif message == b"pid":
            message = str(os.getpid()).encode()
        link.send(node, message)
    link.close()
    return 0
