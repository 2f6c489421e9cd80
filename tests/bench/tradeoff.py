"""Is `accuracy:` kept?  Random lifts, each on the rung that is chosen for it, against the richest rung in other code.

    python tests/bench/tradeoff.py [--scenes 200] [--seed 1] [--minutes 30] [--json]

The generator and its ranges: tests/fidelity/random_lifts.py.  One line per row: name, value, target, met.  The other
code has two lumps a rope; how far four and tighter steps change it: tests/full/test_the_reference_has_converged.py.
The cost of the richest rung is that of our own code on it, four lumps a rope, with method and tolerance that are chosen
for it by what the scene asks; what an implicit method does in matrices counts as evaluations
(nodes/fidelity/STEPS.md).
"""

import argparse
import json
import os
import sys
import time
from collections import Counter
from concurrent.futures import ProcessPoolExecutor
from itertools import repeat
from pathlib import Path
from statistics import median

os.environ["OPENBLAS_NUM_THREADS"] = "1"
sys.path.insert(0, str(Path(__file__).parents[1] / "fidelity"))

ACCURACIES = (0.1, 0.03, 0.01, 0.003)
GAINED, GAIN = 0.01, 10.0  # at this accuracy the richest rung runs, too, and costs that many times as much
WORKERS = 2


def one(seed, deadline):
    """What became of one scene at each accuracy, or why nothing did; None after the deadline."""
    from kept import judged, reference

    if time.monotonic() > deadline:
        return None
    try:
        true = reference(seed)
        return [judged(seed, accuracy, true, against=accuracy == GAINED) for accuracy in ACCURACIES]
    except Exception as error:  # one scene that cannot be judged must not hide the others
        return f"{seed}: {type(error).__name__}: {error}"


def rows(found, lost):
    """(name, value, target, met)"""
    yield "scenes judged", len(found), 200, len(found) >= 200
    for accuracy, at in zip(ACCURACIES, zip(*found, strict=True), strict=True):
        kept, worst = sum(j.worst <= 1.0 for j in at) / len(at), max(j.worst for j in at)
        yield f"kept at {accuracy:.1%}", kept, 0.95, kept >= 0.95
        yield f"worst error / accuracy at {accuracy:.1%}", worst, 3.0, worst <= 3.0
        if accuracy == GAINED:
            gain, plain = (median(x) for x in zip(*((j.richest / j.cost, j.without_algebra) for j in at), strict=True))
            yield f"median gain at {accuracy:.1%}, evaluations x states", plain, GAIN, plain >= GAIN
            yield "the same with the linear algebra of implicit steps", gain, GAIN, gain >= GAIN
        yield f"median cost at {accuracy:.1%}", median(j.cost for j in at), None, True
    costs = [median(j.cost for j in at) for at in zip(*found, strict=True)]
    yield "median cost falls with the accuracy", costs, None, costs == sorted(costs)
    falling = sum([j.cost for j in scene] == sorted(j.cost for j in scene) for scene in found) / len(found)
    yield "scenes whose own cost never rises as less is asked", falling, None, True
    everything = [j for scene in found for j in scene]
    rungs = Counter(j.rung for j in everything)
    yield "rungs", dict(rungs.most_common()), 3, len(rungs) >= 3
    fired = Counter(rule for scene in found for rule in {r for j in scene for r in j.left_out})
    for rule, n in sorted(fired.items()):
        yield f"scenes in which '{rule}' fired", n / len(found), 0.05, n >= 0.05 * len(found)
    yield "scenes that could not be judged", lost, 0, not lost


def main():
    """Run, print."""
    options = argparse.ArgumentParser()
    options.add_argument("--scenes", type=int, default=200)
    options.add_argument("--seed", type=int, default=1)
    options.add_argument("--minutes", type=float, default=30.0, help="no scene is begun later")
    options.add_argument("--json", action="store_true")
    given = options.parse_args()
    first, deadline = 1000 * given.seed, time.monotonic() + 60.0 * given.minutes
    with ProcessPoolExecutor(WORKERS) as pool:
        found = [x for x in pool.map(one, range(first, first + given.scenes), repeat(deadline)) if x is not None]
    lost = [x for x in found if isinstance(x, str)]
    for name, value, target, met in rows([x for x in found if not isinstance(x, str)], lost):
        row = {"name": name, "value": value, "target": target, "met": met}
        print(json.dumps(row) if given.json else f"{name:<45} {value}   target {target}   {'met' if met else 'MISSED'}")


if __name__ == "__main__":
    main()
