"""Peers of conservative synchronisation: rounds over a unix socket, and rounds of HELICS federates."""

from __future__ import annotations

import os
import socket
import time
from itertools import pairwise
from multiprocessing.synchronize import Event as Signal
from statistics import median

from heavylift.coordinator.protocol import Grant, GrantDone, encode
from heavylift.coordinator.transport import FrameTopic, Writer
from heavylift.nodes.devs import Tag

from .processes import FORK, Forked
from .rows import SHORT, peer_module

ROUNDS, RAW = (64, 200) if SHORT else (1000, 20_000)
BLOCK, SIZE = 16, 50  # full rounds of a block, characters of a message


def cycle(at: list[float], step: int = 1) -> float:
    """Microseconds of the median cycle, each of so many stamps."""
    stamps = at[step - 1 :: step]
    return median(b - a for a, b in pairwise(stamps)) * 1e6


def raw(_: int) -> float:
    """Microseconds of a round over a unix socket with the sizes of a GRANT and a DONE."""
    there, here = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
    tag, crc = Tag(1_000_000), bytes(16)
    ask = Writer("0" * 16, "n0", FrameTopic.IN, 1).frame(encode(Grant(1000, tag, (0, 7), False, [])))
    answer = Writer("0" * 16, "n0", FrameTopic.OUT, 1).frame(encode(GrantDone(1000, tag, [], tag, [], tag, crc)))
    if os.fork() == 0:
        here.close()
        while there.recv(4096):
            there.send(answer)
        os._exit(0)
    there.close()
    at = []
    for _ in range(RAW):
        here.send(ask)
        here.recv(4096)
        at.append(time.perf_counter())
    here.close()
    os.wait()
    return cycle(at)


def helics_round(n: int, rounds: int = ROUNDS) -> float:
    """Microseconds of a round of n HELICS federates, from blocks that end when the last federate has done them."""
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    near = "--local_interface=127.0.0.1 --loglevel=error"
    core = f"--federates=1 --broker_address=127.0.0.1 --brokerport={port} {near}"
    ready = FORK.Event()
    federates = [Forked(federate, n, rounds, core, i, ready) for i in range(n)]
    import helics as h  # type: ignore[import-untyped]  # not before they are forked: it has threads

    broker = h.helicsCreateBroker("tcp", "", f"-f {n} --localport={port} --name=b{port} {near}")
    ready.set()
    done = zip(*(f.result() for f in federates), strict=True)
    h.helicsBrokerDisconnect(broker)
    h.helicsCloseLibrary()
    blocks = [max(at) for at in done][BLOCK - 1 :: BLOCK]
    return (blocks[-1] - blocks[0]) / BLOCK * 1e6 if len(blocks) < 3 else cycle(blocks) / BLOCK


def federate(n: int, rounds: int, core: str, i: int, ready: Signal) -> list[float]:
    """One of n HELICS federates in a ring: when each of its rounds was done, on the clock of the machine."""
    import helics as h

    ready.wait()
    info = h.helicsCreateFederateInfo()
    h.helicsFederateInfoSetCoreTypeFromString(info, "tcp")
    h.helicsFederateInfoSetCoreInitString(info, core)
    h.helicsFederateInfoSetTimeProperty(info, h.HELICS_PROPERTY_TIME_PERIOD, 1.0)
    own = h.helicsCreateValueFederate(f"f{i}", info)
    out = h.helicsFederateRegisterGlobalPublication(own, f"p{i}", h.HELICS_DATA_TYPE_STRING, "")
    into = h.helicsFederateRegisterSubscription(own, f"p{(i - 1) % n}", "")
    h.helicsFederateEnterExecutingMode(own)
    heard, at = 0, []
    for k in range(1, rounds + 1):
        h.helicsPublicationPublishString(out, "x" * SIZE)
        h.helicsFederateRequestTime(own, float(k))
        if h.helicsInputIsUpdated(into):
            heard += len(h.helicsInputGetString(into)) == SIZE
        at.append(time.perf_counter())
    h.helicsFederateDisconnect(own)
    assert heard >= rounds - 1, heard
    return at


def helics_there() -> bool:
    return peer_module("helics", "HELICS", "pip install '.[bench]'") is not None
