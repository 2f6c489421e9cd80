"""A scene as plain data: its names resolved, its numbers in SI units; needs neither NumPy nor pydantic.

plan              machines, rig and everything else that node processes are built from
mechanism         a machine made of parts: its system, hooks, ties, loads, cells, shapes
bending           the body of a block, rigid or as a beam
interlock         what stops a machine by itself
user_models               models of a user's own: what they hear and lead
actions, verbs    orders, conditions and actions; the verbs, a row each
places            where in a scene an action or an order stands
spellings         words that stay as they have always been spelled
pulses            ramps that leave no swing
fidelity, planar  how much is modelled, and for what a scene asks; what a planar motion locks
factors           those between a load at rest and a design load
limit             a row of the table of limits; something that was found
shapes            what collides and what is drawn
"""

from heavylift.kernel.on_demand import face

face(__name__)
