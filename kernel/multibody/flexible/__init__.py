"""Flexible bodies: linear elastic modes in a floating frame that moves freely.

beam, modes              finite elements, rounded to what is equal on every processor; their modes
small_deflections        where the theory ends: deflections and turns within a body
buckling                 compression
attachment               frames carried by the modes at a place; the kinetic energy of a flexible body
tracks                   constants of the kinetic energy; the modes at stations and along a beam, for what slides
"""

from heavylift.kernel.on_demand import face

face(__name__)
