"""How processes on other hosts take part in a run.

listener                          where others may connect, and who may join
certificates                      keys and certificates of both sides
remote_node                       the process on the other host

`transport.placement` defines which process hosts which nodes; HOSTS.md explains all of it step by step.
"""

from heavylift.kernel.on_demand import face

face(__name__)
