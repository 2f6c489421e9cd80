"""The time protocol: conservative Parallel DEVS in one round trip per decision; no input or output, no clock.

core                the coordinator's decisions
node                the node's side: runs a `Steppable` under grants
messages, distance  messages of both sides with their invariants; path lookahead, state of a node at the coordinator
invariants          checks of every HELLO and DONE
outside             events from outside the nodes, such as those of an operator

PROTOCOL.md has the numbered steps with their proof, and the invariants of the messages.
"""

from heavylift.kernel.on_demand import face

face(__name__)
