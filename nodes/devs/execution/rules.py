"""Rules that a model can break while it runs, and the sentences that it ends with: path, tag, what to do."""

from collections.abc import Iterable
from typing import NoReturn

from heavylift.kernel.description.user_code import raised
from heavylift.kernel.errors import HeavyliftError, ModelError, error_text
from heavylift.nodes.devs.events import Instant, Tag
from heavylift.nodes.devs.models import Atomic

LIMIT = 10_000  # microsteps at one time that are taken for a loop, unless a run is reported otherwise
LONGER = ", or allow more microsteps (a scene's key microsteps, heavylift devs --microsteps)"
TAIL = 32  # microsteps before the limit whose models are named as the loop


class MicrostepLimit:
    """Ends zero-time loops: from `start` on it records the atomics that stop time from advancing, and names them at the
    limit."""

    def __init__(self, microsteps: int) -> None:
        """Raise ModelError unless `microsteps` is a number > 0 within the range of microsteps."""
        if type(microsteps) is not int or not 0 < microsteps < 2**31:
            raise ModelError(
                f"microsteps={microsteps!r}: the limit of microsteps at one time must be an int > 0, and < 2**31"
            )
        self.microsteps, self.start = microsteps, microsteps - TAIL
        self._seen: set[str] = set()
        self._t = -1

    def watch(self, tag: Instant, paths: Iterable[str]) -> None:
        """Who moves at a late microstep."""
        t, k = tag
        if t != self._t:
            self._t, self._seen = t, set()
        self._seen.update(paths)
        if k >= self.microsteps:
            raise ModelError(
                f"{', '.join(sorted(self._seen))} at {Tag(t, k)}: zero-time loop, {self.microsteps} microsteps in "
                f"which no time passes; let one of them hold for more than 0 ns{LONGER}"
            )


def fail(m: Atomic, tag: Instant, what: str, error: BaseException) -> NoReturn:
    """Raise a one-line error for an exception in a model's function; exceptions that end the program pass."""
    ends = not isinstance(error, Exception) and type(error).__module__.startswith("heavylift.")
    if ends or isinstance(error, KeyboardInterrupt):
        raise error
    sentence = error_text(error, 10_000) if isinstance(error, HeavyliftError) else f"{what}() raised {raised(error)}"
    raise ModelError(f"{m.path} at {Tag(*tag)}: {sentence}") from error
