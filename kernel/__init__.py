"""The multibody kernel: a compiler from described mechanics to machine code, with located events.

What is there
    describe, points, shapes, checks  bodies, joints, ropes and laws as plain data, without NumPy; what they must fulfil
    graph, spanning, trees, merging   numbering, path matrix T, which joints close loops, trees of one kind
    joints, motion, locking           the joint table, what its rows do, joints locked in mid-run
    profile, references               what drives, winches and masters follow
How it moves, written once
    spatial, kinematics, dynamics     spatial algebra; motion from the root outwards; equations of motion
    ltdl, limbs, resistance           their sparse factors; equal branches; masses and inertias that are missing
    laws, forces                      ropes, supports, stops, brakes, drives; the force table, laws of the user's own
    flexible                          beams and finite-element models as modes in a floating frame, sliders on them
    constraints                       loops and rigid ropes: rows, redundancy, drift, assembly, impulses
    contact                           rigid contact with friction: witnesses, rows, pivoting solver, impacts
    parameters, rate, sharing         numbers of a scene in P; its equations; what equal parts share
    placing, applying, evaluation     one evaluation of them: where bodies are, what acts on them, accelerations
How it becomes machine code
    symbol, function, layout          tracing: symbols, functions, named parts of blocks
    elementary                        sin, cos, atan2 and powers that are equal on every processor
    emit, straight, lanes, gather, wide    LLVM IR: modules, functions, equal calls side by side, loops over states
    structure, native, oracle         what scenes with the same code share; machine code; the same text on floats
How it runs
    methods                           integration methods: tableaus and tiny classes
    steps, stepping, columns          a step, a location, a sample as text; native functions of them; sample rows
    blocks, stepper, snapshots        native blocks and steps; states to go on from
    commands, events, simulation      what may be ordered; events, located and fired; the life of a run
    call_order                        which calls may follow upon each other
    switching, samples, failures      discrete states; channels with units; why a run cannot go on
    notes                             what a user must know of one that goes on
What can be asked
    dense                             small linear algebra on Python floats, the same bits on every processor
    analysis, formulations            statics, modes, mobility, reactions, inverse dynamics; formulations to compare
    equations, errors                 the equations in print, as text and LaTeX; the exception tree of heavylift
"""
