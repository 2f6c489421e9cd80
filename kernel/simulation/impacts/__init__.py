"""What happens at an event in no time: impulses, then the set of contacts and ropes that act.

active_sets           the next set of contacts and rigid ropes: impulses first, then forces
unilateral            what may push or pull at an event; what touches
coulomb               friction around the pivoting solver; contacts that slip as a whole
regularised_friction  friction of places that loads do not determine one by one; contact forces one by one
condensed             rows of contacts without the loops
rope_impacts          rigid ropes that snap taut
"""

from heavylift.kernel.on_demand import face

face(__name__)
