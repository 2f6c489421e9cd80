"""Work against precision beside MuJoCo's RK4, on the two-crane scene of 24 degrees of freedom that both can express.

    python tests/bench/work_precision.py [--json]

Both curves are CPU time of 10 s of motion, the least of three runs, over the tension error against the reference
trajectory of `kernel.py`.  At each error the fastest run that is at least as exact counts, whatever its setting; ours
must never be above MuJoCo's.
"""

import numpy as np

import kernel

TOLERANCES = 10.0 ** -np.arange(2.0, 12.1, 0.5)
STEPS = (10, 14, 20, 30, 40, 60, 80, 120, 200, 300, 500, 800, 1200, 2000, 3000)  # a second
RUNS = 3
ERRORS = 10.0 ** -np.arange(2.0, 10.6, 0.5)


def least(runs, error):
    """Milliseconds and setting of the fastest run that is so exact; None if none is."""
    return min(((ms, how) for e, ms, how in runs if e <= error), default=None)


def main():
    ours = [kernel.own_run(method, x) for method in ("dopri5", "dop853") for x in TOLERANCES]
    theirs = [min((kernel.mujoco_run(n) for _ in range(RUNS)), key=lambda run: run[1]) for n in STEPS]
    ratios = []
    for error in ERRORS:
        own, peer = least(ours, error), least(theirs, error)
        if own is None or peer is None:
            continue
        ratios.append(own[0] / peer[0])
        name = f"10 s at a tension error of {error:.0e}, {own[1]}"
        kernel.row(name, own[0], "ms", f"MuJoCo RK4 ({peer[1]})", peer[0], target=1.0)
    name = f"work-precision curve: worst ratio at {len(ratios)} errors"
    kernel.row(name, max(ratios), "", target=1.0)
    exact = "the tightest error that either reaches, ours"
    kernel.row(exact, min(e for e, *_ in ours), "", "MuJoCo RK4", min(e for e, *_ in theirs))


if __name__ == "__main__":
    main()
