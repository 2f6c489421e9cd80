"""A scene whose joints are locked in motion: the state after the impulse (see `joint_locking`), with its heat and
work."""

from __future__ import annotations

import numpy as np
from heavylift.kernel.algebra.spatial import join
from heavylift.kernel.compiler.symbol import Value
from heavylift.kernel.model.evaluation import Evaluation
from heavylift.kernel.model.program import Program

__all__ = ["halted", "moving_drive"]


def moving_drive(program: Program, v: np.ndarray) -> str:
    """The first prescribed drive that is in motion, "" if none."""
    drives = (d for d in program.system.drives if d.kind == "prescribed")
    return next((d.name for d in drives if v[program.driven(d)[1]] != 0.0), "")


def halted(x: Evaluation) -> Value:
    """(ny,) the state with all locked joints at rest; heat and work of the impulses are in the accounts."""
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
