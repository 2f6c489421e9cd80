"""Flexible bodies: linear elastic modes in a floating frame that moves freely.

beam, modes              finite elements; their modes, rounded so that they are equal on every processor
small_deflections        limits of the theory: deflections and rotations within a body
buckling                 compression
attachment               frames carried by the modes at a place; the kinetic energy of a flexible body
tracks                   constants of the kinetic energy; modes at stations and along a beam, for sliders
"""

from heavylift.kernel.on_demand import face

face(__name__)
