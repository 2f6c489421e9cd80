"""The equations of motion of one scene, compiled from its description.

checks               requirements on a description
parameters           where each number of a scene lives in the block P
program              layout of state, parameters, guards and accounts; the functions that trees share
traced_functions     functions that equal parts share; code_structure: key of scenes with equal code
instant              a scene at one instant, as the stages of an evaluation fill it
evaluation           laws, constraint rows, accelerations; the list of stages, with what each reads and writes
group_loads          loads on a base or about a joint, by weights and rope pulls
quantities           formulas of the signals that thresholds guard and samples contain
switching            discrete states of laws, and their changes when a guard has become negative
references           references of actuators: profiles, masters, time histories of signals
wave_pieces          irregular waves as cubic pieces
tangent_stiffness    derivatives of the accelerations along all coordinates; newton_step: a step toward rest
reactions            constraint Jacobian at a pose, mobility, joint reactions
"""

from heavylift.kernel.on_demand import face

face(__name__)
