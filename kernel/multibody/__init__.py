"""Trees of bodies: their graph, kinematics and equations of motion.

spanning_tree, graph, trees   which joints close loops; numbering and path matrix T; trees of one kind share code
motion, kinematics            motion of one joint by the joint table; motion from the root outwards; bodies alone
dynamics                      composite rigid body and recursive Newton-Euler algorithms; factors of the inertia
continuous_angles             angles over several turns
joint_locking                 fixed joints, and joints locked during a run
flexible, formulations        flexible bodies; embedding, augmented, articulated formulations
"""

from heavylift.kernel.on_demand import face

face(__name__)
