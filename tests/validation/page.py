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
HEAD = ["| source | quantity | theirs | ours | difference | within | shown in |", "|---|---|---|---|---|---|---|"]
MEASURED = "Published measurements"
INTRODUCTION = """\
# Validation

What heavylift computes, beside what others say: closed forms, published problems, worked examples, published
measurements. The page is made by `python tests/validation/page.py`, which computes each figure anew; the tests check
that its rows are still what comes out. *Difference* is ours less theirs, relative to theirs (in the row's unit where
theirs is 0). *Within* is what the comparison allows: theory that leaves something out, the digits of the source, the
reading error of a measurement; differences below a hundredth of it, or 1e-9, are told as less than that. Misses are
in bold and stay in the page."""
LIMITS = """\
What this is not: no lift of a shipyard is among the measurements, because none could be had with its figures
([below](#sources-that-were-looked-for)); what was measured are a laboratory crane, pendulums and a frame on a rod. Rope
damping, sheave efficiency, wind on real blocks and the stiffness of real cranes are not held against measurements at
all. The one miss among what others calculated is an error in print; [each miss](#misses) has its reason, or says that
none is known. Soft and stiff, light and heavy to the extreme: [STABILITY.md](STABILITY.md)."""


def made(computed: Sequence[tuple[Case, list[tuple[Row, str]]]]) -> str:
    """The page, of all cases with their rows."""
    parts = [INTRODUCTION, summary(computed), LIMITS]
    for table, words in TABLES.items():
        lines = [line for case, rows in computed if case.table == table for _, line in rows]
        parts.append("\n\n".join(part for part in (f"## {table}", words, "\n".join([*HEAD, *lines])) if part))
    parts.append(misses(computed))
    said = "Other programs solve the same scene; the bound is the one that the test holds at every run."
    parts.append("\n\n".join(("## Other codes", said, "\n".join(other_codes()))))
    said = (
        "Looked for in stored copies of public pages and repositories, which often hold only the beginning of a "
        "document; not in the tables because no more than this could be read:"
    )
    rows = [
        "| source | could be read | why it is not used |",
        "|---|---|---|",
        *(f"| {' | '.join(x)} |" for x in NOT_HAD),
    ]
    parts.append("\n\n".join(("## Sources that were looked for", said, "\n".join(rows))))
    return "\n\n".join(parts) + "\n"


def summary(computed: Sequence[tuple[Case, list[tuple[Row, str]]]]) -> str:
    """How many rows are within, by kind, and which is missed most."""
    lines = ["| | rows | within | missed | largest miss |", "|---|---|---|---|---|"]
    for kind, chosen in (("calculated by others", False), ("measured", True)):
        rows = [(case, row) for case, found in computed for row, _ in found if (case.table == MEASURED) == chosen]
        missed = [(abs(row.difference), case, row) for case, row in rows if row.missed]
        worst = max(missed, key=lambda m: m[0], default=None)
        told = f"{100 * worst[0]:.0f} %: {worst[2].quantity} ({worst[1].source})" if worst else "none"
        lines.append(f"| {kind} | {len(rows)} | {len(rows) - len(missed)} | {len(missed)} | {told} |")
    return "\n".join(lines)


def misses(computed: Sequence[tuple[Case, list[tuple[Row, str]]]]) -> str:
    """Why rows are missed, source by source."""
    told = [
        f"- **{case.source}** ({sum(row.missed for row, _ in rows)} of {len(rows)}): {case.why}."
        for case, rows in computed
        if any(row.missed for row, _ in rows)
    ]
    return "## Misses\n\n" + "\n".join(told)


def stale(case: Case, page: str) -> list[str]:
    """Lines of a case that are not in the page."""
    there = set(page.splitlines())
    return [line for _, line in case.lines() if line not in there]


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
