"""Impossible scenes and orders, found before anything runs.

geometry         geometry of the scene at the start and along the action list
orders           orders that cannot be carried out in the state in which they are given, or at all
overloads        limits that are exceeded at rest
findings         findings, reported once per subject
"""

from heavylift.kernel.on_demand import face

face(__name__)
