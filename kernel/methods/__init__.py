"""Integration methods: tableaus as data, and tiny classes that turn one into the stages and the dense output of a step.

tableaus, dop853         coefficients with order and source
method                   what every method tells: stages, interpolant, stability
explicit, semi_implicit  Runge-Kutta pairs; symplectic Euler
control                  error-controlled and fixed steps

Acceptance of steps, location of guards, commits and samples are the same for all and stand in `kernel.stepping`.
"""

from .choice import METHODS, choose
from .method import Method

__all__ = ["METHODS", "Method", "choose"]
