"""Construction of the plan from the keys of a scene file.

scene_builder                       data that the builders of machines share
signals                             measured signals in conditions, interlocks and user models
machines, beams, supports           cranes with girders or with frames of `rig`, these frames, blocks; the fidelity
limiting                            the table of limits
mechanism, elastic, ropes, laws, checking: mechanisms and machines: bodies, joints, ropes, laws
weighing                            loads at the start, which the passes of model levels need
environment                         vessels in waves; floor and obstacles
rigging                             hooks of all machines, with their slings and frames
targets, resolve, levelling         the action list, with names resolved
"""

from heavylift.kernel.on_demand import face

face(__name__)
