"""The order in which methods of a simulation may be called, and the errors for calls out of order.

    start -> [settled] -> run ... -> [going on] -> interrupt -> [paused] -> commands -> [stopped] -> settle -> [settled]
                                                -> fire -> [fired] -> commands -> [stopped] -> settle -> [settled]

Commands act at the present time of the simulation: after `start`, `fire`, `interrupt` or `settle`. `fire` and commands
change the forces, so `settle` must follow before time goes on (`run` calls it after an interrupt without commands).
Otherwise a later state would be taken for that of the command, or the command would act only at some later event.
"""

from collections.abc import Sequence
from numbers import Integral

from heavylift.kernel.errors import KernelError

NEW, SETTLED, GOING, PAUSED, FIRED, STOPPED = "new", "settled", "going on", "paused", "fired", "stopped"


class CallProtocol:
    """Checks the order of calls to a simulation; `phase`: one of the phases in the module's diagram."""

    def __init__(self) -> None:
        self.phase = NEW

    def check_new(self, epoch_ns: int) -> None:
        """Raise KernelError if the simulation has already advanced."""
        if self.phase == GOING or epoch_ns > 0:
            raise KernelError("the simulation has already advanced; create another one to begin again")

    def check_begun(self) -> None:
        """Raise KernelError if the simulation was not started."""
        if self.phase == NEW:
            raise KernelError("the simulation has no state yet; start it first")

    def check_settled(self, what: str, epoch_ns: int) -> None:
        """Raise KernelError unless simulation time may advance."""
        self.check_begun()
        if self.phase in (FIRED, STOPPED):
            raise KernelError(
                f"{what} at {epoch_ns * 1e-9:.9g} s: an event or a command has stopped the simulation; "
                "call settle() first"
            )

    def stands_at(self, t_ns: int, epoch_ns: int) -> bool:
        """Return whether the simulation has already stopped at the time of an interrupt.

        Raises KernelError for a call out of order or an invalid time.
        """
        self.check_begun()
        check_time(t_ns)
        if self.phase in (PAUSED, FIRED, STOPPED) and t_ns == epoch_ns:
            return True
        self.check_settled("interrupt", epoch_ns)
        return False

    def check_standing(self, what: str, epoch_ns: int) -> None:
        """Raise KernelError unless the simulation may receive commands now."""
        self.check_begun()
        if self.phase == GOING:
            raise KernelError(
                f"{what} at {epoch_ns * 1e-9:.9g} s: the run has advanced since "
                "then; call interrupt(t_ns) or fire() before, "
                "and settle() after it"
            )

    def command(self, what: str, epoch_ns: int) -> None:
        """Register a command to the simulation; raises KernelError if commands are not allowed now."""
        self.check_standing(what, epoch_ns)
        self.phase = STOPPED


def check_time(t_ns: int) -> None:
    """Raise KernelError for a time that is not a valid integer number of nanoseconds."""
    if not isinstance(t_ns, Integral):
        raise KernelError(f"time {t_ns!r}: it must be a whole number of nanoseconds")


def check_present(t_ns: int, present_ns: int) -> None:
    """Raise KernelError for a time before the present time of the simulation."""
    if t_ns < present_ns:
        raise KernelError(f"time {t_ns} ns is before the present time, {present_ns} ns")


def passed_by(t_ns: int, event_ns: int, names: Sequence[str]) -> KernelError:
    """Return the error for an interrupt requested after the time of an event that must be handled first."""
    what = ", ".join(f"'{name}'" for name in dict.fromkeys(names))
    return KernelError(
        f"time {t_ns} ns: an event of {what} at {event_ns} ns comes before; call fire() and settle() first"
    )
