"""Rigid contact with friction: where bodies touch, and the constraint rows of bodies that touch.

candidates       fixed list of contact candidates for each pair of shapes; bound of a step against tunnelling
frames, pairs    contact point, normal and tangents with their rates; the table of pairs of shapes
contact_points   rows, guards and heat of contacts, inside an evaluation
"""

from heavylift.kernel.on_demand import face

face(__name__)
