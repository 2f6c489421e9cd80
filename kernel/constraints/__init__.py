"""Constraint rows: scalar constraint equations of joints that close loops, of rigid ropes and of contacts.

loop_closures     rows for the directions that each joint type locks
row_structure     which rows a scene has and which of them couple; rows of loops and rigid ropes at one instant
rows              all rows at one instant: Delassus matrix G H^-1 G^T, multipliers, corrections
block_matrix      the Delassus matrix of loops and ropes, factorised in blocks; factors of trees that rows use
complementarity   which one-sided rows are active: pivoting (LCP); multipliers of redundant rows
contact           rigid contact with friction
"""

from heavylift.kernel.on_demand import face

face(__name__)
