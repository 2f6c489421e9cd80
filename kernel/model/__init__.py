"""The equations of one scene: what a description is compiled to.

checks               what a description must fulfil
parameters           where each number of a scene lives in the block P
program              layout of state, parameters, guards and accounts; the functions that trees share
traced_functions     what equal parts share; code_structure: what scenes share that have the same code
instant              a scene at one instant, as the stages of an evaluation fill it
evaluation           laws, constraint rows, accelerations; the list of stages, with what each reads and writes
group_loads          loads on a base or about a joint, by weights and rope pulls
quantities           formulas of what thresholds guard and samples hold
switching            discrete states of laws, and what changes when a guard has fallen
references           what actuators follow: profiles, masters, time histories of signals
wave_pieces          irregular waves as cubic pieces
tangent_stiffness    derivatives of the accelerations along all coordinates
reactions            constraint Jacobian at a pose, mobility, joint reactions
"""

from heavylift.kernel.on_demand import face

face(__name__)
