"""The multibody kernel: a compiler from described mechanics to machine code, with located events.

What a scene is and how it becomes code, lowest layer first; each imports those above it in this list
    errors, trust, cache   the exception tree of heavylift; whose Python code may run; files of compiled code
    on_demand              public names of a package, imported when they are first used
    version                which heavylift this is, and what to do with what another one has made
    description            bodies, joints, forces and contacts as plain data, without NumPy; the joint table
    compiler               tracing of plain Python, LLVM IR, machine code of this process
    algebra                numbers that are equal on every processor; spatial algebra
    multibody              graph and trees, kinematics, recursive dynamics; flexible bodies; formulations
    forces                 the force table: ropes, springs, supports, stops, brakes, laws of the user's own
    constraints            loops, rigid ropes and contacts as rows; complementarity
    model                  the equations of one scene: parameters, program, evaluation; joint reactions
How it moves and what can be asked of it
    methods                integration methods: explicit, implicit, symplectic
    simulation             steps, located events, impacts with friction, commands, samples, safeguards of one run
    analysis               equilibrium paths, modes, momentum
    equations              the equations in print, as text and LaTeX
    islands                parts that nothing ties together, solved apart
"""

from heavylift.kernel.on_demand import face

face(__name__)
