"""Time of one forward dynamics of a chain of n hinged links in each of the paper's formulations, in machine code.

    python tests/bench/formulations.py [--json] [--short] [--long]

Every formulation is traced and compiled alike (straight code, run-time parameters, strict IEEE), so the clock compares
algorithms and nothing else; operations are counted in the traced graph.  Because zeros fold away, the augmented
formulation is a *sparse* solver here, as ADAMS has it; its textbook form, one dense KKT matrix, is timed with LAPACK
(`numpy.linalg.solve`, the solution alone, without building the matrix).  Times are minima of ten runs, in one process.
The growth is the exponent p of n^p between the last two lengths.
"""

import math
import time

import numpy as np
from heavylift.kernel.algebra import join
from heavylift.kernel.compiler import Function, Library, While, module, select
from heavylift.kernel.description import WORLD, Body, Joint, System
from heavylift.kernel.multibody import Tree, build_graph, cut, with_numbers
from heavylift.kernel.multibody.formulations import FORMULATIONS
from shared.rows import SHORT, options, row

LENGTHS = {
    "recursive": (1, 2, 4, 8, 16, 24),
    "articulated": (1, 2, 4, 8, 16, 24),
    "embedding": (1, 2, 4, 8, 16),
    "augmented": (1, 2, 4, 8, 16),
}
DENSE = (4, 8, 16, 24)
CALLS, RUNS = (100, 2) if SHORT else (2000, 10)
PAPER = 2.0  # "2 to 20 times faster" than others
CONTROL = 2  # run, calls left


def chain(n: int) -> Tree:
    """n links, hinged about axes askew, with full inertias."""
    bodies, joints = [], []
    random = np.random.default_rng(n)
    for i in range(n):
        A = random.normal(size=(3, 3))
        inertia = A @ A.T + 3.0 * np.eye(3)
        axis = random.normal(size=3)
        axis /= np.linalg.norm(axis)
        bodies.append(Body(f"b{i}", 10.0 + i, (0.5, 0.1, 0.2), tuple(map(tuple, inertia.tolist()))))
        on = f"b{i - 1}" if i else WORLD
        joints.append(Joint(f"j{i}", "revolute", on, f"b{i}", (1.1, 0.2, 0.3), axis=tuple(axis.tolist())))
    return cut(build_graph(System(tuple(bodies), tuple(joints))), set())[0]


def function(tree: Tree, formulation: str) -> Function:
    """X = run, calls left, q, v -> the same after one evaluation, nudged so that none can be left out."""
    n = len(tree.bodies)

    def body(X, P):
        q, v = X[CONTROL : CONTROL + n], X[CONTROL + n :]
        t = with_numbers(tree, P)
        _, dv, _ = FORMULATIONS[formulation](t, q, v, np.zeros(n), [np.zeros(6)] * n, 9.80665)
        left = X[1] - 1.0
        return {"X": join([select(left > 0.0, 1.0, 0.0), left], q, v + 1e-12 * dv)}

    return Function("evaluate", body, {"X": CONTROL + 2 * n, "P": len(tree.numbers)})


def measured(n: int, formulation: str) -> tuple[float, int]:
    """Nanoseconds of one evaluation and its operations."""
    tree = chain(n)
    f = function(tree, formulation)
    loop = While("loop", 0, (f,))
    library = Library("", lambda: module(loop, f), cache=False)
    P = np.array(tree.numbers)
    best = math.inf
    for _ in range(RUNS):
        X = np.concatenate([[1.0, CALLS], np.linspace(0.1, 1.0, n), np.linspace(-0.5, 0.5, n)])
        began = time.perf_counter_ns()
        library.call("loop", X, P)
        best = min(best, (time.perf_counter_ns() - began) / CALLS)
        assert np.isfinite(X).all()
    return best, sum(x.op not in ("in", "ret", "slice", "call") for x in f.nodes)


def dense(n: int) -> float:
    """Nanoseconds of LAPACK's solution of one KKT system of a chain: 6n coordinates, 5n rows."""
    size = 11 * n
    random = np.random.default_rng(n)
    A = random.normal(size=(size, size))
    A[6 * n :, 6 * n :] = 0.0
    b = random.normal(size=size)
    return min(_clock(lambda: np.linalg.solve(A, b)) for _ in range(RUNS))


def _clock(f) -> float:
    began = time.perf_counter_ns()
    f()
    return float(time.perf_counter_ns() - began)


def main() -> None:
    given = options(__doc__ or "", {"--long": {"action": "store_true", "help": "the longest chains, too"}})
    lengths = {k: v[:3] if SHORT else v if given.long else v[:-1] for k, v in LENGTHS.items()}
    times: dict[str, dict[int, float]] = {}
    counts: dict[str, dict[int, int]] = {}
    for formulation, ns in lengths.items():
        for n in ns:
            t, count = measured(n, formulation)
            times.setdefault(formulation, {})[n] = t / 1e3
            counts.setdefault(formulation, {})[n] = count
            row(f"{formulation}, chain of {n}", t / 1e3, "us", "recursive", times["recursive"][n])
            row(f"{formulation}, chain of {n}, operations", count, "", "recursive", counts["recursive"][n])
    for n in DENSE:
        if n in times["recursive"]:
            row(f"dense KKT by LAPACK, chain of {n}", dense(n) / 1e3, "us", "recursive", times["recursive"][n])
    for formulation, c in counts.items():
        a, b = sorted(c)[-2:]
        p = math.log(c[b] / c[a]) / math.log(b / a)
        row(f"growth of {formulation}, n = {a} to {b}", p, "power", at_most={"articulated": 1.1}.get(formulation))
    n = max(set(times["augmented"]) & set(times["recursive"]))
    row(f"recursive faster than augmented, chain of {n}", times["augmented"][n] / times["recursive"][n], at_least=PAPER)


if __name__ == "__main__":
    main()
