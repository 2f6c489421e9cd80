"""A scene as plain data: names resolved, numbers in SI units; needs neither NumPy nor pydantic.

plan              machines, rig and everything else from which node processes are built
mechanism         a machine made of parts: its system, hooks, ties, loads, cells, shapes
bending           the body of a block, rigid or as a beam
interlock         interlocks, which stop a machine by themselves
user_models       user models: their signals and set-points
actions, verbs    orders, conditions and actions; the verbs, a row each
places            where in a scene an action or an order is written
pulses            ramps that leave no swing
fidelity          model level, and questions to a run; joints that a planar motion locks
factors           factors between static load and design load
limit             a row of the table of limits; its utilisation
shapes            shapes for collision checks and drawings
"""

from heavylift.kernel.on_demand import face

face(__name__)
