"""Comparison of a recorded run with the measured log of a real crane.

mapping          assignment of log columns to channels of a recording, with units and uncertainty
validation       clock offset of the log; comparison errors and their uncertainty, after ASME V&V 20
estimation       inputs of the scene, fitted to the log as far as it determines them
measuring        the whole comparison of one recording with one log
"""

from heavylift.kernel.on_demand import face

face(__name__)
