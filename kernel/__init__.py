"""The multibody kernel: a compiler from described mechanics to machine code, with located events.

describe    bodies, joints, ropes and laws as plain data        (no NumPy: node processes import only this)
graph       numbering and path matrix T                         rate, evaluation    the equations, written once
symbol, function, emit, native    tracing, LLVM IR, machine code          dopri5, stepper, simulation  steps, events, samples
equations   the same text, printed                              errors              the exception tree of heavylift
"""
