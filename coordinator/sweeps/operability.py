"""Operability of a lift: the share of time in which its verdict is not red, from a scatter table of seas.

A scatter table has a row for each class of significant wave heights, named by its upper end, and a column for each peak
period; its cells are occurrences. For each period the highest class that passes is searched, since a higher sea of the
same period is taken to be worse; what the verdict over seeds leaves undecided does not pass.
"""

import csv
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from math import isfinite
from pathlib import Path

from heavylift.kernel.errors import SceneError, error_text
from heavylift.nodes.scene import LoadedScene
from heavylift.recordings.sheets.sheet import Cell, Notes, Sheet, Table, columns, stated

from .limiting import reason
from .seeds import SeaRuns
from .variant import Row

HEADS = columns("Tp [s] .1", "passes up to Hs [m] .2", "occurrences .0", "of them [%] .1", "governed by", "used [%] .1",
                "fails at Hs [m] .2", "because of")  # fmt: skip


@dataclass(frozen=True)
class ScatterTable:
    """Occurrences of sea states by class of significant wave height Hs [m] and peak period Tp [s].

    `heights`, `periods`: upper ends of the classes, ascending; `counts`: indexed by [height][period]."""

    heights: tuple[float, ...]
    periods: tuple[float, ...]
    counts: tuple[tuple[float, ...], ...]

    @classmethod
    def read(cls, path: Path) -> "ScatterTable":
        """Read a scatter table from a CSV file: the first row has the periods [s], each further one a height [m] and
        its occurrences; raises SceneError."""
        try:
            with open(path, encoding="utf-8-sig", newline="") as file:
                rows = [[x.strip() for x in row] for row in csv.reader(file) if any(x.strip() for x in row)]
            (_, *periods), *others = [[float(x or 0.0) if i or j else 0.0 for j, x in enumerate(row)]
                                      for i, row in enumerate(rows)]  # fmt: skip
        except (OSError, ValueError, UnicodeDecodeError) as error:
            raise SceneError(f"{path}: it is not a scatter table of numbers: {error_text(error)}") from None
        heights, counts = [row[0] for row in others], [row[1:] for row in others]
        if not periods or not heights or any(len(row) != len(periods) for row in counts):
            raise SceneError(f"{path}: each row needs a height and one number for each of {len(periods)} periods")
        if any(list(x) != sorted({*x}) or not x[0] > 0.0 for x in (heights, periods)):
            raise SceneError(f"{path}: heights and periods must be positive and in ascending order")
        if not all(isfinite(x) and x >= 0.0 for row in counts for x in row) or not any(map(any, counts)):
            raise SceneError(f"{path}: occurrences must be numbers that are not negative, and not all zero")
        return cls(tuple(heights), tuple(periods), tuple(map(tuple, counts)))


def operability_sheet(
    scene: LoadedScene, table: ScatterTable, sea: str, runs: SeaRuns, say: Callable[[str], None]
) -> Sheet:
    """Return the share of the sea states in a scatter table in which the scene passes its checks; raises SceneError.

    `sea`: name of the sea that takes the heights and periods ("" if there is only one).
    """
    path = f"waves.seas.{sea_of(scene, sea)}"
    rows, passed, total = list[tuple[Cell, ...]](), 0.0, sum(map(sum, table.counts))
    for j, period in enumerate(table.periods):
        here = [row[j] for row in table.counts]
        if not any(here):
            continue

        def row_at(Hs: float, Tp: float = period) -> Row:
            row = runs.row([f"{path}.Hs={Hs!r} m", f"{path}.Tp={Tp!r} s"])
            if row["status"] in ("cut", "lost"):
                raise SceneError(f"--scatter: at Hs {Hs:g} m, Tp {Tp:g} s: {row['sentence']}")
            say(f"  Tp {Tp:g} s, Hs {Hs:g} m: {row.get('state', row['status'])}")
            return row

        most = max(i for i, x in enumerate(here) if x)
        n, good, bad = _highest(table.heights[: most + 1], row_at)
        share = sum(here[:n]) / sum(here)
        passed += sum(here[:n])
        used = 100.0 * good["use"] if good and good["limit"] else None
        rows.append((period, table.heights[n - 1] if n else None, sum(here), 100.0 * share, good.get("limit", ""), used,
                     None if n > most else table.heights[n], reason(bad) if bad else ""))  # fmt: skip
    share = 100.0 * passed / total
    lead = f"the lift may be done in {share:.1f} % of the time ({passed:g} of {total:g} occurrences)"
    note = f"{len(runs.seeds)} seeds of each sea; what they leave undecided fails; Hs and Tp of {path} are varied"
    title = f"Operability of {scene.plan.name}"
    made = Table("Seas, by peak period", HEADS, tuple(rows))
    state = "green" if passed else "red"
    return Sheet(title, stated(state, lead), state, (made, Notes("How", (note,))))


def sea_of(scene: LoadedScene, name: str) -> str:
    """Return the name of the sea to vary, which need not be given if the scene has only one; raises SceneError."""
    seas = scene.scene.waves.seas if scene.scene.waves else {}
    name = name.removeprefix("waves.seas.") or (next(iter(seas)) if len(seas) == 1 else "")
    if name not in seas:
        known = ", ".join(f"waves.seas.{x}" for x in seas) or "none in this scene"
        raise SceneError(f"--scatter: give --of with the sea whose height and period are varied; seas: {known}")
    return name


def passes(row: Row) -> bool:
    """Return whether the verdict in a row allows the operation: it exists and is neither red nor undecided."""
    return bool(row["status"] == "done" and row["state"] != "undecided")


def _highest(heights: Sequence[float], row_at: Callable[[float], Row]) -> tuple[int, Row, Row]:
    """Return the number of classes that pass, by bisection, with the rows of the last one that passes and the first one
    that does not."""
    low, high, good, bad = 0, len(heights), Row(), Row()
    while low < high:
        middle = (low + high) // 2
        row = row_at(heights[middle])
        if passes(row):
            low, good = middle + 1, row
        else:
            high, bad = middle, row
    return low, good, bad
