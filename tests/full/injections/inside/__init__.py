"""Faults inside the processes of a run: moments of nodes, keeper and coordinator, and the fault itself.

striking, nodes, coordinator   the blow; who waits for its moment
command                        the command `heavylift` with all that imported
"""
