"""The page of a study: counts, limits, response curves, histograms, indices, and how to repeat what went wrong.

Self-contained HTML without scripts, in the style of the trade-off's; light, dark and on paper.
"""

from __future__ import annotations

from html import escape
from math import isfinite
from textwrap import fill
from typing import TYPE_CHECKING, Literal

import numpy as np
from heavylift.coordinator.ladder.pictures import COLOURS, INK, LIMIT, PAPER, QUIET, STYLE, in_page, styled, wide
from heavylift.recordings.format.html import Cell, bullets, document, table

from .axes import Axis
from .designs import FEWEST, Index
from .study import Study
from .summary import LEVEL, RESULTS, Summary, summary
from .variant import FAILED

if TYPE_CHECKING:
    from matplotlib.figure import Figure

LISTED = 20  # variants with their command; limits
DRAWN = 4  # axes
FEW = 200  # variants that are seen one by one
MEANT = {
    "done": "came to its end, green",
    "red": "came to its end, the verdict is red",
    "refused": "cannot be built or carried out",
    "failed": "ended in an error",
    "cut": "took longer than a run may: it says nothing of the lift",
    "lost": "its worker died; the same command runs it again",
}


def told(study: Study, found: Summary) -> str:
    """The study in one line."""
    counts = ", ".join(f"{n} {status}" for status, n in found.counts.items()) or "no run yet"
    left = f"; {found.waiting} are still to run" if found.waiting else ""
    cut = f"; {found.counts['cut']} WERE CUT and are in no number" if found.counts.get("cut") else ""
    short = f"; {found.unfinished} ARE UNFINISHED, for the scene ended before" if found.unfinished else ""
    return f"{len(study.plan.variants)} variants of {study.plan.scene.plan.name}: {counts}{left}{cut}{short}"


def page(study: Study) -> str:
    """The page of a study as it is now."""
    found, plan = summary(study), study.plan
    title = f"Study of {plan.scene.plan.name}"
    bad = any(status in FAILED for status in found.counts)
    counts: list[list[Cell]] = [[status, MEANT[status], str(n)] for status, n in found.counts.items()]
    body = [
        f"<h1>{escape(title)}</h1>",
        f'<p class="verdict{" bad" if bad else ""}">{escape(told(study, found))}</p>',
        wide(table(["status", "", "variants"], counts, "left2")),
        "<h2>What was varied</h2>",
        bullets(_varied(study)),
        *_limits(study, found),
        *_responses(study, found),
        *_histograms(found),
        *_indices(study, found),
        *_failures(study),
    ]
    return document(title, STYLE, body)


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


def _limits(study: Study, found: Summary) -> list[str]:
    if not found.chances:
        return []
    sampled = bool(study.plan.sample)
    head = ["limit", "variants", "mean use", "largest use", "beyond"]
    head += ["probability of exceeding", f"between, at {LEVEL:.0%}"] if sampled else []
    rows: list[list[Cell]] = []
    for x in found.chances[:LISTED]:
        row: list[Cell] = [x.limit, str(x.judged), _percent(x.mean), (_percent(x.most), x.most > 1.0), str(x.beyond)]
        row += [_percent(x.part, 2), f"{_percent(x.low, 2)} and {_percent(x.high, 2)}"] if sampled else []
        rows.append(row)
    notes = []
    if sampled:
        n = found.chances[0].judged
        notes.append(f"Probabilities are of the {n} independent draws that came to their end (Clopper and Pearson).")
    if len(found.chances) > LISTED:
        notes.append(f"{len(found.chances) - LISTED} less used limits stand in rows.parquet only.")
    return ["<h2>Limits, the most used first</h2>", wide(table(head, rows, "left1")), bullets(notes)]


def _percent(share: float, digits: int = 1) -> str:
    return f"{100 * share:.{digits}f} %"


def _responses(study: Study, found: Summary) -> list[str]:
    """Each result over each axis: the variants, and the mean of those that are near, or have the same words."""
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
                ax.set_ylabel(RESULTS[name].replace(" of a load's limit", "").replace(" of a hook's ropes", ""))
            if i == len(names) - 1:
                ax.set_xlabel(axis)
            if axis in words:
                ax.set_xlim(-0.5, len(words[axis]) - 0.5)
                wide_as = max(10, 60 // len(words[axis]))
                ax.set_xticks(range(len(words[axis])), [fill(text, wide_as) for text in words[axis]])
    left = len(found.inputs) - len(axes)
    more = f" {left} more inputs stand in rows.parquet." if left > 0 else ""
    quiet = f'<p class="quiet">A point is a variant, the line the mean of those that are near.{more}</p>'
    return ["<h2>Responses</h2>", quiet, f"<figure>{in_page(figure)}</figure>"]


def _means(x: np.ndarray, y: np.ndarray) -> tuple[list[float], list[float]]:
    """The mean of y of each value of x, or of parts of equal size where there are many."""
    fine = np.isfinite(y)
    x, y = x[fine], y[fine]
    values = np.unique(x)
    if len(values) <= 24:
        return values.tolist(), [float(y[x == value].mean()) for value in values]
    parts = np.array_split(np.argsort(x, kind="stable"), 16)
    return [float(x[part].mean()) for part in parts], [float(y[part].mean()) for part in parts]


def _histograms(found: Summary) -> list[str]:
    names = [name for name, values in found.results.items() if len(values) > 1]
    if not names:
        return []
    from matplotlib.ticker import MaxNLocator

    figure = canvas(1, len(names))
    for ax, name in zip(figure.axes, names, strict=True):
        values = found.results[name][np.isfinite(found.results[name])]
        bins = min(40, max(5, round(len(values) ** 0.5)))
        # results that differ by rounding only leave no room for several bins
        same = len(values) > 0 and np.ptp(values) <= 1e-9 * np.abs(values).max()
        ax.hist(values, bins=1 if same else bins, color=COLOURS[0], edgecolor=PAPER, lw=0.5)
        if name == "use":
            ax.axvline(1.0, color=LIMIT, lw=1.1, ls=(0, (6, 3)))
            ax.xaxis.set_major_formatter(lambda share, _: f"{100 * share:.0f} %")
        ax.yaxis.set_major_locator(MaxNLocator(integer=True))
        ax.set_xlabel(RESULTS[name])
    figure.axes[0].set_ylabel("variants")
    return ["<h2>Distributions</h2>", f"<figure>{in_page(figure)}</figure>"]


def canvas(rows: int, columns: int, sharey: Literal["none", "row"] = "none") -> Figure:
    """A figure of so many axes in the style of the page."""
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


def _indices(study: Study, found: Summary) -> list[str]:
    if not study.plan.sample:
        return []
    head = ["input", "alone (first)", "+-", "with others (total)", "+-"]
    parts = ["<h2>Which input moves which result</h2>"]
    for name, listed in found.indices.items():
        rows: list[list[Cell]] = [[x.axis, *_index(x)] for x in listed]
        parts += [f"<h3>{escape(RESULTS[name])}</h3>", wide(table(head, rows, "left1"))]
    if found.indices:
        how = "Sobol indices" if study.plan.design == "sobol" else "first-order indices by random balance designs"
        parts.append(f'<p class="quiet">{how}: parts of the variance, half-widths at {LEVEL:.0%} (SALib).</p>')
    else:
        fewest = FEWEST[study.plan.design]
        why = f"every variant of the design must come to its end, {fewest} at least, and the results must vary"
        parts.append(f'<p class="quiet">No indices: {why}.</p>')
    return parts


def _index(x: Index) -> list[Cell]:
    numbers = (x.first, x.first_half, x.total, x.total_half)
    return [f"{value:.3f}" if isfinite(value) else "" for value in numbers]


def _failures(study: Study) -> list[str]:
    bad = [study.rows[n] for n in sorted(study.rows) if study.rows[n]["status"] in FAILED]
    if not bad:
        return []
    rows: list[list[Cell]] = [
        [str(row["number"]), row["status"], _sentence(row), row["command"]] for row in bad[:LISTED]
    ]
    more = f"{len(bad) - LISTED} more stand in rows.parquet." if len(bad) > LISTED else ""
    head = ["variant", "status", "why", "to repeat it with a recording"]
    return ["<h2>Variants to look at</h2>", wide(table(head, rows, "left4")), bullets([more] if more else [])]


def _sentence(row: dict[str, str]) -> str:
    text = row.get("verdict", "") if row["status"] == "red" else row["sentence"]
    return text.splitlines()[0] if text else ""
