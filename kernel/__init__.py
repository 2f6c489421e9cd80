"""The multibody kernel: a compiler from described mechanics to machine code, with located events.

describe                          bodies, joints, ropes and laws as plain data; needs no NumPy
graph, trees                      numbering, path matrix T, trees of one kind
joints, motion                    the joint table and what its rows do
kinematics, dynamics, ltdl        the recursion: motion, equations of motion, their sparse factors
laws                              ropes, supports, springs, stops, brakes, drives
locking, resistance               joints locked in mid-run; masses and inertias that are missing
flexible                          beams and finite-element models as modes in a floating frame, sliders on them
forces                            the force table: loads, springs, bushings, wind, sheaves, laws of the user's own
constraints, spanning             loops: rows of closing joints, redundancy, drift, assembly
contact                           rigid contact with friction: witnesses, rows, pivoting solver, impacts
rate, evaluation                  the equations of a scene, written once: placing, applying, then accelerations
symbol, function, emit, native    the same text traced, as LLVM IR, as machine code
methods                           integration methods: tableaus and tiny classes
steps, stepping, columns           one step, one location, one sample as text; native functions of them; sample rows
stepper, commands, simulation      blocks and steps; what may be ordered; the life of a run, with located events
structure, failures                what scenes with the same code share; why a run cannot go on
formulations                      embedding, augmented and articulated beside the recursion
analysis                          inverse dynamics, joint reactions, momentum
equations, errors                 the equations in print, as text and LaTeX; the exception tree of heavylift
"""
