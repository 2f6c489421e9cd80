"""What the pivoting solver needs of a scene, and what it does to it: the rows' matrix, and impulses along the rows."""

from __future__ import annotations

from typing import TYPE_CHECKING

from heavylift.kernel.compiler.function import Function
from heavylift.kernel.compiler.symbol import Value
from heavylift.kernel.methods.step_state import StepState
from heavylift.kernel.model.evaluation import evaluate

if TYPE_CHECKING:
    from heavylift.kernel.model.program import Program

__all__ = ["kick", "kicking", "survey", "surveying"]


def surveying(program: Program) -> Function:
    """t, y, P -> delassus (n * n,), velocities `speed` and free accelerations `free` (n,) of all rows."""

    def body(t: Value, y: Value, P: Value) -> dict[str, Value]:
        rows = evaluate(program, t[0], y, P, t[1]).constraint_rows()
        return {
            "delassus": rows.entries(),
            "speed": rows.held([r.rate for r in rows.rows]),
            "free": rows.held(rows.free),
        }

    return Function("survey_rows", body, {"t": 2, "y": program.ny, "P": len(program.parameters.initial)})


def kicking(program: Program) -> Function:
    """t, y, P, x -> after: y after impulses x (n,) of the rows [N s]."""

    def body(t: Value, y: Value, P: Value, x: Value) -> dict[str, Value]:
        rows = evaluate(program, t[0], y, P, forces=False).constraint_rows()
        out = list(y)
        for i, dv in rows.change(x).items():
            first = program.nq + program.instances[i][0].v.start
            for k, du in enumerate(dv, first):
                out[k] = out[k] + du
        return {"after": out}

    sizes = {"t": 1, "y": program.ny, "P": len(program.parameters.initial), "x": len(program.constraints)}
    return Function("kick_rows", body, sizes)


def survey(s: StepState, P: Value, f: Function, inside: Value) -> None:
    """Fill the block with what `surveying` finds at (t, y)."""
    x = f(t=[s.t, inside], y=s.y, P=P)
    s.delassus, s.speed, s.free = x.delassus, x.speed, x.free


def kick(s: StepState, P: Value, f: Function) -> None:
    """Apply the block's impulses to its state."""
    s.y = f(t=[s.t], y=s.y, P=P, x=s.impulse).after
