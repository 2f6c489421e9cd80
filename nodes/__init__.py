"""What takes part in a run, and how it is described: models that exchange events, scenes that name them.

Lowest layer first
    devs       Parallel DEVS: atomic and coupled models, ports, messages, superdense time, the simulator
    plan       a scene after reading, as plain data: machines, actions, limits, fidelity, questions
    models     machines and their commander, one coupled model per node
    statics    the equilibrium path along the action list
    limits     what a lift must not exceed, and the findings of those who looked
    fidelity   the rules that leave out of a model what a question does not need
    scene      reads and checks scene files: YAML with units in, a plan in SI units out
Beside them
    scenes     the scenes that come with heavylift, to run and to copy
    zoo        classic DEVS models
    yard       blocks, cranes, crews and calendars above the lifts: when the ship is delivered
    fmi        co-simulation units as models
    mujoco_models   robots and rigs in MJCF or URDF as mechanics of the kernel
    testing    drives one model offline, so that a user's model can be tested in three lines
"""

from heavylift.kernel.on_demand import face

face(__name__)
