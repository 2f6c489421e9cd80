"""Node processes are started, watched, replaced when they die, and ended; no run ends otherwise for it.

processes, process_manager       start and end them; the small process between
os_limits           what the system says of processes, and must allow; whether one that owes an answer makes progress
failover                replaces a lost process; incarnation: what its successor is reported, and how far it is
journal                 a file that a killed process leaves readable; one by which a program of another kind joins
hash_seed               one seed for the hashes of all processes
pool                    processes of our own that run things side by side

What a run survives stands in CRASHES.md.
"""

from heavylift.kernel.on_demand import face

face(__name__)
