"""Ropes over sheaves and edges, with capstan friction (Euler and Eytelwein).

law       the entry of the force table
groups    parts of a rope that slip together, and their strains; edges of several bodies
nodes     sheaves, edges and ends as numbers; initial path of a rope
sheaves   geometry over sheaves: tangents and arcs; geometry along edges, unrolled
"""

from .groups import check_parallel
from .law import ReevingAt, ReevingLaw
from .nodes import NODE

__all__ = ["NODE", "ReevingAt", "ReevingLaw", "check_parallel"]
