"""One run of a compiled scene: steps, located events, commands, samples, in integer time.

simulation           the life of a run, made of the parts that follow
events               located, looked at, taken
commands, commanded  what may be told to a run, and who is told
integrator           steps: tentative, committed, forced to an instant
recorder             samples, checked on the way; rests
held_rows            constraint rows: closed at the start, impulses at events
snapshots            all that the future depends on, to go on from
call_order           which calls may follow upon each other
shared_loads         the warning of loads that rigid bodies do not determine
native               native functions and state: step, location, sample
assembly, impacts    loops closed at the start and kept closed; what happens in no time at an event
safeguards           what is refused, calmed or warned of
"""

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from .simulation import FOREVER_NS, Simulation

__all__ = ["FOREVER_NS", "Simulation"]


def __getattr__(name: str) -> Any:
    """The public names, imported when they are first used; the module of the run has the name of this package."""
    if name not in __all__:
        raise AttributeError(f"module '{__name__}' has no attribute '{name}'")
    from importlib import import_module

    return getattr(import_module(".simulation", __name__), name)
