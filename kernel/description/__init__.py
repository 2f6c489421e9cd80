"""What is simulated, as plain data: imports neither NumPy nor the rest of the kernel.

mechanics                     System: bodies, joints, masters, measured values; the table of joint types
laws                          ropes, supports; springs, stops, brakes, drives and locks of joints
forces, contacts, flexible    force elements; rigid contacts; what makes a body flexible
signals                       scalars that can be sampled for models that listen
units                         places that all of these are described with; what their numbers are; the order of names
profile                       trapezoid profiles that drives, winches and masters follow
field_types                   what every field must hold
findings                      what is found of a lift, checks of it, notes of a run, as every room reads them
user_code                     modules of the user, as they stand in their files
"""

from heavylift.kernel.on_demand import face

face(__name__)
