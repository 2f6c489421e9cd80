"""What is simulated, as plain data: imports neither NumPy nor the rest of the kernel.

mechanics                     System: bodies, joints, masters, measured values, thresholds
laws                          ropes, supports; springs, stops, brakes, drives and locks of joints
forces, contacts, flexible    force elements; rigid contacts; what makes a body flexible
joint_table                   everything the kernel knows of a joint type
signals                       scalars that can be sampled for models that listen
points                        places that all of these are described with
profile                       trapezoid profiles that drives, winches and masters follow
field_types, flexible_checks  what every field must hold; what a flexible body must fulfil
name_order, names, notes      the order of names, what they refer to; non-fatal warnings of a run
user_code                     modules of the user, as they stand in their files
"""

from heavylift.kernel.on_demand import face

face(__name__)
