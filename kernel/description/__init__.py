"""Plain data that describe a scene's mechanics; imports neither NumPy nor the rest of the kernel.

mechanics                     System: bodies, joints, masters, measured values; the table of joint types
laws                          ropes, supports; springs, stops, brakes, drives and locks of joints
forces, contacts, flexible    force elements; rigid contacts; what makes a body flexible
signals                       scalar quantities that can be sampled and guarded
units                         points and lines; dimension and sign of each number; natural order of names
profile                       trapezoid profiles that drives, winches and masters follow
field_types                   checks of the types of all fields
findings                      checks of a lift, and notes of a run, for all rooms
user_code                     import of the user's modules in their present version
"""

from heavylift.kernel.on_demand import face

face(__name__)
