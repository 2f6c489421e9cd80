"""The multibody kernel: compiles the mechanics of a scene to machine code and integrates its motion from event to
event.

From description to code, lowest layer first; each package imports only those above it in this list
    errors, trust, cache   the exception tree of heavylift; whose Python code may run; files of compiled code
    on_demand              public names of a package, imported when they are first used
    version                the version of heavylift, and how files of other versions are handled
    description            bodies, joints, forces and contacts as plain data, without NumPy; the joint table
    compiler               tracing of plain Python, LLVM IR, machine code of this process
    algebra                arithmetic with the same bits on every processor; spatial algebra
    multibody              graph and trees, kinematics, recursive dynamics; flexible bodies; formulations
    forces                 the force table: ropes, springs, supports, stops, brakes, user-defined laws
    constraints            loops, rigid ropes and contacts as rows (Delassus matrix); complementarity
    model                  equations of one scene: parameters, program, evaluation; joint reactions
Simulation and analysis
    methods                integration methods: explicit, implicit, symplectic
    simulation             steps, located events, impacts with friction (Gauss-Seidel), commands, samples of one run
    analysis               equilibrium paths, modes, momentum
    equations              the equations in print, as text and LaTeX
    islands                independent parts of a system, integrated separately
"""

from heavylift.kernel.on_demand import face

face(__name__)
