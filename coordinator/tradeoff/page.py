"""The report on one page: verdict, figure, table, what messages cost, and what the numbers are worth.

Self-contained HTML without scripts; light, dark and on paper.
"""

from __future__ import annotations

from collections.abc import Sequence
from html import escape
from math import inf
from pathlib import Path

from heavylift.recordings.format.html import Cell, bullets, document, table

from .figure import inline
from .measuring import Measured
from .quantities import MEANT
from .verdict import NOISE, Row, answers, percent

STYLE = (Path(__file__).parent / "page.css").read_text(encoding="utf-8")


def page(measured: Measured) -> str:
    """The page of a measured scene."""
    verdict = measured.verdict
    title = f"Speed against accuracy: {measured.scene}"
    good = sorted((row for row in measured.rows if row.worst < inf), key=lambda row: row.waits_s)
    failed = [row for row in measured.rows if row.worst == inf]
    body = [
        f"<h1>{escape(title)}</h1>",
        f'<p class="verdict{"" if verdict.pick else " bad"}">{escape(verdict.sentence)}</p>',
        f"<pre>{escape(measured.words(verdict.pick))}</pre>" if verdict.pick else "",
        f'<p class="quiet">{escape(verdict.more)}</p>',
        f"<figure>{inline(measured)}</figure>",
        "<h2>Which setting for which question</h2>",
        _answers(measured),
        "<h2>Settings, the fastest first</h2>",
        _settings(measured, good),
        _section("What the kernel said", ["setting", "note"], [[str(x), told] for x in good for told in x.notes]),
        _section("Refused, unstable or cut", ["rung", "method", "step or tolerance", "why"],
                 [[row.rung, row.method, row.how, row.reason] for row in failed], 4),
        _section("Rungs", ["rung", "what is modelled"], [[x.name, x.words] for x in measured.rungs if x.words]),
        *_communication(measured),
        "<h2>What these numbers are worth</h2>",
        _honesty(measured),
    ]  # fmt: skip
    return document(title, STYLE, body)


def _answers(measured: Measured) -> str:
    """Of each quantity at each limit; what a process per node takes beside the kernel is measured once."""
    apart = [x.wall_s - x.kernel_s for x in measured.distributed[-1:]]
    body: list[list[Cell]] = []
    for a in answers(measured.ask, measured.rows):
        cells: list[Cell] = [a.quantity, percent(a.limit), "none of these" if a.row is None else str(a.row)]
        times = [] if a.row is None else [a.row.waits_s, a.row.cpu_s, *(x + a.row.cpu_s for x in apart)]
        cells += [*(f"{x:.3g}" for x in times), "" if a.row is None else percent(a.row.worst)]
        body.append([*cells[:-1], *[""] * (2 + len(apart) - len(times)), cells[-1]])
    head = ["asked", "to", "fastest setting", "waits s", "kernel s", *["in processes s"] * len(apart), "error"]
    return _table(head, body, 3)


def _settings(measured: Measured, rows: list[Row]) -> str:
    small = f"m{measured.unit}" if measured.unit in ("m", "rad") else measured.unit
    drifts = any(row.drift is not None for row in rows)
    head = ["rung", "method", "step or tolerance", "waits s", "start s", "kernel s", "x real time", "messages",
            *measured.ask, f"places [{small}]", "energy", *(["drift [mm]"] if drifts else []), "verdict"]  # fmt: skip
    body = []
    names = {id(measured.verdict.pick): "pick", id(measured.verdict.next_faster): "next"}
    for row in rows:
        cells: list[Cell] = [row.rung, row.method, row.how]
        cells += [f"{x:.3g}" for x in (row.waits_s, row.start_s, row.cpu_s)]
        cells += [f"{row.speed:.3g}" if row.speed < 1000 else f"{row.speed:.0f}", str(row.messages)]
        cells += [(percent(row.errors[q]), row.errors[q] > measured.limit) for q in measured.ask]
        cells += [f"{row.position * 1e3:.3g}", f"{row.energy:.1e}"]
        if drifts:
            cells.append("" if row.drift is None else f"{row.drift * 1e3:.1g}")
        cells.append("passes" if row.passes(measured.limit) else "fails")
        body.append(cells)
    return _table(head, body, 3, [names.get(id(row), "") for row in rows])


def _section(title: str, head: Sequence[str], rows: Sequence[Sequence[Cell]], left: int = 2) -> str:
    """A table below its title; nothing without rows."""
    return f"<h2>{title}</h2>\n{_table(head, rows, left)}" if rows else ""


def _communication(measured: Measured) -> list[str]:
    parts: list[str] = []
    if measured.held:
        parts += ["<h2>Forces held between processes</h2>",
                  '<p class="quiet">Two solvers, one for each end of a rope, tell each other their places every h and '
                  "hold the rope's force between. Measured damping ratio beside the law -w h/4: it gains energy. "
                  "Nodes of a lift exchange commands and events, never held forces.</p>"]  # fmt: skip
        body = [[x.pair, f"{x.omega:.3g}", f"{x.h * 1e3:g}", f"{100 * x.measured:.3f} %", f"{100 * x.law:.3f} %",
                 f"{x.one_percent * 1e6:.2g}"] for x in measured.held]  # fmt: skip
        head = ["rope", "w [rad/s]", "h [ms]", "measured", "-w h/4", "h for 1 % over the run [us]"]
        parts.append(_table(head, body, 1))
    if measured.distributed:
        alike = {x.digest for x in measured.distributed if "," not in x.where}
        told = "Digests of the first, second and last row are equal." if len(alike) == 1 else "THE DIGESTS DIFFER."
        parts += ["<h2>What is distributed, what that costs and buys</h2>",
                  f'<p class="quiet">The scene as it is written, with its recording. {told}</p>']  # fmt: skip
        body = [[x.where, x.buys, f"{x.wall_s:.3g}", f"{x.around_s:.3g}", f"{x.kernel_s:.3g}", f"{x.cpu_s:.3g}",
                 str(x.grants), f"{x.per_grant * 1e3:.3g}", f"{x.recorded_bytes / 1e6:.3g}"]
                for x in measured.distributed]  # fmt: skip
        head = ["nodes in", "buys", "wall s", "start and end s", "kernel s", "CPU s", "grants",
                "ms per grant beside the kernel", "recording MB"]  # fmt: skip
        parts.append(_table(head, body, 2))
    return parts


def _honesty(measured: Measured) -> str:
    rows = [row for row in measured.rows if row.worst < inf]
    repeated = [row for row in rows if row.runs > 1]
    m = measured.machine
    lines = [f"Reference: {measured.reference}."]
    for refinement, moved in measured.converged.items():
        told = ", ".join(f"{q} by {percent(e)}" for q, e in moved.items())
        lines.append(f"With {refinement} it moves: {told}.")
    worst = max((e for moved in measured.converged.values() for e in moved.values()), default=0.0)
    if worst > measured.limit / 10:
        lines.append(f"So errors below {percent(worst)} say nothing: the reference itself is no better.")
    lines.append(f"Limit of every quantity asked: {percent(measured.limit)}.")
    lines += [f"{quantity[0].upper()}{quantity[1:]}: {MEANT[quantity]}." for quantity in measured.ask]
    lines += [f"Not asked of this scene: {quantity} ({why})." for quantity, why in measured.not_asked.items()]
    lines.append(
        f"{m.processor}, {m.cores} core{'s' if m.cores > 1 else ''}, load {m.load:.2g} at the end; one run at a time "
        f"on one core, in one process, without a recording. What one waits is CPU time, as on a core of its own: the "
        f"start (Python, the scene, equations; machine code is kept from the first run) and the kernel. Differences "
        f"below {NOISE:.0%}, or below the spread of repetitions, are noise. Python {m.python}, heavylift {m.heavylift}."
    )
    if repeated:
        spreads = sorted(row.spread for row in repeated)
        lines.append(
            f"{len(repeated)} of {len(rows)} settings were run {max(r.runs for r in repeated)} times, the least "
            f"time counts; the slowest run took {percent(spreads[len(spreads) // 2])} longer in the median, "
            f"{percent(spreads[-1])} at most." + " The others were run once." * (len(repeated) < len(rows))
        )
    told = f"{measured.spent:.3g} s of {measured.budget:.3g} s were used; {measured.left_out} settings did not fit in"
    settled = f"; {measured.settled} tighter ones were not run, since the error no longer changed"
    lines.append(f"{told}{settled if measured.settled else ''}.")
    return bullets(lines)


def _table(head: Sequence[str], rows: Sequence[Sequence[Cell]], left: int, marks: Sequence[str] = ()) -> str:
    """A table whose first `left` columns are text."""
    return wide(table(head, rows, f"left{left} named" if left > 2 else f"left{left}", marks=marks))


def wide(text: str) -> str:
    """A table that may be wider than a phone."""
    return f'<div class="wide">{text}</div>'
