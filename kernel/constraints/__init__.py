"""Constraint rows: loop joints, their redundancy, drift and assembly.

closures      what each joint type forbids, as rows
factors       one kind of tree, opened up so that rows can use its factors
blockwise     the same in blocks whose rows are vectors, for loops and ropes
delassus      the rows' matrix, factorised as far as its zeros allow, and its proximal solution
constraints   which rows a scene has, and which of them couple
rows          the rows of a scene at one instant: multipliers, accelerations, corrections
assembly      closing the loops of an initial pose, or saying how wide they gape
"""
