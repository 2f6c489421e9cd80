"""Messages of a run over Zenoh: framed, checked, in order, with nobody else on the bus.

frame               keys on the bus; frames with sender and checksum; the private directory of a run
session             the sessions of a run, and their access rules
hub, link           the coordinator's end and the nodes' end; exchange: their common part, and both in one process
liveness            detection of joined and lost processes
placement           assignment of nodes to processes

SPEED.md states the cost of a message and of a round, layer by layer.
"""

from heavylift.kernel.on_demand import face

face(__name__)
