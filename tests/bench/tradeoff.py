"""Is `accuracy:` kept?  Random lifts, each on the rung that is chosen for it, against the richest rung in other code.

    python tests/bench/tradeoff.py [--json] [--short] [--scenes 200] [--seed 1] [--minutes 28]

The generator and its ranges: tests/nodes/fidelity/random_lifts.py.  The other code has two lumps a rope; how far four
and
tighter steps change it: tests/full/test_the_reference_has_converged.py.  The cost of the richest rung is that of our
own code on it, four lumps a rope, with method and tolerance that are chosen for it by what the scene asks; what an
implicit method does in matrices counts as evaluations (nodes/fidelity/STEPS.md).
`--short` takes one light lift, and a rough reference.
"""

import os
import sys
import time
from collections import Counter
from concurrent.futures import ProcessPoolExecutor
from itertools import repeat
from operator import lt
from pathlib import Path
from statistics import median

os.environ["OPENBLAS_NUM_THREADS"] = "1"
sys.path.insert(0, str(Path(__file__).parents[1] / "nodes/fidelity"))
from shared.rows import SHORT, options, row

ACCURACIES = (0.1, 0.01) if SHORT else (0.1, 0.03, 0.01, 0.003)
SCENES, FIRST, ROUGHLY = (1, 1, {"rtol": 0.1}) if SHORT else (200, 0, {})
GAINED, GAIN = 0.01, 10.0  # at this accuracy the richest rung runs, too, and costs that many times as much
WORKERS = 2


def one(seed, deadline):
    """What became of one scene at each accuracy, or why nothing did; None after the deadline."""
    from kept import judged, reference

    if time.monotonic() > deadline:
        return None
    try:
        true = reference(seed, **ROUGHLY)
        return [judged(seed, accuracy, true, against=accuracy == GAINED) for accuracy in ACCURACIES]
    except Exception as error:  # one scene that cannot be judged must not hide the others
        return f"{seed}: {type(error).__name__}: {error}"


def told(found):
    """Rows of what was found in all scenes, at all accuracies."""
    row("scenes judged", len(found), at_least=200)
    for accuracy, at in zip(ACCURACIES, zip(*found, strict=True), strict=True):
        kept, worst = sum(j.worst <= 1.0 for j in at) / len(at), max(j.worst for j in at)
        row(f"kept at {accuracy:.1%}", kept, at_least=0.95)
        row(f"worst error / accuracy at {accuracy:.1%}", worst, at_most=3.0)
        if accuracy == GAINED:
            for name, gain, target in (
                ("over the richest rung, evaluations x states", [j.without_algebra for j in at], GAIN),
                ("the same with the linear algebra of implicit steps", [j.richest / j.cost for j in at], GAIN),
                ("over the other code's run, without its linear algebra", [j.reference / j.product for j in at], None),
            ):
                row(f"median gain at {accuracy:.1%}: {name}", median(gain), at_least=target)
        row(f"median cost at {accuracy:.1%}", median(j.cost for j in at))
        for j in sorted((j for j in at if j.worst > 1.0), key=lambda j: -j.worst):
            row(f"lift {j.seed} at {accuracy:.1%}: {max(j.errors, key=j.errors.get)}", j.worst)
    costs = [median(j.cost for j in at) for at in zip(*found, strict=True)]
    rising = sum(map(lt, costs, costs[1:]))
    row("times that the median cost rises from an accuracy to the next", rising, at_least=len(costs) - 1)
    falling = sum([j.cost for j in scene] == sorted(j.cost for j in scene) for scene in found) / len(found)
    row("scenes whose own cost never rises as less is asked", falling)
    rungs = Counter(j.rung for scene in found for j in scene)
    row("rungs", len(rungs), at_least=3)
    for rung, n in rungs.most_common():
        row(f"lifts on {rung}", n / rungs.total())
    fired = Counter(rule for scene in found for rule in {r for j in scene for r in j.left_out})
    for rule, n in sorted(fired.items()):
        row(f"scenes in which '{rule}' fired", n / len(found), at_least=0.05)


def main():
    """Run, print."""
    given = options(
        __doc__,
        {
            "--scenes": {"type": int, "default": SCENES},
            "--seed": {"type": int, "default": 1},
            "--minutes": {"type": float, "default": 28.0, "help": "no scene is begun later"},
        },
    )
    first, deadline = 1000 * given.seed + FIRST, time.monotonic() + 60.0 * given.minutes
    with ProcessPoolExecutor(WORKERS) as pool:
        found = [x for x in pool.map(one, range(first, first + given.scenes), repeat(deadline)) if x is not None]
    lost = [x for x in found if isinstance(x, str)]
    if judged := [x for x in found if not isinstance(x, str)]:
        told(judged)
    row("scenes that could not be judged", len(lost), at_most=0)
    print("".join(f"{x}\n" for x in lost), end="", file=sys.stderr)


if __name__ == "__main__":
    main()
