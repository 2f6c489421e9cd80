"""The participants of a run and their description: models that exchange events, and the scenes that define them.

Lowest layer first
    devs       Parallel DEVS: atomic and coupled models, ports, messages, superdense time, the simulator
    plan       a scene after reading, as plain data: machines, actions, limits, fidelity, questions
    models     machines and their commander, one coupled model per node
    statics    the equilibrium path along the action list
    limits     the limits of a lift, and their evaluation
    scene      reads and checks scene files: YAML with units in, a plan in SI units out
Beside them
    scenes     the scenes that come with heavylift, to run and to copy
    zoo        classic DEVS models
    queueing   parts of queueing models
    sea        wave spectra, and hydrodynamics of floating bodies
    yard       the shipyard: blocks, cranes, crews and calendars, from which the delivery of the ship follows
    fmi        co-simulation units (FMUs) as models
    mujoco_models   robots and rigs in MJCF or URDF as mechanics of the kernel; mujoco_shapes: boxes that enclose
                    them; mujoco_tendons: tendons that wrap around geoms
    testing    runs one model by itself, so that a user's model can be tested in three lines
"""

from heavylift.kernel.on_demand import face

face(__name__)
