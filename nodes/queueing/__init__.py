"""Parts of queueing models: atomic models to be coupled, from `heavylift.nodes.queueing`.

distributions    random times: fixed, uniform, exponential, triangular, PERT, lognormal, Erlang, empirical
entities         the entities that move through a network, and the order in which they wait
stations         Source, Queue, Delay, Sink
server           Server: equal units with priorities, pre-emption, balking and failures
routing          Branch, Join, Resource (seized and released by entities), Monitor (between two points)
"""

from heavylift.kernel.on_demand import face

face(__name__)
