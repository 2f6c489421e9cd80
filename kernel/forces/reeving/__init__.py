"""Ropes over sheaves and edges, with friction.

law       the entry of the force table
groups    the parts that move together, and what strains them; edges of several bodies
nodes     sheaves, edges and ends as numbers; where a rope lies at the start
sheaves   geometry over sheaves: tangents and arcs; geometry along edges, unrolled
"""

from .groups import check_parallel
from .law import ReevingAt, ReevingLaw
from .nodes import NODE

__all__ = ["NODE", "ReevingAt", "ReevingLaw", "check_parallel"]
