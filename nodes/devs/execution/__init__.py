"""The abstract simulator of Parallel DEVS.

simulator              the simulation loop over logical times: outputs, delivery, transitions
flatten, bags          coupled models replaced by atomic models with routes; delivery of messages; the schedule
transitions            records of transitions; checks of promised lookaheads; calls of output functions
rules                  checks of the rules that a model can break while it runs
canonical              conversion of states to bytes that contain no code, and back
"""

from heavylift.kernel.on_demand import face

face(__name__)
