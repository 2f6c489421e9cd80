"""Participants of a run: nodes that consist of models or of the kernel, in processes of their own or in the
coordinator's.

participant              one node from WELCOME to BYE; node_process: a process of some nodes; alive: its sign of life
parts, building          the config that a WELCOME carries, and the model that it names
kernel_node, recorded_kernel   the kernel as a node, also with a recorded history; configuration: the kernel's config
sampling, rows           signals that the kernel sends to subscribed models; receivers of its sample rows
lockstep, session        nodes of one thread without the protocol; a run of a plan by them
mechanics_at             the mechanics of a scene at one instant of a run
external                 nodes that external programs run
isolation                protection of models from side effects between nodes, including globals

Node processes import these modules one by one and nothing else of this room.
"""

from heavylift.kernel.on_demand import face

__all__ = ["NODE_MODULE", "PRELOAD", "PRELOAD_SCENE"]

NODE_MODULE = f"{__name__}.node_process"
PRELOAD = (NODE_MODULE, f"{__name__}.configuration")  # what every node of a scene imports
PRELOAD_SCENE = (*PRELOAD, f"{__name__}.kernel_node")  # its kernel, too

face(__name__)
