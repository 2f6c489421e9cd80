"""Integration methods: Butcher tableaus as data, and small classes that compute the stages and the dense output of a
step.

dop853                   the tableaus: coefficients with order and source
method, choice           interface of methods: stages, interpolant, stability; null method for statics; choice by name
explicit                 Runge-Kutta pairs; symplectic Euler
radau                    Radau IIA of order 5, for stiff laws and long steps along the equilibrium path
velocity_space           Newton systems of Radau IIA, reduced to the velocities
control, stability       error-controlled and fixed steps, scale of tolerances; refusal of unstable fixed steps

Acceptance of steps, location of guards, commits and samples are common to all methods: see
`kernel.simulation.native.steps`.
"""

from heavylift.kernel.on_demand import face

from .choice import METHODS, choose
from .method import Method

__all__ = ["METHODS", "Method", "choose"]

face(__name__)
