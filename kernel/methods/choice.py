"""Choice of a method by its name, and of fixed or controlled steps."""

from collections.abc import Callable
from math import isfinite
from typing import get_args

from heavylift.kernel.description.mechanics import MethodName, RemovedMethod
from heavylift.kernel.errors import KernelError
from heavylift.kernel.model.program import Program

from .control import Control, ErrorControl, FixedStep
from .explicit import DormandPrince5, DormandPrince8, Kutta4, SemiImplicitEuler
from .method import AtRest, Method
from .radau import Radau5

METHODS: dict[str, Callable[[Program], Method]] = {
    "semi-implicit-euler": lambda program: SemiImplicitEuler(program),
    "rk4": lambda program: Kutta4(),
    "dopri5": lambda program: DormandPrince5(),
    "dop853": lambda program: DormandPrince8(),
    "radau5": lambda program: Radau5(program),
}
REMOVED = dict.fromkeys(get_args(RemovedMethod), "radau5")  # names in older scenes, and what runs instead
SHORTEST = 1e-9  # [s] a fixed step: the resolution of event times


def choose(name: str, program: Program) -> Method:
    """Return the integration method with this name; raises KernelError for an unknown name."""
    if name == AtRest.name:
        return AtRest()
    if name not in METHODS | REMOVED:
        raise KernelError(
            f"method '{name}': there is no method with this name; choose one of {', '.join(get_args(MethodName))}"
        )
    return METHODS[REMOVED.get(name, name)](program)


def control_of(method: Method, step: float | None, program: Program) -> Control:
    """Return the step control of a method, with fixed steps of `step` [s] if given.

    Raises KernelError for an impossible step, and without step for a method without an error estimate.
    """
    if step is None:
        if method.exponents is None:
            raise KernelError(
                f"method '{method.name}': it has no error estimate and needs a fixed step, such as 0.001 s"
            )
        return ErrorControl(method.exponents, program.nq + program.nv)
    if not (isfinite(step) and step >= SHORTEST):
        raise KernelError(f"step {step:g} s: a fixed step must be at least {SHORTEST:g} s and finite")
    return FixedStep()
