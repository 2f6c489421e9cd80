"""Messages of a run over Zenoh: framed, checked, in order, with nobody else on the bus.

frame               keys and names on the bus; every message: who says it, undamaged; the private directory of a run
session             the sessions of a run, and who may do what on them
hub, link           the coordinator's end and the nodes' end; exchange: what is shared, both in one process
liveness            which processes have joined, which are lost
placement           which process hosts which nodes

What a message and a round cost, layer by layer, stands in SPEED.md.
"""

from heavylift.kernel.on_demand import face

face(__name__)
