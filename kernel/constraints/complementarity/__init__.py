"""Linear complementarity with boxes, and multipliers of redundant rows.

boxed_lcp         the next active set by block principal pivoting
block_pivoting    one round of it, the same text on floats and in machine code
native_pivoting   its rounds as a native loop
proximal_passes   multipliers of redundant rows: regularisation and passes
"""

from heavylift.kernel.on_demand import face

face(__name__)
