"""What the text of a step works on: the state block X by name, and what one evaluation of the equations gives."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Protocol

from heavylift.kernel.compiler.symbol import Value

__all__ = ["SCALARS", "Evaluated", "Rate", "StepState"]


class StepScalars(SimpleNamespace):
    """The scalars of X that every method has."""

    # loop flags, then why it stopped, attempts left in this call
    run: Value
    due: Value
    locate: Value
    status: Value
    budget: Value
    # time: now, proposed step, step boundary that no step crosses, horizon behind which steps stay tentative
    t: Value
    h: Value
    t_stop: Value
    until: Value
    # tolerance and its scale, step control, earliest time at which a scene may count as still, what rounding does
    tol: Value
    scale: Value
    h_min: Value
    h_max: Value
    error: Value
    forced: Value
    t_rest: Value
    grain: Value
    faint: Value
    accepted: Value
    rejected: Value
    tentative: Value
    still: Value
    # last step: start, length, bracket of a root, whether only a stage has seen it, status and loop without it
    t0: Value
    h0: Value
    lo: Value
    hi: Value
    doubt: Value
    calm: Value
    more: Value
    # samples: next, period, local time of sample 0 of this stretch, number within the stretch, row, rows allowed
    t_out: Value
    dt_out: Value
    t_base: Value
    count: Value
    row: Value
    rows: Value


SCALARS = tuple(StepScalars.__annotations__)


class StepState(StepScalars):
    """The block X, unpacked, with M and P; a method (see `Method`) and peaks have more of their own."""

    y: Value  # (ny,) state and derivative now, then at the start of the step
    f: Value
    d0: Value
    f0: Value
    T: Value  # (n_ropes,) tensions, the largest since the last sample, and when
    peak: Value
    peak_time: Value
    G: Value  # (n_guards,)
    gap: Value  # (n_rows,) of the constraint rows
    slip: Value
    pivot: Value
    M: Value
    P: Value


class Evaluated(Protocol):
    """Derivative (ny,), tensions (n_ropes,) and guards (n_guards,) of one evaluation.

    Where step control needs them: `drift` of the rows, longest steps `reach` and `window` between shapes.
    """

    dy: Value
    T: Value
    G: Value
    drift: Value
    reach: Value
    window: Value


class Rate(Protocol):
    """The equations: t, a time inside the step, which says which piece of a profile is meant where two meet, and y."""

    def __call__(self, t: Value, among: Value, y: Value) -> Evaluated: ...
