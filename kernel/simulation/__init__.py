"""One run of a compiled scene: steps, located events, commands, samples, in integer time.

simulation           the life of a run, made of the parts that follow
events               located, looked at, taken
commands                  what may be reported to a run, and who is reported
integrator           steps: tentative, committed, forced to an instant
recorder             samples, checked on the way; rests
held_rows            constraint rows: closed at the start, impulses at events
snapshots            all that the future depends on, to go on from
call_protocol           which calls may follow upon each other
shared_loads         the warning of loads that rigid bodies do not determine
native               native functions and state: step, location, sample
assembly, impacts    loops closed at the start and kept closed; what happens in no time at an event
safeguards           what is refused, calmed or warned of
"""

from typing import TYPE_CHECKING

from heavylift.kernel.on_demand import face, on_demand

if TYPE_CHECKING:
    from .simulation import FOREVER_NS, Simulation

__all__ = ["FOREVER_NS", "Simulation"]
__getattr__ = on_demand(__name__, dict.fromkeys(__all__, ".simulation"))

face(__name__)
