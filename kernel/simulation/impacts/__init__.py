"""What happens at an event in no time: impulses, then the set of contacts and ropes that act.

active_sets           the next set of contacts and rigid ropes: impulses first, then forces
unilateral, touching  what may push or pull at an event; what touches
coulomb, gauss_seidel friction around the pivoting solver; contact forces one after the other
regularised_friction  friction of places that loads do not determine one by one
condensed, slip       rows of contacts without the loops; contacts that slip as a whole
rope_impacts          rigid ropes that snap taut
"""

from heavylift.kernel.on_demand import face

face(__name__)
