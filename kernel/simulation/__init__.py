"""One run of a compiled scene in integer time: steps, located events, commands, samples.

simulation           the run as a whole, made of the following parts
events               events: located, previewed, taken
commands             commands to a run, and the interface of their receivers
integrator           steps: tentative, committed, forced to an instant
recorder             samples and their checks; periods of rest
held_rows            constraint rows: closed at the start, impulses at events
snapshots            complete states from which a run can continue
call_protocol        the allowed sequence of calls
shared_loads         warning of loads that rigid bodies do not determine
native               native code and state: step, projection onto the constraints (no Baumgarte), location of events
assembly, impacts    loops closed at the start and kept closed; impulses at events (Delassus, Gauss-Seidel)
safeguards           refusals, damping and warnings
"""

from typing import TYPE_CHECKING

from heavylift.kernel.on_demand import face, on_demand

if TYPE_CHECKING:
    from .simulation import FOREVER_NS, Simulation

__all__ = ["FOREVER_NS", "Simulation"]
__getattr__ = on_demand(__name__)

face(__name__)
