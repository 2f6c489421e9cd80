"""Moments of a coordinator at which a fault can occur, and its messages about successors."""

from __future__ import annotations

import itertools
import os
import signal
import sys
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from heavylift.coordinator.protocol import messages as m
from heavylift.coordinator.run import conversation
from heavylift.coordinator.supervision import Processes, Succession
from heavylift.coordinator.transport import LocalHub

from injections.inside.nodes import compiles
from injections.inside.striking import ACT, NUMBERS, PHASE, PLAN, WHO, once, strike

MEASURED = "detection, recovery, replay:"  # what the coordinator says of a successor [s]


def coordinate() -> None:
    """The coordinator: tell when processes were lost and came back; strike, or let the keeper be struck, in time."""
    seen: dict[str, tuple[float, float]] = {}  # when a process was struck, and when that was noticed
    there: dict[str, tuple[float, float, float]] = {}  # and when its successor had joined
    sent = 0
    send, on_loss, on_join, go_on = Succession.send, Succession.on_loss, Succession.on_join, Succession._go_on
    begin, give_up = Processes.__init__, Processes.give_up
    sends_here, dismiss = LocalHub.send, conversation.Conversation.dismiss

    def begins(self: Processes, preload: Sequence[str] = (), fork: bool = sys.platform == "linux") -> None:
        begin(self, ["injections.inside.nodes", *preload], fork)

    def due(hub: object) -> None:
        if WHO == "coordinator":
            strike()
        elif WHO == "keeper" and isinstance(hub, Succession) and once("signalled"):
            os.kill(hub._crew._keeper.pid, signal.SIGUSR2)

    def sends(self: Succession, node: str, payload: bytes) -> None:
        nonlocal sent
        kind = m.kind(payload)
        sent += kind == "grant"
        send(self, node, payload)
        greets = WHO == "coordinator" and kind == "welcome"
        if sent >= PLAN["point"] if PHASE == "run" else PHASE == "start" and greets:
            due(self)

    def sends_to_itself(self: LocalHub, node: str, payload: bytes) -> None:
        nonlocal sent
        sent += m.kind(payload) == "grant"
        sends_here(self, node, payload)
        if sent >= PLAN["point"] if PHASE == "run" else PHASE == "start":
            due(None)

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
            due(self._hub)
        left = dismiss(self, end)
        if PHASE == "exit":
            due(self._hub)
        return left

    Succession.send, Succession.on_loss, Succession.on_join = sends, loses, joins  # type: ignore[method-assign]
    Succession._go_on, Processes.give_up = goes_on, gives_up  # type: ignore[method-assign]
    Processes.__init__, LocalHub.send = begins, sends_to_itself  # type: ignore[method-assign]
    conversation.Conversation.dismiss = dismisses  # type: ignore[method-assign]
    if WHO == "coordinator" and PHASE == "compile":
        compiles(strike)
    if WHO == "coordinator" and PHASE == "start" and PLAN["point"] == 0 and ACT in NUMBERS:
        PLAN["delay"] = PLAN["start_delay"]
        strike()
