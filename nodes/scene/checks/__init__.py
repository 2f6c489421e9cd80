"""Checks that find impossible scenes and orders before anything runs.

geometry         geometry at the start and along the action list; static loads that exceed their limits
orders           orders that cannot be carried out in the state in which they are given
"""

from heavylift.kernel.on_demand import face

face(__name__)
