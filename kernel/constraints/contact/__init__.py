"""Rigid contact with friction: where bodies touch, and the rows of what touches.

candidates       what could touch, as a fixed list of witnesses per pair of shapes; how far no shape passes another
frames, pairs    contact point, normal and tangents with their rates; the table of pairs of shapes
contact_points   rows, guards and heat of what touches, inside an evaluation
"""

from heavylift.kernel.on_demand import face

face(__name__)
