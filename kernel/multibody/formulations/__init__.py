"""Formulations of the accelerations of a tree (Ku et al. 2012), each a function with the signature of `dynamics`.

recursive     composite inertias along the paths, H = L^T D L without fill-in: used by the kernel (`dynamics`)
articulated   recursive as well, with articulated inertias and without H: O(n) however deep the tree
augmented     absolute coordinates of all bodies with a row for every constraint: [M J^T; J 0]; embedding: velocity
              transformation, by which constraint forces are projected away, R^T M R dense

All agree to rounding; their costs differ (`tests/bench/formulations.py`).

repeated_subtrees: equal branches share their code
"""

from collections.abc import Callable

from heavylift.kernel.compiler.symbol import Array
from heavylift.kernel.errors import KernelError
from heavylift.kernel.multibody.dynamics import dynamics

from .augmented import articulated, augmented, embedding

__all__ = ["FORMULATIONS", "formulated"]


FORMULATIONS: dict[str, Callable[..., tuple[Array, Array, Array]]] = {
    "recursive": dynamics,
    "articulated": articulated,
    "embedding": embedding,
    "augmented": augmented,
}


def formulated(name: str) -> Callable[..., tuple[Array, Array, Array]]:
    """Return the function that computes accelerations by a formulation; raises KernelError for an unknown name."""
    if name not in FORMULATIONS:
        raise KernelError(f"formulation '{name}' does not exist; choose {', '.join(FORMULATIONS)}")
    return FORMULATIONS[name]
