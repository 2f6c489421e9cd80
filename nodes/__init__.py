"""What takes part in a run, and how it is described: models that exchange events, scenes that name them.

devs       Parallel DEVS: atomic and coupled models, ports, messages, superdense time, the simulator
models     cranes, loaders, block, mechanisms and their commander, one coupled model per node
scene      reads and checks scene files: YAML with units in, a plan in SI units out
scenes     the scenes that come with heavylift, to run and to copy
testing    drives one model offline, so that a user's model can be tested in three lines
"""
