"""A scene as plain data, with resolved names and numbers in SI units; importing it needs neither NumPy nor pydantic.

plan              the whole plan: machines, actions, limits and everything else that node processes are built from
mechanism         a machine made of parts: its system, hooks, ties, loads, cells, shapes
connections       what hooks, slings, frames and joints of machines connect
bending           the body of a block, rigid or as a beam
interlock         interlocks, which stop a machine without the commander
user_models       models written by users: their signals and set-points
actions, verbs    orders, conditions and actions; the verbs of orders, one row each
places            the file, line and column at which a scene defines an action or an order
pulses            speed ramps that leave no swing
fidelity          model level of the machines, and the results and accuracy that a scene asks for
factors           factors between static load and design load
limit             a row of the table of limits, and its utilisation
shapes            shapes for collision checks and drawings
"""

from heavylift.kernel.on_demand import face

face(__name__)
