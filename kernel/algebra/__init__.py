"""Arithmetic and linear algebra with bit-identical results on every processor; spatial algebra.

elementary           sin, cos, atan2 and powers of additions, multiplications and divisions alone
dense, small_blocks  small matrices on Python floats; blocks of rows in traced text; A = L D L^T without pivoting
arrays               linear algebra on arrays by operations on elements
attitudes            rotations as quaternions, for display and recordings
eigenvalues          largest eigenvalues with their vectors; splines and Chebyshev series
spatial              spatial vectors in world axes about a common point (Featherstone)
"""

from heavylift.kernel.on_demand import face

face(__name__)
