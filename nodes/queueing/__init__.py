"""Parts of queueing models, as atomics to be coupled: `heavylift.nodes.queueing`.

distributions    times that are drawn: fixed, uniform, exponential, triangular, PERT, lognormal, Erlang, of a table
entities         what moves through a network, and the order in which it waits
stations         Source, Queue, Delay, Sink
server           Server: equal units with priorities, pre-emption, balking and failures
routing          Branch, Join, Resource that entities seize and release, Monitor between two points
"""

from heavylift.kernel.on_demand import face

face(__name__)
