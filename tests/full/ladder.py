"""Checks the accuracy of results: random lifts of every kind and crane type, at 10, 3, 1 and 0.3 %.

    python tests/full/ladder.py [--json] [--short] [--lifts 400] [--seed 1] [--minutes 60] [--into FILE.jsonl]

Asked are rope and sling tensions, swing, positions and stage ends; a lift counts as kept if the errors of all its
figures are within the accuracy.  True is the finest level, ropes of sixteen lumps, in steps of 1e-6 or a tenth of those
of the answer.  Beside a share stands the lower bound of its confidence interval of 95 %, one-sided (Clopper and Pearson
1934).  Every second lift is by goliaths (tests/nodes/fidelity/lifts_of_kinds.py), the others by other cranes and
rigging (lifts_of_the_world.py).

Each lift is written when it is checked, a line each; lifts that stand in FILE are not run again, so that what was
broken off is continued, and several processes may write into one file with seeds of their own.
"""

import json
import multiprocessing
import os
import sys
import time
from functools import partial
from pathlib import Path
from statistics import median

os.environ["OPENBLAS_NUM_THREADS"] = "1"
sys.path[:0] = [str(Path(__file__).parents[1] / x) for x in ("nodes/fidelity", "bench")]
from shared.rows import SHORT, options, row  # noqa: E402

ACCURACIES = (0.1, 0.03, 0.01, 0.003)
TRUE = 1e-6  # tolerance of the reference, of which a tenth changes nothing by 1e-5
BEYOND = 3.0  # times the accuracy, none may be
LONGEST = 120.0  # seconds of a run
WORST = 5  # figures of a lift that are reported
TASKS = 25  # lifts that a process judges: what it compiles stays in its memory


def judged(deadline, seed):
    """What became of a lift at each accuracy, or why nothing did; None after the deadline [s of the clock]."""
    from heavylift.kernel import HeavyliftError
    from lifts_of_kinds import lift_of_kinds
    from lifts_of_the_world import lift_of_the_world

    if time.time() > deadline:
        return None
    drawn = (lift_of_the_world if seed % 2 else lift_of_kinds)(seed)
    found = {"seed": seed, "kinds": drawn.kinds}
    began = time.process_time()
    try:
        found |= compared(drawn.text)
    except HeavyliftError as error:  # one scene that is refused must not hide the others
        found["lost"] = f"{type(error).__name__}: {error}"
    return found | {"took_s": time.process_time() - began}


def compared(text):
    """The answers to a scene beside the reference."""
    import msgspec
    from heavylift.coordinator.ladder import Ladder, Measuring, ModelLevel, at_level, choose
    from heavylift.nodes.plan import MEANT, Question
    from heavylift.nodes.scene import parse

    plan = parse(text, passing=True, followed=False).plan
    ladder, measuring = Ladder(plan), Measuring(MEANT, lambda: LONGEST)
    measuring.figures(ModelLevel(plan))
    unasked = measuring.spent[ModelLevel(plan).key].cpu_s
    finest = ladder.candidates(ladder.full[-1])[0].plan
    at = []
    for accuracy in ACCURACIES:
        answer = choose(ladder, Question(MEANT, accuracy), measuring)
        own = at_level(plan, answer.fidelity)
        candidate = ModelLevel(msgspec.structs.replace(own, method=answer.method, tolerance=answer.tolerance))
        true = ModelLevel(msgspec.structs.replace(finest, tolerance=min(TRUE, 0.1 * answer.tolerance)))
        errors = {} if answer.notes else measuring.apart(candidate, true)  # what is not answered may take for ever
        worst = sorted(errors, key=lambda name: -errors[name])[:WORST]
        at.append({
            "accuracy": accuracy, "error": max(errors.values(), default=0.0),
            "said": max(answer.errors.values(), default=0.0), "notes": answer.notes,
            "worst": [(name, errors[name], answer.figures.get(name)) for name in worst],
            "cost": spent.cpu_s / unasked if (spent := measuring.spent.get(candidate.key)) else None,
            "candidate": candidate.name,
        })  # fmt: skip
    return {"at": at, "all": sum(spent.cpu_s for spent in measuring.spent.values()) / unasked}


def least(kept, n):
    """Lower bound of a share at 95 % confidence, from one side."""
    from scipy.stats import beta

    return float(beta.ppf(0.05, kept, n - kept + 1)) if kept else 0.0


def told(found):
    """Rows of all that was checked."""
    row("lifts judged", len(found))
    for i, accuracy in enumerate(ACCURACIES):
        answered = [(x, x["at"][i]) for x in found if not x["at"][i]["notes"]]
        kept = [at for _, at in answered if at["error"] <= accuracy]
        row(f"answered at {accuracy:.1%}", len(answered) / max(1, len(found)), at_least=0.97)
        row(f"kept at {accuracy:.1%} of {len(answered)}", len(kept) / max(1, len(answered)), at_least=0.985)
        row(f"kept at {accuracy:.1%}, at least", least(len(kept), len(answered)), at_least=0.97)
        over = [at["said"] / at["error"] for _, at in answered if at["error"] > 1e-6]
        row(f"said over true at {accuracy:.1%}, median", median(over) if over else 1.0, at_most=5.0)
        costs = [at["cost"] for _, at in answered if at["cost"] is not None]
        row(f"cost of the answer at {accuracy:.1%} over the unasked run, median", median(costs) if costs else 0.0)
    beyond = [at["error"] / at["accuracy"] for x in found for at in x["at"] if not at["notes"]]
    row("answers that are wrong by more than three times the accuracy", sum(x > BEYOND for x in beyond), at_most=0)
    row("worst error over accuracy", max(beyond, default=0.0), at_most=BEYOND)
    row("all runs of the ladder over the unasked run, median", median([x["all"] for x in found] or [0.0]))


def line(x):
    """What is to be said of a lift."""
    name = f"lift {x['seed']} ({', '.join(x['kinds'])}, {x['took_s']:.0f} s)"
    if "lost" in x:
        return f"{name}: {x['lost']}"
    parts = []
    for at in x["at"]:
        if at["notes"]:
            parts.append(f"{at['accuracy']:.1%} not answered: {at['notes'][0]}")
        elif at["error"] > at["accuracy"]:
            worst = "; ".join(f"{n} {e:.2%}, said {s or 0.0:.2%}" for n, e, s in at["worst"])
            parts.append(f"{at['accuracy']:.1%} MISSED by {at['candidate']}: {worst}")
    return f"{name}: {' | '.join(parts) or 'kept'}"


def before(file):
    """Lifts that stand in a file by their seed."""
    lines = file.read_text(encoding="utf-8").splitlines() if file and file.exists() else []
    return {x["seed"]: x for x in map(json.loads, lines)}


def main():
    """Run, print."""
    given = options(
        __doc__,
        {
            "--lifts": {"type": int, "default": 1 if SHORT else 400},
            "--seed": {"type": int, "default": 1},
            "--minutes": {"type": float, "default": 60.0, "help": "no lift is begun later"},
            "--workers": {"type": int, "default": 1},
            "--into": {"type": Path, "default": None, "help": "a file of lines of JSON that is continued"},
        },
    )
    first, deadline = 10_000 * given.seed, time.time() + 60.0 * given.minutes
    wanted, found = range(first, first + given.lifts), before(given.into)
    left = [seed for seed in wanted if seed not in found]
    with multiprocessing.get_context("spawn").Pool(given.workers, maxtasksperchild=TASKS) as pool:
        for x in pool.imap_unordered(partial(judged, deadline), left):
            if x is None:
                continue
            found[x["seed"]] = x
            print(line(x), file=sys.stderr, flush=True)
            if given.into:
                with given.into.open("a", encoding="utf-8") as file:
                    file.write(json.dumps(x) + "\n")
    mine = [found[seed] for seed in sorted(found)]
    told([x for x in mine if "lost" not in x])
    row("lifts that could not be checked", sum("lost" in x for x in mine))


if __name__ == "__main__":
    main()
