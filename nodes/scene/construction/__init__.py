"""From the keys of a scene file to its plan.

scene_builder                         what the builders share
signals                      what is measured: in conditions, by interlocks, by models of a user's own
machines, beams, supports      cranes with girders or with frames of `rig`, the frames, blocks; the fidelity
limiting                     the table of limits
mechanism, elastic, ropes, laws, checking      `mechanism:`, machines: bodies, joints, ropes, laws
weighing                     how machines hang at the start, for the passes of their levels
environment                  vessels in waves; floor and obstacles
rigging                      hooks of all machines, and what hangs on them
targets, resolve, levelling                 the action list with its names resolved
"""

from heavylift.kernel.on_demand import face

face(__name__)
