"""Trees of bodies: their graph, how they move, their equations of motion.

spanning_tree, graph, trees   which joints close loops; numbering and path matrix T; trees of one kind share code
motion, kinematics            what a row of the joint table does; motion from the root outwards; bodies alone
dynamics                      recursive equations of motion and their inverse; factors of the joint-space inertia
continuous_angles             angles that go on beyond half a turn
joint_locking                 joints that do not move: fixed ones, and those locked in mid-run
flexible, formulations        flexible bodies; embedding, augmented, articulated formulations
"""

from heavylift.kernel.on_demand import face

face(__name__)
