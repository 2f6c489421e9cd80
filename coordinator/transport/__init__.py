"""Messages of a run over Zenoh: framed, checked, in order, with nobody else on the bus.

frame               every message: who says it, in which run, undamaged
session, access     the sessions of a run, and who may do what on them; keys: names on the bus
run_directory       the private directory of a run, with its socket
hub, link           the coordinator's end and the nodes' end; local_hub: both in one process; exchange: what is shared
liveness            which processes have joined, which are lost
placement           which process hosts which nodes

What a message and a round cost, layer by layer, stands in SPEED.md.
"""

from heavylift.kernel.on_demand import face

face(__name__)
