"""Moments of a node and of the keeper: this module, imported there, waits for the planned one and injects the fault.

The keeper imports it before all else that it preloads, the nodes with the keeper.
"""

from __future__ import annotations

import os
import random
import signal
import sys
import time
from typing import Any, ClassVar

from injections.inside.striking import ACT, PHASE, PLAN, WHO, Imports, lose, once, strike

if WHO == "keeper" and PHASE == "import" and sys.argv[0] == "-c":  # not in the coordinator
    sys.meta_path.insert(0, Imports(PLAN["point"]))

from heavylift.coordinator.participants import node_process, participant
from heavylift.coordinator.protocol import messages as m
from heavylift.coordinator.supervision import process_manager
from heavylift.coordinator.transport import Ticket, Writer


class Counted:
    """The process, the grants of its nodes, the frames it has sent; starts that the keeper was ordered, and of whom."""

    process, count, epoch, frames = "", 0, 0, 0
    random = random.Random(str(PLAN))
    seen: ClassVar[set[str]] = set()


def take() -> Ticket:
    ticket = original_take()
    Counted.process, Counted.epoch = ticket.process, ticket.epoch
    if PHASE == "compile" and ticket.process == "kernel" and WHO in ("kernel", "keeper"):
        compiles(lambda: strike() if WHO == "kernel" else os.kill(os.getppid(), signal.SIGUSR2))
    if ticket.process == WHO and PHASE == "import":
        sys.meta_path.insert(0, Imports(PLAN["point"]))
    if ticket.process == WHO and PHASE == "start" and PLAN["point"] == 0:
        strike()
    return ticket


def compiles(then: Any) -> None:
    """Do something when this process makes machine code."""
    from heavylift.kernel.compiler import Library

    original = Library._compile

    def compile_(self: Library, ir: str, opt: int) -> bytes:
        then()
        return original(self, ir, opt)

    Library._compile = compile_  # type: ignore[method-assign]


def handle(self: participant.Participant, data: bytes) -> None:
    kind = m.kind(data)
    Counted.count += kind == "grant"
    if Counted.process == PLAN.get("loses") and Counted.epoch == 1 and Counted.count >= PLAN["lose_at"]:
        lose(Counted.process)
    if Counted.process == WHO:
        at = Counted.count >= PLAN["point"]
        moment = {
            "start": kind == "welcome",
            "run": kind == "grant" and at,
            "exit": kind == "stop",
            "recovery": Counted.epoch > 1 and at,
        }.get(PHASE)
        if moment and PHASE == "run" and ACT == "exception" and once("own"):
            assert self._node is not None

            def advance(*_: object) -> None:
                raise ValueError("injected")

            self._node.model.advance = advance  # type: ignore[method-assign]
        elif moment and not (PHASE == "run" and ACT == "exception"):
            strike()
    original_handle(self, data)


def obey(self: Any, order: dict[str, Any]) -> None:
    """The keeper's."""
    starts = order["do"] == "start"
    Counted.count += starts
    due = starts and (
        Counted.count > PLAN["point"] if PHASE == "start" else PHASE == "recovery" and order["name"] in Counted.seen
    )
    if starts:
        Counted.seen.add(order["name"])
    if due and PLAN["late"]:
        original_obey(self, order)
    if due:
        strike()
    if not (due and PLAN["late"]):
        original_obey(self, order)


def frame(self: Writer, payload: bytes) -> bytes:
    """What is sent, spoiled once or always late."""
    if ACT == "delayed":
        time.sleep(Counted.random.uniform(0.0, PLAN["late_s"]))
    if Counted.process != (WHO if WHO != "coordinator" else ""):
        return original_frame(self, payload)
    Counted.frames += 1
    due = Counted.frames > PLAN["point"] and once("struck")
    if due and ACT == "held back":
        time.sleep(PLAN["held_s"])
    if due and ACT in ("lost", "doubled"):  # the number of a frame that nobody sees, or has seen
        self._next += 1 if ACT == "lost" else -1 if self._next else 1
    made = original_frame(self, payload)
    place = Counted.random.randrange(len(made))
    if due and ACT == "cut":
        return made[:place]
    if due and ACT == "damaged":
        return made[:place] + bytes([made[place] ^ 1 << Counted.random.randrange(8)]) + made[place + 1 :]
    return made


original_frame = Writer.frame
if PHASE == "frame":
    Writer.frame = frame  # type: ignore[method-assign]
original_take, original_handle, original_obey = (
    Ticket.take,
    participant.Participant.handle,
    process_manager._Keeper.execute,
)
if WHO == "keeper":
    process_manager._Keeper.execute = obey  # type: ignore[method-assign]
    signal.signal(signal.SIGUSR2, lambda *_: strike())
if PLAN:
    node_process.Ticket = type("Ticket", (), {"take": staticmethod(take)})  # type: ignore[misc]
    participant.Participant.handle = handle  # type: ignore[method-assign]
