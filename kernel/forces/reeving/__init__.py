"""Ropes over sheaves and edges, with friction.

law       the entry of the force table
groups    the parts that move together, and what strains them
nodes     sheaves, edges and ends as numbers; where a rope lies at the start
sheaves   geometry over sheaves: tangents and arcs
edges     geometry along edges, unrolled
parallel  edges of several bodies
"""

from .law import ReevingAt, ReevingLaw
from .nodes import NODE
from .parallel import check_parallel

__all__ = ["NODE", "ReevingAt", "ReevingLaw", "check_parallel"]
