"""What goes wrong in one process of a run: imported there, it waits for its moment and strikes once.

The environment says who is struck, how, in which phase and at which message (kills.py).  Everybody imports this: the
coordinator before it begins, the keeper with what it preloads, the nodes with the keeper.
"""

from __future__ import annotations

import itertools
import json
import os
import resource
import signal
import sys
import threading
import time
from pathlib import Path
from typing import Any, ClassVar

from heavylift.coordinator import participants
from heavylift.coordinator.participants import node_process, participant
from heavylift.coordinator.protocol import messages as m
from heavylift.coordinator.supervision import keeper
from heavylift.coordinator.transport.session import Ticket

PLAN: dict[str, Any] = json.loads(os.environ.get("HEAVYLIFT_INJECT", "{}"))
WHO, PHASE, ACT = (PLAN.get(word, "") for word in ("who", "phase", "act"))
MEASURED = "detection, recovery, replay:"  # what the coordinator says of a successor [s]
ROOM_bytes = 1 << 20  # that a process without memory still gets


def once(what: str) -> bool:
    """Whether this has not happened in any process yet."""
    try:
        os.close(os.open(f"{PLAN['folder']}/{what}", os.O_CREAT | os.O_EXCL))
    except FileExistsError:
        return False
    return True


def hit(number: int) -> None:
    """Send this process a signal, and note when."""
    note()
    signal.raise_signal(number)


def note() -> None:
    """Keep the moment of a blow for those who measure how long it takes to see it."""
    Path(PLAN["folder"], "blow").write_text(str(time.monotonic()))


def strike() -> None:
    """Do what is planned to this process, now or, if the system does it, a random moment later."""
    if not once("struck"):
        return
    signals = {"KILL": signal.SIGKILL, "STOP": signal.SIGSTOP, "SEGV": signal.SIGSEGV}
    if ACT in signals:
        late = threading.Timer(PLAN["delay"], hit, [signals[ACT]])
        late.start() if PLAN["delay"] and WHO != "keeper" else hit(signals[ACT])
        return
    note()
    if ACT == "exit(0)":
        os._exit(0)
    if ACT == "memory":
        pages = int(open("/proc/self/statm").read().split()[0])  # noqa: SIM115
        room = pages * resource.getpagesize() + ROOM_bytes
        resource.setrlimit(resource.RLIMIT_AS, (room, room))
        bytearray(64 << 20)
    raise RuntimeError("injected")


def lose(node: str) -> None:
    """Kill this process, so that there is something to recover from."""
    if once(f"lost {node}"):
        hit(signal.SIGKILL)


class Counted:
    """The process, and the grants of its nodes; the starts that the keeper was ordered, and of whom."""

    process, count, epoch = "", 0, 0
    seen: ClassVar[set[str]] = set()


def take() -> Ticket:
    ticket = original_take()
    Counted.process, Counted.epoch = ticket.process, ticket.epoch
    if ticket.process == WHO and PHASE == "start" and PLAN["point"] == 0:
        strike()
    return ticket


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
        }[PHASE]
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


original_take, original_handle, original_obey = Ticket.take, participant.Participant.handle, keeper._Keeper.obey
if WHO == "keeper":
    keeper._Keeper.obey = obey  # type: ignore[method-assign]
    signal.signal(signal.SIGUSR2, lambda *_: strike())
if PLAN:
    node_process.Ticket = type("Ticket", (), {"take": staticmethod(take)})  # type: ignore[misc]
    participant.Participant.handle = handle  # type: ignore[method-assign]


def coordinate() -> None:
    """The coordinator: tell when processes were lost and came back; strike, or let the keeper be struck, in time."""
    from heavylift.coordinator.run import conversation, models
    from heavylift.coordinator.supervision.failover import Succession
    from heavylift.coordinator.supervision.processes import Processes

    participants.PRELOAD = (*participants.PRELOAD, "injected")  # type: ignore[assignment]
    preload = models._preload
    models._preload = lambda reference: [*preload(reference), "injected"]
    seen: dict[str, tuple[float, float]] = {}  # when a process was struck, and when that was noticed
    there: dict[str, tuple[float, float, float]] = {}  # and when its successor had joined
    sent = 0
    send, on_loss, on_join, go_on = Succession.send, Succession.on_loss, Succession.on_join, Succession._go_on
    give_up = Processes.give_up
    dismiss = conversation.Conversation.dismiss

    def due(hub: Succession | None) -> None:
        if WHO == "coordinator":
            strike()
        elif WHO == "keeper" and hub is not None and once("signalled"):
            os.kill(hub._crew._keeper.pid, signal.SIGUSR2)

    def sends(self: Succession, node: str, payload: bytes) -> None:
        nonlocal sent
        kind = m.kind(payload)
        sent += kind == "grant"
        send(self, node, payload)
        greets = WHO == "coordinator" and kind == "welcome"
        if sent >= PLAN["point"] if PHASE == "run" else PHASE == "start" and greets:
            due(self)

    def loses(self: Succession, process: str, how: str) -> None:
        if WHO == "coordinator" and PHASE == "recovery" and not PLAN["late"]:
            strike()
        now, blow = time.monotonic(), Path(PLAN["folder"], "blow")
        seen[process] = float(blow.read_text()) if blow.exists() else now, now
        on_loss(self, process, how)

    def gives_up(self: Processes, how: str) -> None:
        """With the keeper all is lost, and only now that is known."""
        if not self._lost:
            now = time.monotonic()
            seen.update({process: (struck, now) for process, (struck, _) in list(seen.items())})
        give_up(self, how)

    def joins(self: Succession, process: str) -> None:
        if process in seen:
            there[process] = *seen.pop(process), time.monotonic()
        on_join(self, process)
        if WHO == "coordinator" and PHASE == "recovery" and PLAN["late"] and self.epoch(process) > 1:
            strike()

    def goes_on(self: Succession, node: str, life: Any) -> None:
        go_on(self, node, life)
        process = self.placement.process_of[node]
        if process in there and all(self._lives[other].ready for other in self.placement.hosted[process]):
            at = [*there.pop(process), time.monotonic()]
            print(MEASURED, *(f"{b - a:.3f}" for a, b in itertools.pairwise(at)), process, file=sys.stderr)

    def dismisses(self: conversation.Conversation, end: Any) -> Any:
        if PHASE == "exit" and not PLAN["late"]:
            due(self._hub)  # type: ignore[arg-type]
        left = dismiss(self, end)
        if PHASE == "exit":
            due(self._hub)  # type: ignore[arg-type]
        return left

    Succession.send, Succession.on_loss, Succession.on_join = sends, loses, joins  # type: ignore[method-assign]
    Succession._go_on, Processes.give_up = goes_on, gives_up  # type: ignore[method-assign]
    conversation.Conversation.dismiss = dismisses  # type: ignore[method-assign]
    if WHO == "coordinator" and PHASE == "start" and PLAN["point"] == 0 and ACT in ("KILL", "STOP", "SEGV"):
        PLAN["delay"] = PLAN["start_delay"]
        strike()


if __name__ == "__main__":
    import injected

    injected.coordinate()
    from heavylift.coordinator.cli import main

    sys.exit(main())
