"""Force laws: each kind of force is one entry of the force table.

table, force_law        the force table; what the kernel asks of a kind of force
ropes                   elastic ropes over straight lines; the mass of a rope, lumped at its ends
joint_laws              springs, stops, brakes of joints; contact that only pushes, sticks and slips; points on pads
radiation               forces on floating bodies from the waves that they radiate
catenary, mooring       mooring lines with stretch and seabed
tugger                  lines that a winch keeps at a set tension
springs, loads          springs, dampers and bushings; given loads, and wind; actuator laws given as data
streams                 wind and current on vessels by coefficients
reeving                 ropes over sheaves and edges, with friction
user_laws, mathematics  user-defined laws, and the functions that they may use
"""

from heavylift.kernel.on_demand import face

face(__name__)
