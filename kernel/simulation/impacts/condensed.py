"""Constraint rows of contacts at an event, with the joints that close loops eliminated.

A loop's rows push and pull as needed, so that they follow from the contacts' impulses or forces: a Schur complement of
the rows' matrix, in plain arrays and a fixed order.
"""

import numpy as np
from heavylift.kernel.constraints.complementarity import eliminate

SOFT = 1e-10  # regularisation of joints that close loops, relative


def part(values: np.ndarray, rows: list[int]) -> np.ndarray:
    """Return the values of the given constraint rows; 0 for row -1, which stands for a missing tangent row."""
    wide: np.ndarray = np.append(values, 0.0)[rows] if rows else np.zeros(0)
    return wide


class Condensed:
    """Constraint rows of contacts, with the rows of loop joints eliminated by a Schur complement."""

    def __init__(self, A: np.ndarray, b: np.ndarray, rows: list[int], loops: list[int]) -> None:
        self._rows, self._loops = rows, loops
        wide = np.pad(A, ((0, 1), (0, 1)))  # row -1 stands for a tangent that does not exist
        self.A, self.b = wide[np.ix_(rows, rows)], part(b, rows)
        if loops:
            L = A[np.ix_(loops, loops)]
            L = L + SOFT * float(np.diag(A).max()) * np.eye(len(loops))  # a loop may repeat what joints hold already
            side = wide[np.ix_(loops, rows)]
            columns = [eliminate(L, c, np.ones(len(loops))) for c in (*side.T, b[loops])]
            self._by, self._first = np.reshape(columns[:-1], (len(rows), len(loops))).T, columns[-1]
            down = wide[np.ix_(rows, loops)]
            for k in range(len(loops)):
                self.A = self.A - down[:, k, None] * self._by[k]
                self.b = self.b - down[:, k] * self._first[k]

    def after(self, x: np.ndarray) -> np.ndarray:
        w = self.b
        for k in range(len(x)):
            w = w + self.A[:, k] * x[k]
        return w

    def impulses(self, x: np.ndarray, n: int) -> np.ndarray:
        """Return the impulses of all n constraint rows, given those of the contact rows [N s]."""
        out = np.zeros(n + 1)
        out[self._rows] = x
        if self._loops:
            for k, row in enumerate(self._loops):
                out[row] = -float(self._first[k]) - sum(float(e) for e in self._by[k] * x)
        return out[:n]
