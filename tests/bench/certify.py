"""Do the bars of `run --certify` hold?  Random lifts of every kind, each certified, against ropes of four lumps.

    python tests/bench/certify.py [--json] [--short] [--scenes 200] [--seed 1] [--minutes 28]

A lift is run as its scene says, as it asks to 5 % or 1 %, or, one in ten, with rigid ropes; what is true is the richest
spatial rung with steps at 1e-8.  A figure is covered if its error is within numerical and model bar together; a lift is
if all its figures of a quantity are.  Lifts that run with lumps themselves would be judged by the rung that made their
bar: they are left out, and counted.  Lower bounds are those of Clopper and Pearson (1934), one-sided, 95 %.
"""

import os
import sys
import time
from collections import defaultdict
from concurrent.futures import ProcessPoolExecutor
from itertools import repeat
from pathlib import Path
from statistics import median

os.environ["OPENBLAS_NUM_THREADS"] = "1"
sys.path.insert(0, str(Path(__file__).parents[1] / "nodes/fidelity"))
from shared.rows import SHORT, options, row

ASKED = (
    [],
    ["ask=[rope tension, swing, position]", "accuracy=5 %"],
    ["ask=[rope tension, swing, position]", "accuracy=1 %"],
)
RIGID = ["fidelity={ropes: rigid, slings: rigid}", "accuracy=1 %"]
LUMPS, TRUE, LONGEST = (3, 1e-7, 60.0) if SHORT else (4, 1e-8, 90.0)  # of the reference: lumps, tolerance, seconds
SCENES, FIRST = (1, 28) if SHORT else (200, 1000)
WORKERS = 1 if SHORT else 2


def one(seed, deadline):
    """(errors with bars by quantity, figures without a bar, CPU of the certificate over that of the run), or why a lift
    is not judged; None after the deadline."""
    import msgspec
    from heavylift.coordinator.tradeoff.playing import play
    from heavylift.coordinator.ladder.certificate import certifying, richer
    from heavylift.coordinator.uncertainty.figures import figures
    from heavylift.kernel.errors import HeavyliftError
    from heavylift.nodes.scene import parse
    from lifts_of_kinds import lift_of_kinds

    if time.monotonic() > deadline:
        return None
    try:
        scene = parse(lift_of_kinds(seed).text, overrides=RIGID if seed % 10 == 9 else ASKED[seed % 3])
        if scene.plan.fidelity.ropes == "massive":
            return "runs with lumps itself"
        own = play(scene.plan, LONGEST)
        rich = richer(scene.plan)
        rung = msgspec.structs.replace(rich.fidelity, lumps=LUMPS)
        true = play(msgspec.structs.replace(rich, fidelity=rung, tolerance=TRUE), LONGEST)
    except HeavyliftError as error:
        return f"{seed}: {error}"
    with certifying(scene, at_once=0) as runs:
        found = runs.certificate(figures(own.shown, "m"))
    exact = {f.name: f for f in figures(true.shown, "m")}
    errors, bare = defaultdict(list), 0
    for bar in found.bars:
        if bar.name not in exact or bar.numerical is None or bar.model is None:
            bare += 1
        else:
            errors[bar.quantity].append((abs(bar.value - exact[bar.name].value), bar.numerical + bar.model))
    return dict(errors), bare, found.cpu_s / own.cpu_s


def bound(covered, n):
    """Lower bound of a share, one-sided, 95 %."""
    from scipy.stats import beta

    return float(beta.ppf(0.05, covered, n - covered + 1)) if covered else 0.0


def told(found):
    """Rows of all lifts."""
    row("lifts judged", len(found), at_least=200)
    pooled, lifts = [], []
    for quantity in sorted({q for errors, _, _ in found for q in errors}):
        each = [errors[quantity] for errors, _, _ in found if errors.get(quantity)]
        pooled += [pair for pairs in each for pair in pairs]
        kept = sum(all(error <= bar for error, bar in pairs) for pairs in each)
        lifts += [(kept, len(each))]
        row(f"{quantity}: lifts covered", kept / len(each), at_least=0.95)
        row(f"{quantity}: lower bound", bound(kept, len(each)), at_least=0.92)
        row(f"{quantity}: median half-width / true error", ratio(pair for pairs in each for pair in pairs))
    covered = sum(error <= bar for error, bar in pooled)
    row("figures covered", covered / len(pooled), at_least=0.95)
    whole = sum(all(e <= b for pairs in errors.values() for e, b in pairs) for errors, _, _ in found)
    row("lifts with all figures covered", whole / len(found), at_least=0.95)
    row("lifts with all figures covered: lower bound", bound(whole, len(found)), at_least=0.92)
    row("median half-width / true error", ratio(pooled), at_most=4.0)
    row("worst error / half-width", max(error / bar for error, bar in pooled))
    row("figures without a bar", sum(bare for _, bare, _ in found) / (len(pooled) + sum(b for _, b, _ in found)))
    row("median CPU of a certificate / its run", median(cost for _, _, cost in found))


def ratio(pairs):
    """Median of half-width over error."""
    return median(bar / max(error, 1e-300) for error, bar in pairs)


def main():
    """Run, print."""
    given = options(
        __doc__,
        {
            "--scenes": {"type": int, "default": SCENES},
            "--seed": {"type": int, "default": FIRST // 1000},
            "--minutes": {"type": float, "default": 28.0, "help": "no scene is begun later"},
            "--workers": {"type": int, "default": WORKERS},
        },
    )
    first, deadline = 1000 * given.seed + FIRST % 1000, time.monotonic() + 60.0 * given.minutes
    with ProcessPoolExecutor(given.workers) as pool:
        found = [x for x in pool.map(one, range(first, first + given.scenes), repeat(deadline)) if x is not None]
    lost = [x for x in found if isinstance(x, str)]
    if judged := [x for x in found if not isinstance(x, str)]:
        told(judged)
    lumped = sum(x.startswith("runs with") for x in lost)
    row("lifts left out, which run with lumps", lumped)
    row("lifts that could not be judged", len(lost) - lumped, at_most=0)
    print("".join(f"{x}\n" for x in lost if not x.startswith("runs with")), end="", file=sys.stderr)


if __name__ == "__main__":
    main()
