"""Back onto the constraints: one Newton step of places and speeds, weighted with the inertia.

It runs where a step is accepted, so that drift never accumulates, and for every sample, so that what is shown fits
together; assembly repeats it.  Scenes without rows have no such function.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from heavylift.kernel.compiler.function import Function
from heavylift.kernel.compiler.symbol import Value
from heavylift.kernel.model.evaluation import evaluate
from heavylift.kernel.multibody.motion import rates

if TYPE_CHECKING:
    from heavylift.kernel.model.program import Program

__all__ = ["projection"]


def projection(program: Program) -> Function:
    """t, y, P -> place: y on the constraints; gap, slip (n,) as they were before; pivot (n,) see `Rows.pivots`."""

    def body(t: Value, y: Value, P: Value) -> dict[str, Value]:
        e = evaluate(program, t[0], y, P, forces=False)
        rows = e.constraint_rows()
        gap, slip = rows.held([r.gap for r in rows.rows]), rows.held([r.rate for r in rows.rows])
        place, speed = rows.change(rows.solve([-x for x in gap])), rows.change(rows.solve([-x for x in slip]))
        out = list(y)
        for i, dx in place.items():
            tree = program.instances[i][0]
            for b in tree.bodies:
                at = tree.q.start
                q, u = e.q[at + b.q.start : at + b.q.stop], dx[b.v]
                dq = rates(b.kind, np.array(q), u)
                out[at + b.q.start : at + b.q.stop] = [x + d for x, d in zip(q, dq, strict=True)]
                for k, m in zip(range(b.q_modes.start, b.q_modes.stop), dx[b.v_modes], strict=True):
                    out[at + k] = out[at + k] + m
            first = program.nq + tree.v.start
            for k, du in enumerate(speed[i]):
                out[first + k] = out[first + k] + du
        return {"place": out, "gap": gap, "slip": slip, "pivot": rows.pivots}

    return Function("project", body, {"t": 1, "y": program.ny, "P": len(program.parameters.initial)})
