"""What the text of a step works on: the state block X by name, and what one evaluation of the equations gives."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Protocol

from heavylift.kernel.compiler.symbol import Value

SCALARS = (
    # control: loop flags, then why it stopped, attempts left in this call
    "run", "due", "locate", "status", "budget",
    # time: now, proposed step, step boundary that no step crosses, horizon behind which steps stay tentative
    "t", "h", "t_stop", "until",
    # tolerance and its scale, step control, earliest time at which a scene may count as still, and what rounding does
    "tol", "scale", "h_min", "h_max", "error", "forced", "t_rest", "grain", "faint",
    "accepted", "rejected", "tentative", "still",
    # last step: start, length, bracket of a root, whether only a stage has seen it, status and loop without it
    "t0", "h0", "lo", "hi", "doubt", "calm", "more",
    # samples: next, period, local time of sample 0 of this stretch, number within the stretch, row, rows allowed
    "t_out", "dt_out", "t_base", "count", "row", "rows",
)  # fmt: skip


class StepState(SimpleNamespace):
    """The block X, unpacked: `SCALARS`, and what peaks and a method (see `Method`) have of their own; M and P."""

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
