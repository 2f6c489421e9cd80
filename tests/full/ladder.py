"""Is what is answered kept?  Random lifts of every kind, by all crane types, each asked to 10, 3, 1 and 0.3 %.

    python tests/full/ladder.py [--json] [--short] [--lifts 400] [--seed 1] [--minutes 60]

Asked are rope and sling tensions, swing, positions and stage ends; a lift counts as kept if the errors of all its
figures are within the accuracy.  True is the finest level in steps of 1e-7.  Beside a share stands the lower bound of
its confidence interval of 95 %, one-sided (Clopper and Pearson 1934).  Every second lift is by goliaths
(tests/nodes/fidelity/lifts_of_kinds.py), the others by other cranes and rigging (lifts_of_the_world.py).
"""

import os
import sys
import time
from concurrent.futures import ProcessPoolExecutor
from itertools import repeat
from pathlib import Path
from statistics import median

os.environ["OPENBLAS_NUM_THREADS"] = "1"
sys.path[:0] = [str(Path(__file__).parents[1] / x) for x in ("nodes/fidelity", "bench")]
from shared.rows import SHORT, options, row  # noqa: E402

ACCURACIES = (0.1, 0.03, 0.01, 0.003)
TRUE = 1e-7  # tolerance of the reference
BEYOND = 3.0  # times the accuracy, none may be
WORKERS = 1 if SHORT else 2
LONGEST = 120.0  # seconds of a run


def one(seed, deadline):
    """What became of a lift at each accuracy, or why nothing did; None after the deadline."""
    import msgspec
    from heavylift.coordinator.ladder import Ladder, Measuring, ModelLevel, at_level, choose, play
    from heavylift.kernel import HeavyliftError
    from heavylift.nodes.plan import MEANT, Question
    from heavylift.nodes.scene import parse
    from lifts_of_kinds import lift_of_kinds
    from lifts_of_the_world import lift_of_the_world

    if time.monotonic() > deadline:
        return None
    drawn = (lift_of_the_world if seed % 2 else lift_of_kinds)(seed)
    try:
        plan = parse(drawn.text, passing=True, followed=False).plan
        ladder, measuring = Ladder(plan), Measuring(MEANT, lambda: LONGEST)
        unasked = play(plan, LONGEST).cpu_s
        found = []
        finest = ladder.rungs(ladder.full[-1])[0].plan
        for accuracy in ACCURACIES:
            answer = choose(ladder, Question(MEANT, accuracy), measuring)
            rung = ModelLevel(
                msgspec.structs.replace(
                    at_level(plan, answer.fidelity), method=answer.method, tolerance=answer.tolerance
                )
            )
            true = ModelLevel(msgspec.structs.replace(finest, tolerance=min(TRUE, 0.1 * answer.tolerance)))
            errors = measuring.apart(rung, true)
            name = max(errors, key=errors.get, default="")
            said = max(answer.errors.values(), default=0.0)
            found.append(
                (
                    accuracy,
                    errors.get(name, 0.0),
                    said,
                    answer.notes,
                    name,
                    measuring.spent[rung.key].cpu_s / unasked,
                    rung.name,
                )
            )
        whole = sum(spent.cpu_s for spent in measuring.spent.values())
        return seed, drawn.kinds, found, whole / unasked
    except HeavyliftError as error:  # one scene that is refused must not hide the others
        return f"{seed} {drawn.kinds}: {type(error).__name__}: {error}"


def least(kept, n):
    """Lower bound of a share at 95 % confidence, from one side."""
    from scipy.stats import beta

    return float(beta.ppf(0.05, kept, n - kept + 1)) if kept else 0.0


def told(found):
    """Rows of all that was judged."""
    row("lifts judged", len(found))
    for i, accuracy in enumerate(ACCURACIES):
        at = [(seed, kinds, each[i]) for seed, kinds, each, _ in found]
        answered = [x for x in at if not x[2][3]]
        kept = [x for x in answered if x[2][1] <= accuracy]
        row(f"answered at {accuracy:.1%}", len(answered) / len(at), at_least=0.97)
        row(f"kept at {accuracy:.1%} of {len(answered)}", len(kept) / max(1, len(answered)), at_least=0.985)
        row(f"kept at {accuracy:.1%}, at least", least(len(kept), len(answered)), at_least=0.97)
        over = [said / error for _, _, (_, error, said, *_) in answered if error > 1e-6]
        row(f"said over true at {accuracy:.1%}, median", median(over) if over else 1.0, at_most=5.0)
        row(f"cost of the answer at {accuracy:.1%} over the unasked run, median", median(x[2][5] for x in answered))
        for seed, kinds, (_, error, said, _, name, _, rung) in answered:
            if error > accuracy:
                row(
                    f"lift {seed} ({', '.join(kinds)}) at {accuracy:.1%}: {name}, said {said:.2%}; {rung}",
                    error / accuracy,
                )
        for seed, kinds, (_, _, _, notes, *_) in (x for x in at if x[2][3]):
            print(f"not answered at {accuracy:.1%}: lift {seed} ({', '.join(kinds)}): {notes[0]}", file=sys.stderr)
    worst = max((e / a for _, _, each, _ in found for a, e, _, notes, *_ in each if not notes), default=0.0)
    row("worst error over accuracy", worst, at_most=BEYOND)
    row("all runs of the ladder over the unasked run, median", median(x[3] for x in found))


def main():
    """Run, print."""
    given = options(
        __doc__,
        {
            "--lifts": {"type": int, "default": 1 if SHORT else 400},
            "--seed": {"type": int, "default": 1},
            "--minutes": {"type": float, "default": 60.0, "help": "no lift is begun later"},
            "--workers": {"type": int, "default": WORKERS},
        },
    )
    first, deadline = 10_000 * given.seed, time.monotonic() + 60.0 * given.minutes
    with ProcessPoolExecutor(given.workers) as pool:
        seeds = range(first, first + given.lifts)
        found = []
        for x in (x for x in pool.map(one, seeds, repeat(deadline)) if x is not None):
            print(x if isinstance(x, str) else f"lift {x[0]}: judged", file=sys.stderr, flush=True)
            found.append(x)
    lost = [x for x in found if isinstance(x, str)]
    told([x for x in found if not isinstance(x, str)])
    row("lifts that could not be judged", len(lost))


if __name__ == "__main__":
    main()
