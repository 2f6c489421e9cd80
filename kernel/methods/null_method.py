"""No steps at all: the equations as they are, for statics, with the least code around them."""

from __future__ import annotations

import numpy as np
from heavylift.kernel.compiler.symbol import Value
from heavylift.kernel.methods.step_state import Rate, StepState

from .method import Attempt, Exponents, Method


class Stepless(Method):
    """A method whose steps native code does not take, if it takes any; the kernel knows its interpolant only."""

    native = False
    order = evaluations = 0
    exponents = Exponents(0.0, 0.0, 0.0)

    def attempt(self, s: StepState, rate: Rate, h: Value, among: Value) -> Attempt:
        raise AssertionError("it has no native steps")

    def keep(self, s: StepState, h: Value, a: Attempt) -> None:
        raise AssertionError("it has no native steps")

    def amplification(self, J: np.ndarray, h: float, nq: int) -> np.ndarray:
        raise AssertionError("it has no fixed steps")


class AtRest(Stepless):
    """A method of which nothing but evaluations is asked; one-sided laws are smooth beyond their guards."""

    name = "at-rest"
    vectors = ()

    def interpolate(self, s: StepState, x: Value) -> Value:
        return s.d0
