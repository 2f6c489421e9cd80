"""Impossible scenes and orders, found before anything runs.

geometry         geometry of the scene at the start and along the action list; limits that are exceeded at rest
orders           orders that cannot be carried out in the state in which they are given, or at all
"""

from heavylift.kernel.on_demand import face

face(__name__)
