"""Traced functions on the constraint rows of one scene.

projection   onto the rows: one Newton step of positions and velocities, weighted with the inertia.  It runs
             where a step is accepted, so that drift never accumulates, and for every sample, so that samples
             are consistent; assembly repeats it
surveying, kicking   the rows' matrix for the pivoting solver; impulses along the rows
halted       joints locked in motion: the state after the impulse (see `joint_locking`), with its heat and work
"""

import numpy as np
from heavylift.kernel.algebra.spatial import join
from heavylift.kernel.compiler.function import Function
from heavylift.kernel.compiler.symbol import Value
from heavylift.kernel.methods.method import StepState
from heavylift.kernel.model.evaluation import Evaluation, evaluate
from heavylift.kernel.model.program import Program
from heavylift.kernel.multibody.motion import rates


def projection(program: Program) -> Function:
    """Create the function t, y, P -> place: y on the constraints; gap, slip (n,) before; pivot (n,), see
    `ConstraintRows.pivots`."""

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


def surveying(program: Program) -> Function:
    """Create the function t, y, P -> delassus (n * n,), velocities `speed` and free accelerations `free` (n,) of all
    rows."""

    def body(t: Value, y: Value, P: Value) -> dict[str, Value]:
        rows = evaluate(program, t[0], y, P, t[1]).constraint_rows()
        return {
            "delassus": rows.entries(),
            "speed": rows.held([r.rate for r in rows.rows]),
            "free": rows.held(rows.free),
        }

    return Function("survey_rows", body, {"t": 2, "y": program.ny, "P": len(program.parameters.initial)})


def kicking(program: Program) -> Function:
    """Create the function t, y, P, x -> after: y after impulses x (n,) of the rows [N s]."""

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
    """Evaluate the function of `surveying` at (t, y) into the block."""
    x = f(t=[s.t, inside], y=s.y, P=P)
    s.delassus, s.speed, s.free = x.delassus, x.speed, x.free


def kick(s: StepState, P: Value, f: Function) -> None:
    """Apply the block's impulses to its state."""
    s.y = f(t=[s.t], y=s.y, P=P, x=s.impulse).after


def halted(x: Evaluation) -> Value:
    """Return the state (ny,) with all locked joints at rest; heat and work of the impulses are in the accounts."""
    p = x.program
    v, accounts = list(x.v), dict(zip(p.accounts, x.accounts, strict=True))
    locks = {lock.joint: lock.name for lock in p.system.locks}
    drives = {p.driven(d)[1]: d.name for d in p.system.drives}
    for i, (tree, shared) in enumerate(p.instances):
        if not tree.locked_dofs:
            continue
        out = shared.halt(q=x.q[tree.q], v=x.v[tree.v], P=x.numbers("tree", str(i)))
        v[tree.v] = list(out.after)
        for k, impulse in zip(tree.prescribed_dofs, out.impulse, strict=True):
            n, speed = tree.v.start + k, x.v[tree.v.start + k]
            if k in tree.locked_dofs:
                joint = p.graph.links[tree.first + tree.body_of_dof[k]].joint.name
                account, work = ("heat", locks[joint]), -0.5 * impulse * speed
            else:
                account, work = ("work", drives[n]), impulse * speed
            accounts[account] = accounts[account] + work
    return join(x.q, v, list(accounts.values()), x.counted)
