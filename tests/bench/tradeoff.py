"""Is what is promised kept?  Random lifts of every kind, each on the rung and in the steps that are chosen for it,
against the richest rung in fine steps.

    python tests/bench/tradeoff.py [--json] [--short] [--scenes 200] [--seed 1] [--minutes 28] [--world] [--of FILE ...]

The generator and its kinds: tests/nodes/fidelity/lifts_of_kinds.py; `--world`: lifts_of_the_world.py, by other cranes
and rigging, most of which nothing is promised of.  Every lift is judged: one that fails, or does not
end, is missed.  What is not promised, by a note, is counted apart.  A share has beside it the lower bound of its
confidence interval of 95 % (Clopper and Pearson 1934).  `--of` pools what other seeds have written with `--keep FILE`.
`--short` takes one lift of one hook at one accuracy, beside two lumps in rough steps.
"""

import os
import pickle
import sys
import time
from collections import Counter, defaultdict
from concurrent.futures import ProcessPoolExecutor
from itertools import repeat
from pathlib import Path
from resource import RUSAGE_CHILDREN, getrusage
from statistics import median

os.environ["OPENBLAS_NUM_THREADS"] = "1"
sys.path.insert(0, str(Path(__file__).parents[1] / "nodes/fidelity"))
from scipy.stats import beta
from shared.rows import SHORT, options, row

ACCURACIES = (0.1,) if SHORT else (0.1, 0.03, 0.01, 0.003)
SCENES, FIRST = (1, 20) if SHORT else (200, 0)
UNSAFE, DEAR = 1.5, 1.5  # times the accuracy that a promise may be missed by, and the cost of the plain run
SEEN = 2e-4  # error below which nothing is told of a prediction
WORKERS = 2


def one(seed, deadline, world):
    """What became of one lift at each accuracy, or why nothing did; None after the deadline."""
    from heavylift.kernel import HeavyliftError
    from lifts_of_kinds import lift_of_kinds
    from lifts_of_the_world import lift_of_the_world
    from promised import judged

    if time.monotonic() > deadline:
        return None
    try:
        return judged(seed, ACCURACIES, rough=SHORT, draw=lift_of_the_world if world else lift_of_kinds)
    except HeavyliftError as error:  # one scene that is refused must not hide the others
        return f"{seed}: {type(error).__name__}: {error}"


def least(kept, n):
    """Lower bound of a share at 95 % confidence, from one side."""
    return float(beta.ppf(0.05, kept, n - kept + 1)) if kept else 0.0


def told(found, world):
    """Rows of all that was judged; of a world of cranes most is not promised."""
    few, part = ({}, {}) if world else ({"at_most": 0.25}, {"at_least": 0.05})
    promised = [j for j in found if not j.notes]
    kinds = sorted({kind for j in found for kind in j.kinds})
    lifts = {j.seed: j.kinds for j in found}
    row("lifts judged", len(lifts))
    row("not promised, of all", 1.0 - len(promised) / len(found), **({} if world else {"at_most": 0.1}))
    for kind in kinds:
        mine = [j for j in found if kind in j.kinds]
        row(f"part of the lifts: {kind}", sum(kind in k for k in lifts.values()) / len(lifts), **part)
        row(f"not promised: {kind}", sum(bool(j.notes) for j in mine) / len(mine), **few)
    for accuracy in ACCURACIES:
        at = [j for j in promised if j.accuracy == accuracy]
        kept = sum(j.worst <= 1.0 for j in at)
        row(f"promised at {accuracy:.1%}", len(at))
        row(f"kept at {accuracy:.1%}", kept / max(1, len(at)))
        row(f"kept at {accuracy:.1%}, at least", least(kept, len(at)), at_least=0.985)
        for kind in kinds:
            mine = [j.worst <= 1.0 for j in at if kind in j.kinds]
            if mine and not all(mine):
                row(f"kept at {accuracy:.1%} of {len(mine)}: {kind}", sum(mine) / len(mine), at_least=0.9)
    missed = sorted((j for j in promised if j.worst > 1.0), key=lambda j: -j.worst)
    row(f"missed by more than {UNSAFE} times", sum(j.worst > UNSAFE for j in missed), at_most=0)
    for j in missed:
        what = j.failed or max(j.errors, key=j.errors.get)
        row(f"lift {j.seed} ({', '.join(j.kinds)}) at {j.accuracy:.1%}: {what}; {j.rung}", j.worst)
    _predictions(promised)
    dear = [j.cost / j.plain for j in promised if not j.failed]
    row("cost over the plain run's, median", median(dear))
    row(f"more than {DEAR} times the plain run's cost", sum(x > DEAR for x in dear) / len(dear), at_most=0)
    for accuracy in ACCURACIES:
        at = [j.cost / j.plain for j in promised if j.accuracy == accuracy and not j.failed]
        row(f"cost over the plain run's at {accuracy:.1%}, median", median(at) if at else 0.0)
    for rung, n in Counter(j.rung.rpartition(",")[0] for j in promised).most_common():
        row(f"lifts on {rung}", n / len(promised))


def _predictions(promised):
    """Predicted errors of rung and steps together beside measured ones."""
    pairs = defaultdict(list)
    for j in promised:
        for quantity, error in j.errors.items():
            pairs[quantity].append((j.predicted[quantity], error))
    for quantity, both in pairs.items():
        row(
            f"predicted at least as measured: {quantity}",
            sum(p + SEEN >= e for p, e in both) / len(both),
            at_least=0.99,
        )
        seen = [p / e for p, e in both if e > SEEN]
        row(f"predicted over measured, median: {quantity}", median(seen) if seen else 0.0, at_most=10.0)


def main():
    """Run, or read what was run; print."""
    given = options(
        __doc__,
        {
            "--scenes": {"type": int, "default": SCENES},
            "--seed": {"type": int, "default": 1},
            "--minutes": {"type": float, "default": 28.0, "help": "no scene is begun later"},
            "--workers": {"type": int, "default": WORKERS},
            "--world": {"action": "store_true", "help": "lifts by other cranes and rigging"},
            "--keep": {"type": Path, "help": "file to write what was judged to"},
            "--of": {"type": Path, "nargs": "+", "help": "files to read it from"},
        },
    )
    if given.of:
        found = [j for path in given.of for j in pickle.loads(path.read_bytes())]
    else:
        first, deadline = 1000 * given.seed + FIRST, time.monotonic() + 60.0 * given.minutes
        seeds = range(first, first + given.scenes)
        with ProcessPoolExecutor(given.workers) as pool:
            every = [x for x in pool.map(one, seeds, repeat(deadline), repeat(given.world)) if x is not None]
        spent = getrusage(RUSAGE_CHILDREN)
        row("CPU time of a lift [s]", (spent.ru_utime + spent.ru_stime) / max(1, len(every)))
        found = [j for x in every if not isinstance(x, str) for j in x]
        lost = [x for x in every if isinstance(x, str)]
        row("lifts that could not be judged", len(lost), at_most=0)
        print("".join(f"{x}\n" for x in lost), end="", file=sys.stderr)
    if given.keep:
        given.keep.write_bytes(pickle.dumps(found))
    told(found, given.world)


if __name__ == "__main__":
    main()
