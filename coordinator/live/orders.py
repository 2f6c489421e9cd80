"""What an operator asks of a run, and what the run answers: one query on its control key and its replies.

A command that waits for a paused run hears of that at once, and of the commander's answer when the run goes on; every
other order has one reply.
"""

from collections.abc import Callable
from pathlib import Path
from typing import Annotated, Literal

import msgspec
import zenoh
from heavylift.coordinator.transport.frame import OPERATOR, key
from heavylift.coordinator.transport.session import guest_session
from heavylift.kernel.errors import UNREADABLE, ProtocolError
from heavylift.kernel.version import __version__, install
from heavylift.nodes.devs import NEVER

from .announce import AnnouncedRun, find

PATIENCE_s = 30.0  # for the last reply: a command waits for the time at which it can be given
STEP_s = 86400.0  # the same for a step, which takes as long as it takes


class Order(msgspec.Struct, frozen=True, omit_defaults=True):
    """Pause, continue, stop; step `by_ns` [ns] or (None) to the next event; give a command; go `factor` times as fast.

    `wait`: while the run is paused a command waits for its answer; otherwise it is told when it will take effect.
    """

    do: Literal["pause", "continue", "stop", "step", "command", "rate"]
    by_ns: Annotated[int, msgspec.Meta(gt=0, le=NEVER)] | None = None
    text: str = ""
    factor: Annotated[float, msgspec.Meta(gt=0.0)] = 1.0
    wait: bool = False


class Reply(msgspec.Struct, frozen=True):
    """One sentence; whether it was done, and when [ns of the simulation]; whether no other reply follows."""

    done: bool
    said: str
    t_ns: int | None = None
    last: bool = True


def order(run: str | Path | AnnouncedRun, what: Order) -> str:
    """Send an order to a run in progress; returns its answer, raises ProtocolError if it refuses."""
    answer = ask(run, what)
    if not answer.done:
        raise ProtocolError(answer.said)
    return answer.said


def ask(
    run: str | Path | AnnouncedRun, what: Order, patience: float = PATIENCE_s, hear: Callable[[str], None] | None = None
) -> Reply:
    """Send an order to a run in progress; returns its last reply, `hear` gets the text of one before.

    Raises ProtocolError if there is no last reply within `patience` [s], which a step does not need.
    """
    found = run if isinstance(run, AnnouncedRun) else find(str(run))
    timeout, said = STEP_s if what.do == "step" else patience, ""
    with guest_session(found.directory, OPERATOR) as session:
        control = key(found.notice.run, "control")
        each = zenoh.ConsolidationMode.NONE  # not the latest reply alone
        for reply in session.get(control, payload=msgspec.msgpack.encode(what), timeout=timeout, consolidation=each):
            if reply.ok is None:
                continue
            try:
                answer = msgspec.msgpack.decode(reply.ok.payload.to_bytes(), type=Reply)
            except UNREADABLE:
                made = found.notice.version
                raise ProtocolError(
                    f"run {found.notice.run} is of heavylift {made} and answers in words that {__version__} does not "
                    f"know; {install(made)} to give it orders"
                ) from None
            if answer.last:
                return answer
            said = answer.said
            if hear is not None:
                hear(said)
    if said:
        raise ProtocolError(f"{what.text}: no answer within {timeout:g} s: {said}")
    told = f"run {found.notice.run} has not answered within {timeout:g} s; it ended, or it hangs"
    late = ", or has not come so far: `heavylift watch` shows whether the commander answers" if what.text else ""
    raise ProtocolError(told + late)
