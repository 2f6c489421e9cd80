"""Makes kernel/VALIDATION.md: every figure that heavylift is compared with, beside ours.

    python tests/validation/page.py                    computes all cases and writes the page
    python tests/validation/page.py --check [--full]   computes the quick (all) cases and names rows that are not so

A check ends with 1 if a row of the page is not what is computed now.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))
import body_cases
import event_cases
import hoist_cases
import measured_cases
import problem_cases
import static_cases
import swing_cases
from comparison import CASES, Case, Row
from sources import NOT_HAD, TABLES, other_codes

MODULES = (swing_cases, hoist_cases, static_cases, event_cases, body_cases, problem_cases, measured_cases)
PAGE = Path(__file__).parents[2] / "kernel" / "VALIDATION.md"
HEAD = ["| source | quantity | theirs | ours | difference | within |", "|---|---|---|---|---|---|"]
MEASURED = "Published measurements"
INTRODUCTION = """\
# Validation

Results of heavylift compared with closed forms, published problems, worked examples and published measurements.
`python tests/validation/page.py` computes every figure and writes this page; tests check that its rows are still
true. *Difference* is ours minus theirs, relative to theirs (in the unit of the row where theirs is 0). *Within* is
the allowed difference: what the theory neglects, the digits of the source, or the reading error of a measurement.
Differences below a hundredth of it, or below 1e-9, are printed as such. Misses are bold. A source links to the test
of its rows."""
LIMITS = """\
No lift in a shipyard is among the measurements, since no published figures were found
([sources](#sources-not-used)); the measured systems are a laboratory crane, pendulums and a frame on a torsion rod.
Rope damping, sheave efficiency, wind on real blocks and the stiffness of real cranes are not compared with
measurements. The only miss among calculated figures is a misprint; [each miss](#misses) is explained or stated as
unexplained. Extreme scenes: [STABILITY.md](STABILITY.md)."""


def made(computed: Sequence[tuple[Case, list[tuple[Row, str]]]]) -> str:
    """The page, of all cases with their rows."""
    parts = [INTRODUCTION, summary(computed), LIMITS]
    for table, words in TABLES.items():
        lines = [line for case, rows in computed if case.table == table for _, line in rows]
        parts.append("\n\n".join(part for part in (f"## {table}", words, "\n".join([*HEAD, *lines])) if part))
    parts.append(misses(computed))
    text = "The same scene solved by other programs; each bound is the one of the test."
    parts.append("\n\n".join(("## Other codes", text, "\n".join(other_codes()))))
    parts.append(f"## Sources not used\n\n{NOT_HAD}")
    return "\n\n".join(parts) + "\n"


def summary(computed: Sequence[tuple[Case, list[tuple[Row, str]]]]) -> str:
    """How many rows are within, by kind, and which is missed most."""
    lines = ["| | rows | within | missed | largest miss |", "|---|---|---|---|---|"]
    for kind, chosen in (("calculated by others", False), ("measured", True)):
        rows = [(case, row) for case, found in computed for row, _ in found if (case.table == MEASURED) == chosen]
        missed = [(abs(row.difference), case, row) for case, row in rows if row.missed]
        worst = max(missed, key=lambda m: m[0], default=None)
        message = f"{100 * worst[0]:.0f} %: {worst[2].quantity} ({worst[1].source})" if worst else "none"
        lines.append(f"| {kind} | {len(rows)} | {len(rows) - len(missed)} | {len(missed)} | {message} |")
    return "\n".join(lines)


def misses(computed: Sequence[tuple[Case, list[tuple[Row, str]]]]) -> str:
    """Why rows are missed, source by source."""
    message = [
        f"- **{case.source}** ({sum(row.missed for row, _ in rows)} of {len(rows)}): {case.why}."
        for case, rows in computed
        if any(row.missed for row, _ in rows)
    ]
    return "## Misses\n\n" + "\n".join(message)


def stale(case: Case, page: str) -> list[str]:
    """Lines of a case that are not in the page."""
    lines = [line for _, line in case.lines()]
    return [] if "\n".join(lines) in page else [line for line in lines if line not in page] or lines


def main(arguments: Sequence[str]) -> int:
    if unknown := set(arguments) - {"--check", "--full"}:
        print(f"{', '.join(sorted(unknown))}: there are --check and --full", file=sys.stderr)
        return 2
    if "--check" not in arguments:
        PAGE.write_text(made([(case, case.lines()) for case in CASES]))
        print(PAGE)
        return 0
    page = PAGE.read_text()
    wrong = [line for case in CASES if "--full" in arguments or not case.full for line in stale(case, page)]
    for line in wrong:
        print(f"not in {PAGE.name}: {line}", file=sys.stderr)
    return int(bool(wrong))


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
