"""Mathematical functions for user-defined laws, on floats and in traced code alike.

Allowed are also + - * / ** 2 and abs. No `if` on a value (select(condition, a, b) computes both and takes one), no
`math` and no NumPy functions of values; NumPy arrays of values, `@` and slices are fine.
"""

from heavylift.kernel.algebra.elementary import atan2, cos, power, sin
from heavylift.kernel.compiler.symbol import maximum, minimum, select, sqrt

__all__ = ["atan2", "cos", "maximum", "minimum", "power", "select", "sin", "sqrt"]
