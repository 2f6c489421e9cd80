"""Rigid contact with friction: where bodies touch, and which contacts push, stick and slide.

describe               contacts and their shapes as plain data
candidates             what could touch, as a fixed list of witnesses per pair of shapes
frames, pairs          contact point, normal and tangents with their rates; the table of pairs of shapes
slots                  the rows, guards and heat of what touches, inside an evaluation
rounds, pivoting,
complementarity        the pivoting solver: linear complementarity with boxes, one text for floats and machine code
coulomb, sweeps        friction around it: the set of contacts that push, stick and slide
regularised            what many places hold together, and whether they slip as a whole
unilateral, touching   what may push at an event: slots of contacts, rigid ropes; who touches
sets, condensed,
impact                 the next set at an event, of contacts and rigid ropes together: impulses first, then forces
"""
