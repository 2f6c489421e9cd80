"""Page of a study: counts, limits, response curves, histograms, indices, and how to repeat failed variants.

Page of `heavylift limits`: how far each number may go, what limits it, and the utilisation along the search.
"""

from collections.abc import Sequence
from math import ceil, isfinite, nan
from textwrap import fill
from typing import TYPE_CHECKING, Literal

import numpy as np
from heavylift.nodes.scene import LoadedScene
from heavylift.recordings.sheets.sheet import (
    COLOURS,
    INK,
    LIMIT,
    PAPER,
    QUIET,
    Cell,
    Chart,
    Marked,
    Notes,
    Sheet,
    Table,
    columns,
    in_page,
    styled,
    words,
)

from .axes import Axis
from .limiting import FoundLimit
from .study import Study
from .summary import FEWEST, LEVEL, Summary, result_label, summary
from .variant import FAILED

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

LISTED = 20  # variants with their command; limits
DRAWN = 4  # axes
FEW = 200  # variants that are seen one by one
SAME = 1e-6  # relative: what lies closer together is drawn as one value
MEANT = {
    "done": "came to its end, green",
    "red": "came to its end, the verdict is red",
    "refused": "cannot be built or carried out",
    "failed": "ended in an error",
    "cut": "took longer than a run may: it says nothing of the lift",
    "lost": "its worker died; the same command runs it again",
}


def status_line(study: Study, found: Summary) -> str:
    """Return the state of a study in one line."""
    counts = ", ".join(f"{n} {status}" for status, n in found.counts.items()) or "no run yet"
    left = f"; {found.waiting} are still to run" if found.waiting else ""
    cut = f"; {found.counts['cut']} WERE CUT and are in no number" if found.counts.get("cut") else ""
    short = f"; {found.unfinished} ARE UNFINISHED, for the scene ended before" if found.unfinished else ""
    return f"{len(study.plan.variants)} variants of {study.plan.scene.plan.name}: {counts}{left}{cut}{short}"


def study_sheet(study: Study) -> Sheet:
    """Return the current page of a study."""
    found = summary(study)
    counts = ((status, MEANT[status], n) for status, n in found.counts.items())
    parts = [
        Table("Variants", columns("status", "", "variants .0"), tuple(counts)),
        Notes("What was varied", tuple(_varied(study))),
        *_limits(study, found),
        *_responses(study, found),
        *_histograms(found),
        *_indices(study, found),
        *_failures(study),
    ]
    bad = any(status in FAILED for status in found.counts)
    return Sheet(
        f"Study of {study.plan.scene.plan.name}", status_line(study, found), "bad" if bad else "", tuple(parts)
    )


def _varied(study: Study) -> list[str]:
    plan = study.plan
    lines = [
        f"{axis.uncertain}" if axis.uncertain else f"{axis.path}: {', '.join(axis.texts) or _range(axis)}"
        for axis in plan.axes
    ]
    how = {"sobol": "Saltelli's design on a Sobol sequence", "lhs": "a Latin hypercube"}
    if plan.sample:
        lines.append(f"{len(plan.variants)} draws: {how[plan.design]}, seed {plan.seed}.")
    return lines


def _range(axis: Axis) -> str:
    return f"anything from {axis.low:g} to {axis.high:g} {axis.unit}"


def _limits(study: Study, found: Summary) -> list[Table]:
    sampled, level = bool(study.plan.sample), f"at {LEVEL:.0%}"
    heads = ["limit", "variants .0", "mean use [%] .1", "largest use [%] .1", "beyond .0"]
    chances = "probability of exceeding [%] .2", f"at least, {level} [%] .2", f"at most, {level} [%] .2"
    heads += chances if sampled else []
    rows = []
    for x in found.chances[:LISTED]:
        most = Marked(100.0 * x.most) if x.most > 1.0 else 100.0 * x.most
        more = [100.0 * part for part in (x.part, x.low, x.high)] if sampled else []
        rows.append((x.limit, x.judged, 100.0 * x.mean, most, x.beyond, *more))
    notes = []
    if sampled and found.chances:
        n = found.chances[0].judged
        notes.append(f"Probabilities are of the {n} independent draws that came to their end (Clopper and Pearson).")
    if len(found.chances) > LISTED:
        notes.append(f"{len(found.chances) - LISTED} less used limits stand in rows.parquet only.")
    return [Table("Limits, the most used first", columns(*heads), tuple(rows), tuple(notes))]


def _responses(study: Study, found: Summary) -> list[Chart]:
    """Draw each result over each axis: variants, and means of neighbouring ones or those with the same text."""
    words = {axis.label: axis.texts for axis in study.plan.axes if axis.texts and axis.numbers is None}
    names, axes = list(found.results), list(found.inputs)[:DRAWN]
    if not names or not axes or not len(found.inputs[axes[0]]):
        return []
    figure = canvas(len(names), len(axes), sharey="row")
    for i, name in enumerate(names):
        for j, axis in enumerate(axes):
            ax = figure.axes[i * len(axes) + j]
            x, y = found.inputs[axis], found.results[name]
            size, alpha = (5.0, 1.0) if len(x) <= FEW else (2.6, max(0.15, min(0.8, 150 / len(x))))
            ax.plot(x, y, "o", ms=size, alpha=alpha, color=COLOURS[0], mew=0, zorder=3)
            ax.plot(*_means(x, y), "_" if axis in words else "-", ms=24, color=COLOURS[1], lw=1.6, mew=1.6)
            if name == "use":
                ax.axhline(1.0, color=LIMIT, lw=1.1, ls=(0, (6, 3)))
                ax.yaxis.set_major_formatter(lambda share, _: f"{100 * share:.0f} %")
            if j == 0:
                ax.set_ylabel(result_label(name).replace(" of a load's limit", "").replace(" of a hook's ropes", ""))
            if i == len(names) - 1:
                ax.set_xlabel(axis)
            if axis in words:
                ax.set_xlim(-0.5, len(words[axis]) - 0.5)
                wide_as = max(10, 60 // len(words[axis]))
                ax.set_xticks(range(len(words[axis])), [fill(text, wide_as) for text in words[axis]])
    left = len(found.inputs) - len(axes)
    more = f" {left} more inputs stand in rows.parquet." if left > 0 else ""
    note = f"A point is a variant, the line the mean of those that are near.{more}"
    return [Chart("Responses", in_page(figure), (note,))]


def _means(x: np.ndarray, y: np.ndarray) -> tuple[list[float], list[float]]:
    """Return the mean `y` by value of `x`, or by equal bins if there are many values."""
    fine = np.isfinite(y)
    x, y = x[fine], y[fine]
    values = np.unique(x)
    if len(values) <= 24:
        return values.tolist(), [float(y[x == value].mean()) for value in values]
    parts = np.array_split(np.argsort(x, kind="stable"), 16)
    return [float(x[part].mean()) for part in parts], [float(y[part].mean()) for part in parts]


def _histograms(found: Summary) -> list[Chart]:
    names = [name for name, values in found.results.items() if len(values) > 1]
    if not names:
        return []
    from matplotlib.ticker import MaxNLocator

    figure = canvas(1, len(names))
    for ax, name in zip(figure.axes, names, strict=True):
        values = found.results[name][np.isfinite(found.results[name])]
        bins = min(40, max(5, round(len(values) ** 0.5)))
        ax.hist(values, bins=bins, range=_around(values), color=COLOURS[0], edgecolor=PAPER, lw=0.5)
        if name == "use":
            ax.axvline(1.0, color=LIMIT, lw=1.1, ls=(0, (6, 3)))
            ax.xaxis.set_major_formatter(lambda share, _: f"{100 * share:.0f} %")
        ax.yaxis.set_major_locator(MaxNLocator(integer=True))
        ax.set_xlabel(result_label(name))
    figure.axes[0].set_ylabel("variants")
    return [Chart("Distributions", in_page(figure))]


def _around(values: np.ndarray) -> tuple[float, float] | None:
    """Return the range of values, widened if its width is only rounding; None without values."""
    if not len(values):
        return None
    least, most = float(values.min()), float(values.max())
    more = max(0.0, SAME * max(1.0, abs(most)) - (most - least))
    return least - more, most + more


def canvas(rows: int, columns: int, sharey: Literal["none", "row"] = "none") -> "Figure":
    """Return a figure with rows x columns of axes in the style of the page."""
    from matplotlib.figure import Figure

    with styled("none"):
        figure = Figure(figsize=(11.0, 2.6 * rows + 0.4), facecolor=PAPER, layout="constrained")
        for ax in np.ravel(figure.subplots(rows, columns, squeeze=False, sharey=sharey)):
            ax.grid(axis="y", color=QUIET, lw=0.4, alpha=0.3)
            ax.set_axisbelow(True)
            ax.spines[["top", "right"]].set_visible(False)
            ax.tick_params(color=QUIET)
            ax.yaxis.label.set_color(INK)
        return figure


def _indices(study: Study, found: Summary) -> list[Table | Notes]:
    if not study.plan.sample:
        return []
    heads = columns("input", "alone (first) .3", "+- .3", "with others (total) .3", "+- .3")
    how = "Sobol indices" if study.plan.design == "sobol" else "first-order indices by random balance designs"
    note = f"{how}: parts of the variance, half-widths at {LEVEL:.0%} (SALib)."
    made: list[Table | Notes] = [
        Table(
            f"Which input moves the {result_label(name)}",
            heads,
            tuple((x.axis, x.first, x.first_half, x.total, x.total_half) for x in listed),
            (note,),
        )
        for name, listed in found.indices.items()
    ]
    fewest = FEWEST[study.plan.design]
    why = f"every variant of the design must come to its end, {fewest} at least, and the results must vary"
    return made or [Notes("Which input moves which result", (f"No indices: {why}.",))]


def _failures(study: Study) -> list[Table]:
    bad = [study.rows[n] for n in sorted(study.rows) if study.rows[n]["status"] in FAILED]
    rows = tuple((str(row["number"]), row["status"], _sentence(row), row["command"]) for row in bad[:LISTED])
    more = (f"{len(bad) - LISTED} more stand in rows.parquet.",) if len(bad) > LISTED else ()
    head = ("variant", "status", "why", "to repeat it with a recording")
    return [words("Variants to look at", head, rows, *more)]


def _sentence(row: dict[str, str]) -> str:
    text = row.get("verdict", "") if row["status"] == "red" else row["sentence"]
    return text.splitlines()[0] if text else ""


HEADS = columns("number", "green up to", "red at", "most used there", "to", "in", "at [h:min:s]", "what turns red")
COLUMNS = 3  # of figures
LEAD = (
    "The largest value of each number, alone, for which the verdict of a run is green. "
    "Bars: of the use that turns red, by tighter steps and the next finer model level, at 95 %."
)


def limits_table(found: Sequence[FoundLimit]) -> Table:
    """Return a table of found limits, with one row for each varied number."""
    return Table("How far each number may go", HEADS, tuple(map(_row, found)))


def _row(one: FoundLimit) -> tuple[Cell, ...]:
    if one.wrong:
        return one.path, one.shown(one.green), one.shown(one.red), "", "", "", None, one.wrong
    most = one.most
    where = str(most["limit"]), one.used, str(most["limit stage"]), most["limit at [s]"]
    used = where if isfinite(most.get("use", nan)) else ("", "", "", None)
    return one.path, one.limit, one.shown(one.red), *used, one.why


def limits_sheet(scene: LoadedScene, found: Sequence[FoundLimit]) -> Sheet:
    """Return the page of limits: a table, what turned each search red, and curves of utilisation."""
    drawn = [one for one in found if one.red is not None and len(_points(one)[0]) > 1]
    reasons = Notes("What turns red", tuple(f"{one.path}: {one.wrong or one.why}" for one in found))
    charts = [Chart("Largest use of a load's limit on the way", _figure(drawn))] if drawn else []
    return Sheet(f"How far {scene.plan.name} may go", LEAD, "", (limits_table(found), reasons, *charts))


def _figure(found: Sequence[FoundLimit]) -> str:
    columns = min(COLUMNS, len(found))
    figure = canvas(ceil(len(found) / columns), columns)
    for ax, one in zip(figure.axes, found, strict=False):
        _drawn(ax, one)
    for ax in figure.axes[len(found) :]:
        ax.set_axis_off()
    return in_page(figure)


def _drawn(ax: "Axes", one: FoundLimit) -> None:
    x, use, green = _points(one)
    ax.plot(x, 100.0 * use, color=COLOURS[0], lw=1.2, alpha=0.6)
    for good, colour in ((True, COLOURS[2]), (False, LIMIT)):
        ax.plot(x[green == good], 100.0 * use[green == good], "o", ms=4, color=colour, mew=0)
    ax.axhline(100.0, color=LIMIT, lw=1.1, ls=(0, (6, 3)))
    if one.red is not None:
        ax.axvline(one.red, color=LIMIT, lw=0.9, alpha=0.7)
    ax.set_xlabel(f"{one.path} [{one.unit}]" if one.unit else one.path)
    ax.set_ylabel("use [%]")


def _points(one: FoundLimit) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return values, utilisations and whether the verdict is green, (n,) each, of the checked runs."""
    rows = [(x, row["use"], row["status"] == "done") for x, row in sorted(one.runs.items()) if "use" in row]
    x, use, green = (np.array(column) for column in zip(*rows, strict=True)) if rows else (np.zeros(0),) * 3
    return x, use, green
