"""What an operator asks of a run, and what the run answers: one query on its control key, one reply."""

from __future__ import annotations

from pathlib import Path
from typing import Literal

import msgspec
from heavylift.coordinator.transport.keys import key
from heavylift.coordinator.transport.session import operator_session
from heavylift.kernel.errors import ProtocolError

from .announce import Found, find

__all__ = ["Order", "Reply", "order"]

PATIENCE_s = 30.0  # for the reply: a command waits for the time at which it can be given
STEP_s = 86400.0  # the same for a step, which takes as long as it takes


class Order(msgspec.Struct, frozen=True, omit_defaults=True):
    """Pause, go on, stop; step `by_ns` [ns] or (None) to the next event; give a command; go `factor` times as fast."""

    do: Literal["pause", "continue", "stop", "step", "command", "rate"]
    by_ns: int | None = None
    text: str = ""
    factor: float = 1.0


class Reply(msgspec.Struct, frozen=True):
    """One sentence; whether it was done."""

    done: bool
    said: str


def order(run: str | Path | Found, what: Order) -> str:
    """Send an order to a run that goes on; returns what it answers, raises ProtocolError if it refuses."""
    found = run if isinstance(run, Found) else find(str(run))
    patience = STEP_s if what.do == "step" else PATIENCE_s
    with operator_session(found.directory) as session:
        control = key(found.notice.run, "control")
        replies = session.get(control, payload=msgspec.msgpack.encode(what), timeout=patience)
        for reply in replies:
            if reply.ok is not None:
                answer = msgspec.msgpack.decode(reply.ok.payload.to_bytes(), type=Reply)
                if not answer.done:
                    raise ProtocolError(answer.said)
                return answer.said
    raise ProtocolError(f"run {found.notice.run} has not answered within {patience:.0f} s; it ended, or it hangs")
