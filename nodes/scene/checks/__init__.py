"""Impossible scenes and orders, found before anything runs.

geometry         whether a scene fits
orders           orders that cannot be carried out in the state in which they are given, or at all
overloads        limits that are exceeded at rest
findings         what was found, reported once per subject
"""

from heavylift.kernel.on_demand import face

face(__name__)
