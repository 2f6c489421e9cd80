"""Supervision of node processes: they are started, watched, replaced when they die, and ended; a run survives their
loss.

processes, process_manager       start and end them; the small process that forks them
os_limits           states of processes and limits of the system; whether an overdue process makes progress
failover                replaces a lost process; incarnation: log of a node for its replacement, and replay of it
journal                 a file that a killed process leaves readable; ticket files of external processes
hash_seed               one hash seed for all processes
pool                    processes that run calls in parallel

CRASHES.md states what a run survives.
"""

from heavylift.kernel.on_demand import face

face(__name__)
