"""A real crane beside its model: what its log says of a recorded run.

mapping          which column of a log is which channel of a recording, with units and uncertainty
validation       where in the run the log begins; comparison errors and their uncertainty, after ASME V&V 20
estimation       inputs of the scene that the log tells, and those that it does not
measuring        all of it for one recording and one log
"""

from heavylift.kernel.on_demand import face

face(__name__)
