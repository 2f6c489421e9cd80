"""Integration methods: tableaus as data, and tiny classes that turn one into the stages and the dense output of a step.

dop853                   the tableaus: coefficients with order and source
method, choice           what every method tells: stages, interpolant, stability; none, for statics; their names
explicit                 Runge-Kutta pairs; symplectic Euler
radau                    Radau IIA of order 5, for stiff laws and long steps along the equilibrium path
velocity_space           its Newton systems, over the velocities alone
control, stability       error-controlled and fixed steps, scale of tolerances; what fixed steps are refused

Acceptance of steps, location of guards, commits and samples are the same for all and stand in
`kernel.simulation.native.steps`.
"""

from heavylift.kernel.on_demand import face

from .choice import METHODS, choose
from .method import Method

__all__ = ["METHODS", "Method", "choose"]

face(__name__)
