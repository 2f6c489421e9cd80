"""The time protocol: conservative Parallel DEVS in one round trip per decision; no input or output, no clock.

core                the coordinator's decisions
node                the node's side: runs a `Steppable` under grants
messages, distance  what both say, with what holds for each; path lookahead, what is known of a node
invariants          what holds for every HELLO and DONE, row by row
outside             events of an operator, who is no node; both sides in one loop, for tests and trials

The numbered steps with their proof, and the invariants of the messages, stand in PROTOCOL.md.
"""

from heavylift.kernel.on_demand import face

face(__name__)
