"""Flexible bodies: linear elastic modes in a floating frame that moves freely.

beam, modes              finite elements, their modes, shapes at stations
reduction, rounding      the constants of the kinetic energy; how they are rounded
inertia                  those constants in the recursion
small_deflections        where the theory ends: deflections and turns within a body
buckling                 compression
attachment, stations     frames carried by the modes at a place, and at a coordinate that slides
tracks                   the modes along a beam, for what slides on it
"""

from heavylift.kernel.on_demand import face

face(__name__)
