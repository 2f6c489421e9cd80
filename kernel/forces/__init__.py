"""Forces: one entry of the force table each.

table, force_law        the force table; what the kernel asks of a kind of force
ropes                   elastic ropes over straight lines; what the ends of a rope bear of its mass
joint_laws              springs, stops, brakes of joints; contact that only pushes, sticks and slips; points on pads
radiation               radiation of waves by floating bodies
catenary, mooring       mooring lines with stretch and seabed
springs, loads          springs, dampers and bushings; loads that are given, and wind; actuator laws given as data
streams                 wind and current on vessels by coefficients
reeving                 ropes over sheaves and edges, with friction
user_laws, mathematics  laws of the user's own, and what they may compute with
"""

from heavylift.kernel.on_demand import face

face(__name__)
