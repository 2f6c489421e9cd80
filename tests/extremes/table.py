"""The table of extremes: each case with each integrator gives a right result, a warning, or a refusal.

    python tests/extremes/table.py [--peers] [--page]        prints all cells, or the rows of STABILITY.md

An `Extreme` runs a scene and returns what it measured beside what `independent` says, in units of the bound's scale.
"""

import sys
from math import inf, nan

from cells import INTEGRATORS, PEERS, Cell, cell
from loads_and_swings import empty_hook, massless, on_a_rope, over_the_top, ratio, stiffness, swing
from sudden_events import caught, collinear, freed, meets, not_a_number, redundant, reversal, two_at_once

EXTREMES = (
    *(stiffness(10.0**n) for n in range(-3, 5)),
    *(ratio(10.0**n) for n in (-6, -4, -2, 0, 2, 4, 6)),
    empty_hook(),
    massless("mass"),
    massless("inertia"),
    *(swing(x) for x in (60.0, 90.0, 179.0)),
    over_the_top(),
    swing(30.0, (1e5, -1e5, 1e5), "1e5 m from the origin"),
    on_a_rope(60.0),
    on_a_rope(120.0),
    caught(),
    caught(100.0),
    two_at_once(),
    reversal(),
    freed(),
    redundant(),
    collinear(),
    meets(),
    *(
        not_a_number(what, x)
        for what in ("mass", "EA", "L0", "damping", "q0", "v0", "speed", "force")
        for x in (nan, inf)
    ),
)

WORDS = {
    "does not follow": "refused: swing", "too long for method": "refused: step", "energy balance": "refused: energy",
    "a million steps": "refused: pace",
}  # fmt: skip


def short(c: Cell) -> str:
    """A cell of the page."""
    if c.refusal:
        return next((word for part, word in WORDS.items() if part in c.refusal), "refused")
    return f"{c.error:.1e}{'*' if c.notes else ''}"


if __name__ == "__main__":
    columns = (*INTEGRATORS, *(PEERS if "--peers" in sys.argv else ()))
    page = "--page" in sys.argv
    for x in EXTREMES:
        cells = [cell(x, i) for i in columns if not (page and x.name.endswith((" nan", " inf")))]
        if page and cells:
            print(f"| {x.name} | {' | '.join(map(short, cells))} |", flush=True)
        for i, c in zip(columns, () if page else cells, strict=False):
            print(f"{'ok ' if c.right(i.bound) else 'BAD'} {x.name:<34} {i.name:<14} {c}", flush=True)
