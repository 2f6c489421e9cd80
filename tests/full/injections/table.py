"""One row for each kind of fault: number of trials, their moments, and trials that ended as promised."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Sequence
from typing import Any

from .trial import Trial

RECOVERY_s = 1.0  # from the moment that a loss is known until a successor is there: target


def rows(trials: Sequence[Trial]) -> list[dict[str, Any]]:
    """Rows in the order of the kinds."""
    found = []
    for kind in dict.fromkeys(trial.case.kind for trial in trials):
        of_kind = [trial for trial in trials if trial.case.kind == kind]
        kept = sum(not trial.failure for trial in of_kind)
        row: dict[str, Any] = {"kind": kind.name, "tried": len(of_kind), "as_promised": kept}
        row |= {"not": len(of_kind) - kept, "hit": sum(trial.struck for trial in of_kind), "promise": kind.promise}
        moments = Counter(trial.case.moment for trial in of_kind if trial.struck and trial.case.moment)
        found.append(row | {"moments": dict(moments)} if moments else row)
    return found


def show(rows: Sequence[dict[str, Any]], as_json: bool) -> None:
    """Print them: JSON objects one a line, or columns for people."""
    if as_json:
        for row in rows:
            print(json.dumps(row))
        return
    width = max((len(str(row["kind"])) for row in rows), default=0)
    print(f"{'kind':<{width}}  tried   hit  as promised   not  promise")
    for row in rows:
        hit, message = row.get("hit", row["tried"]), row.get("promise", "")
        print(f"{row['kind']:<{width}} {row['tried']:>6} {hit:>5} {row['as_promised']:>12} {row['not']:>5}  {message}")


def timing(trials: Sequence[Trial]) -> str:
    """The longest times of successors, in one line."""
    times = [each for trial in trials for each in trial.times]
    if not times:
        return "no process was replaced"
    worst = ", ".join(
        f"{name} {max(column):.2f} s"
        for name, column in zip(("detection", "recovery", "replay"), zip(*times, strict=True), strict=True)
    )
    late = sum(each[1] > RECOVERY_s for each in times)
    return f"{len(times)} successors, at most {worst}; {late} of them later than {RECOVERY_s:g} s beyond detection"
