"""Constraint rows: loop joints, their redundancy, drift and assembly.

closures      what each joint type forbids, as rows
factors       one kind of tree, opened up so that rows can use its factors
ropes         rigid ropes: rows that pull only, their switches and impulses
blocks, blockwise    the rows' matrix of loops and ropes, factorised in blocks whose rows are vectors
delassus      the same, entry by entry, where contacts push otherwise than they sense
proximal      what redundant rows get: regularisation and passes
constraints   which rows a scene has, and which of them couple
rows          the rows of a scene at one instant: multipliers, accelerations, corrections
jacobian      rows and freedoms at one pose, scaled so that ranks can be told
starting      the start pose: what was asked stays where it can
projection    one step back onto the constraints
assembly      closing the loops of an initial pose, or saying how wide they gape
"""
