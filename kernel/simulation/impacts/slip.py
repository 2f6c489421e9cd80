"""Which places of contact can slip away, and which are only at the limit of friction while others hold them.

The force of a contact at several places is indeterminate: some places may reach Coulomb's limit long before the body
moves.  A place slips when what pushes and what sticks elsewhere leaves it free to move along its direction of sliding,
so that a contact slips when no distribution of forces within all cones holds it.
"""

from __future__ import annotations

import numpy as np
from heavylift.kernel.constraints.complementarity.block_pivoting import eliminate

from .coulomb import FrictionSolution

SOFT = 1e-11  # regularisation of redundant rows, relative
HELD = 1e-6  # part of its own mobility below which a place is held by others
REST = 1e-2  # part of the largest acceleration of what slides below which a place is at rest beside it


def mobile(A: np.ndarray, f: FrictionSolution) -> np.ndarray:
    """(m,) whether a place at the limit of friction is free to move along f.u; A: (3m, 3m) Delassus matrix of all."""
    m = len(f.push)
    rows = [3 * i + k for i in range(m) if f.push[i] for k in range(3 if f.stick[i] else 1) if A[3 * i + k, 3 * i + k]]
    out = np.zeros(m, bool)
    if not rows:
        return out
    fixed = A[np.ix_(rows, rows)]
    scale = 1.0 / np.sqrt(np.diag(fixed))
    fixed = fixed * scale[:, None] * scale + SOFT * np.eye(len(rows))
    speeds = np.sqrt(f.w[1::3] * f.w[1::3] + f.w[2::3] * f.w[2::3])
    for i in range(m):
        along = slice(3 * i + 1, 3 * i + 3)
        if not f.push[i] or f.stick[i] or not f.u[i].any() or speeds[i] < REST * speeds.max():
            continue
        response = (A[:, along] * f.u[i]).sum(axis=1)
        own = float((response[along] * f.u[i]).sum())
        side = response[rows] * scale
        held = float((side * eliminate(fixed, side, np.ones(len(rows)))).sum())
        out[i] = own - held > HELD * own
    return out
