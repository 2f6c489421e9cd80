"""Supervision of node processes: they are started, watched, replaced when they die, and ended; a run survives their
loss.

processes, process_manager       start and end them; the small process that forks them
os_limits           states of processes, limits of the system, progress of overdue processes
failover                replacement of a lost process; incarnation: log of a node, replayed to its replacement
journal                 a file that a killed process leaves readable; ticket files of external processes
hash_seed               one hash seed for all processes
pool                    processes that run calls in parallel

CRASHES.md states what a run survives.
"""

from heavylift.kernel.on_demand import face

face(__name__)
