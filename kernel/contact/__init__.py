"""Rigid contact with friction: where bodies touch, and which contacts push, stick and slide.

candidates        what could touch, as a fixed list of witnesses per pair of shapes
frames            contact point, normal and tangents with their rates; the rows of a contact
complementarity   the pivoting solver: linear complementarity with boxes, one text for floats and machine code
coulomb, sweeps   friction around it: the set of contacts that push, stick and slide
"""
