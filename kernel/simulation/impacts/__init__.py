"""Impacts: instantaneous changes at an event by impulses, and the contacts and rigid ropes that are active afterwards.

active_sets           the next set of contacts and rigid ropes: impulses first, then forces
unilateral            contacts and ropes that may push or pull at an event; which of them touch
coulomb               friction around the pivoting solver; contacts that slip together
regularised_friction  friction of places whose loads are individually undetermined; projected Gauss-Seidel
condensed             rows of contacts without the loops
rope_impacts          rigid ropes that snap taut
"""

from heavylift.kernel.on_demand import face

face(__name__)
