"""How processes on other hosts take part in a run.

listener                          where others may connect, and who may join
certificates        by which both sides know each other
remote_node         the process at the other end

Which process hosts which nodes stands in `transport.placement`; HOSTS.md tells it all step by step.
"""

from heavylift.kernel.on_demand import face

face(__name__)
