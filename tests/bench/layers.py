"""Time of one grant cycle by layers: the same round trip between two processes, beside a raw one.

    taskset -c 1 python tests/bench/layers.py [--json] [--short]

Each layer is measured in a process of its own, all on the cores that we may use (pin it to one), as the median cycle.
  raw      a GRANT's bytes over a unix socket, a DONE's bytes back          session  the same over the sessions of a run
  frames   the product's hub and link: CRC, sequence, epoch, observers      codec    messages encoded and decoded
  node     a node answers: model, offer, hash                               run      `run_models`: core, story, vigil
"""

from __future__ import annotations

import os
import time
from collections.abc import Callable

import msgspec
import sync
import zenoh
from heavylift.coordinator.protocol import Grant, GrantDone, Node, decode, encode
from heavylift.coordinator.transport import (
    Hub,
    NodeLink,
    RunDirectory,
    Ticket,
    key,
    new_password,
    new_run_id,
    session as sessions,
)
from heavylift.nodes.devs import Simulator, Tag
from shared.processes import Forked
from shared.rows import SHORT, options, row
from shared.sync_models import turns
from zenoh.handlers import FifoChannel

CYCLES = 200 if SHORT else 8000
HALF_ns = 500
LAYERS = ("raw", "session", "frames", "codec", "node", "run")
BLOCK = zenoh.CongestionControl.BLOCK
ASK = Grant(1, Tag(1_000_000), (0, 7), False, [])
ANSWER = GrantDone(1, ASK.until, [], ASK.until, [], ASK.until, bytes(16))


def timed(exchange: Callable[[int], None]) -> float:
    """Microseconds of the median of many exchanges."""
    at = []
    for i in range(CYCLES):
        exchange(i)
        at.append(time.perf_counter())
    return sync.cycle(at)


def forked(main: Callable[[Ticket], None]) -> Callable[[Ticket], int]:
    """A child that stands before any session is open; it begins when it gets its ticket."""
    read, write = os.pipe()
    pid = os.fork()
    if pid == 0:
        main(msgspec.json.decode(os.read(read, 4096), type=Ticket))
        os._exit(0)

    def begin(ticket: Ticket) -> int:
        os.write(write, msgspec.json.encode(ticket))
        return pid

    return begin


def session() -> float:
    """Publisher and subscriber on either side, nothing else."""

    def echo(ticket: Ticket) -> None:
        own = sessions.node_session(ticket)
        out = own.declare_publisher(key(ticket.run, "out", "n0", "n0"), congestion_control=BLOCK)
        into = own.declare_subscriber(key(ticket.run, "in", "n0", "*"), FifoChannel(4096))
        while into.recv().payload.to_bytes():
            out.put(encode(ANSWER))
        own.close()

    begin, run, directory = forked(echo), new_run_id(), RunDirectory.chosen().make()
    passwords = {user: new_password() for user in ("coordinator", "n0")}
    own = sessions.hub_session(run, directory, passwords)
    heard = own.declare_subscriber(key(run, "out", "*", "*"), FifoChannel(4096))
    out = own.declare_publisher(key(run, "in", "n0", "n0"), congestion_control=BLOCK)
    begin(Ticket(run, "n0", {"n0": ("n0",)}, 1, directory.socket, passwords["n0"]))
    while not out.matching_status.matching:
        time.sleep(0.01)
    data = encode(ASK)

    def exchange(_: int) -> None:
        out.put(data)
        heard.recv()

    value = timed(exchange)
    out.put(b"")
    os.wait()
    own.close()
    directory.remove()
    return value


def hub(codec: bool, working: bool) -> float:
    """Hub and link of the product."""

    def answer(ticket: Ticket) -> None:
        node = Node("n0", Simulator(turns(2).children["n0"]))
        node.hello()
        done = encode(ANSWER)
        with NodeLink(ticket) as link:
            while data := link.receive()[1]:
                if working:
                    done = encode(node.handle(decode(data)))
                elif codec:
                    decode(data)
                    done = encode(ANSWER)
                link.send("n0", done)

    begin, data = forked(answer), encode(ASK)
    with Hub(["n0"]) as own:
        begin(own.ticket("n0"))

        def exchange(i: int) -> None:
            tick = 1000 + 2000 * i  # of the first of two clocks
            own.send("n0", encode(Grant(i + 1, Tag(tick + HALF_ns), (0, 7), False, [])) if codec else data)
            got = own.receive()
            if codec and got is not None:
                decode(got[1])

        value = timed(exchange)
        own.dismiss(b"")
        os.wait()
    return value


def measure(layer: str) -> float:
    """One layer, in this process."""
    if layer in ("raw", "run"):
        return sync.raw(0) if layer == "raw" else sync.grant(2)
    return session() if layer == "session" else hub(layer != "frames", layer == "node")


def main() -> None:
    options(__doc__ or "")
    raw = None
    for layer in LAYERS:
        value = Forked(measure, layer).result()
        raw = raw or value
        row(f"cycle, {layer}", value, "us", "raw", raw)


if __name__ == "__main__":
    main()
