"""The report on one page: verdict, figure, table, what messages cost, and what the numbers are worth.

Self-contained HTML without scripts; light, dark and on paper.
"""

from __future__ import annotations

from collections.abc import Sequence
from html import escape
from math import inf
from typing import TYPE_CHECKING

from .answers import answers
from .figure import inline
from .quantities import MEANT
from .verdict import Row, percent

if TYPE_CHECKING:
    from .measuring import Measured

__all__ = ["page"]

STYLE = """
:root { color-scheme: light dark; --ink: #1d2733; --quiet: #66727e; --band: #e6f2ea; --paper: #ffffff;
  --limit: #a3182b; --rule: #e4e8ec; --good: #e9f4ec; --bad: #fbe9ea; }
@media (prefers-color-scheme: dark) { :root { --ink: #dbe3ea; --quiet: #93a0ac; --band: #1f3128; --paper: #161c23;
  --limit: #ff8a8f; --rule: #2b3640; --good: #1b3226; --bad: #3b2226; } }
body { font: 14px/1.5 system-ui, sans-serif; color: var(--ink); background: var(--paper); max-width: 1160px;
  margin: 24px auto; padding: 0 16px; }
h1 { font-size: 22px; margin: 0 0 8px; }
h2 { font-size: 16px; margin: 28px 0 6px; border-bottom: 1px solid var(--rule); }
.verdict { font-size: 16px; padding: 10px 14px; border-radius: 4px; background: var(--good); margin: 0 0 12px; }
.verdict.bad { background: var(--bad); } .quiet { color: var(--quiet); } figure { margin: 0; }
pre { white-space: pre-wrap; color: var(--quiet); margin: 0 0 12px; }
svg { width: 100%; height: auto; } .wide { overflow-x: auto; }
table { border-collapse: collapse; width: 100%; font-size: 12px; font-variant-numeric: tabular-nums; }
th, td { text-align: right; padding: 2px 5px; border-bottom: 1px solid var(--rule); vertical-align: top; }
th { font-weight: 600; } .left { text-align: left; } td.over { color: var(--limit); font-weight: 600; }
tr.pick td { background: var(--good); font-weight: 600; } tr.next td { background: var(--bad); }
td, table:not(.named) td:first-child { white-space: nowrap; } td.left { white-space: normal; }
.named td:nth-child(2) { white-space: nowrap; } .named th:first-child { min-width: 140px; }
@media print { :root { color-scheme: light; --ink: #1d2733; --quiet: #66727e; --band: #e6f2ea; --paper: #ffffff;
  --limit: #a3182b; --rule: #e4e8ec; --good: #e9f4ec; --bad: #fbe9ea; } body { margin: 0; }
  h2, tr, figure, .verdict { break-inside: avoid; } h2 { break-after: avoid; } thead { display: table-header-group; }
  table { font-size: 9px; } th, td { padding: 1px 4px; } .wide { overflow: visible; }
  @page { size: A4; margin: 12mm; } }
"""
PAGE = """<!doctype html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="generator" content="heavylift">
<meta name="viewport" content="width=device-width, initial-scale=1">
<meta http-equiv="Content-Security-Policy" content="default-src 'none'; style-src 'unsafe-inline'">
<title>{title}</title>
<style>{style}</style>
</head>
<body>
{body}
</body>
</html>
"""
Cell = str | tuple[str, bool]  # text, and whether it is over the limit


def page(measured: Measured) -> str:
    """The page of a measured scene."""
    verdict = measured.verdict
    title = f"Speed against accuracy: {measured.scene}"
    good = sorted((row for row in measured.rows if row.worst < inf), key=lambda row: -row.speed)
    failed = [row for row in measured.rows if row.worst == inf]
    body = [
        f"<h1>{escape(title)}</h1>",
        f'<p class="verdict{"" if verdict.pick else " bad"}">{escape(verdict.sentence)}</p>',
        f"<pre>{escape(measured.words(verdict.pick))}</pre>" if verdict.pick else "",
        f"<figure>{inline(measured)}</figure>",
        "<h2>Which setting for which question</h2>",
        _answers(measured),
        "<h2>Settings, the fastest first</h2>",
        _settings(measured, good),
        *_noted(good),
        *_failed(failed),
        *_rungs(measured),
        *_communication(measured),
        "<h2>What these numbers are worth</h2>",
        _honesty(measured),
    ]
    return PAGE.format(title=escape(title), style=STYLE, body="\n".join(body))


def _answers(measured: Measured) -> str:
    body: list[tuple[str, list[Cell]]] = []
    for a in answers(measured):
        cells: list[Cell] = [a.quantity, percent(a.limit), "none of these" if a.row is None else str(a.row)]
        cells += ["", ""] if a.row is None else [f"{a.row.speed:.4g}", percent(a.row.worst)]
        body.append(("", cells))
    return _table(["asked", "to", "fastest setting", "x real time", "error"], body, 3)


def _settings(measured: Measured, rows: list[Row]) -> str:
    small = f"m{measured.unit}" if measured.unit in ("m", "rad") else measured.unit
    drifts = any(row.drift is not None for row in rows)
    head = ["rung", "method", "step or tolerance", "wall s", "CPU s", "x real time", "messages", *measured.ask,
            f"places [{small}]", "energy", *(["drift [mm]"] if drifts else []), "verdict"]  # fmt: skip
    body = []
    for row in rows:
        cells: list[Cell] = [row.rung, row.method, row.how, f"{row.wall_s:.3g}", f"{row.cpu_s:.3g}"]
        cells += [f"{row.speed:.3g}" if row.speed < 1000 else f"{row.speed:.0f}", str(row.messages)]
        cells += [(percent(row.errors[q]), row.errors[q] > measured.limit) for q in measured.ask]
        cells += [f"{row.position * 1e3:.3g}", f"{row.energy:.1e}"]
        if drifts:
            cells.append("" if row.drift is None else f"{row.drift * 1e3:.1g}")
        cells.append("passes" if row.passes(measured.limit) else "fails")
        mark = {id(measured.verdict.pick): "pick", id(measured.verdict.next_faster): "next"}.get(id(row), "")
        body.append((mark, cells))
    return _table(head, body, 3)


def _failed(rows: list[Row]) -> list[str]:
    if not rows:
        return []
    body = [("", [row.rung, row.method, row.how, row.reason]) for row in rows]
    return ["<h2>Refused, unstable or cut</h2>", _table(["rung", "method", "step or tolerance", "why"], body, 4)]


def _noted(rows: list[Row]) -> list[str]:
    """Settings of which the kernel had something to say."""
    body: list[tuple[str, Sequence[Cell]]] = [("", [str(row), told]) for row in rows for told in row.notes]
    return ["<h2>What the kernel said</h2>", _table(["setting", "note"], body, 2)] if body else []


def _rungs(measured: Measured) -> list[str]:
    body: list[tuple[str, Sequence[Cell]]] = [("", [rung.name, rung.words]) for rung in measured.rungs if rung.words]
    return ["<h2>Rungs</h2>", _table(["rung", "what is modelled"], body, 2)] if body else []


def _communication(measured: Measured) -> list[str]:
    parts: list[str] = []
    if measured.held:
        parts += ["<h2>Forces held between processes</h2>",
                  '<p class="quiet">Two solvers, one for each end of a rope, tell each other their places every h and '
                  "hold the rope's force between. Measured damping ratio beside the law -w h/4: it gains energy. "
                  "Nodes of a lift exchange commands and events, never held forces.</p>"]  # fmt: skip
        body = [("", [x.pair, f"{x.omega:.3g}", f"{x.h * 1e3:g}", f"{100 * x.measured:.3f} %", f"{100 * x.law:.3f} %",
                 f"{x.one_percent * 1e6:.2g}"]) for x in measured.held]  # fmt: skip
        head = ["rope", "w [rad/s]", "h [ms]", "measured", "-w h/4", "h for 1 % over the run [us]"]
        parts.append(_table(head, body, 1))
    if measured.distributed:
        equal = len({x.digest for x in measured.distributed}) == 1
        told = "Both digests are equal." if equal else "THE DIGESTS DIFFER."
        parts += ["<h2>Distributed against in-process</h2>",
                  f'<p class="quiet">The scene as it is written, with its recording. {told}</p>']  # fmt: skip
        body = [("", [x.where, f"{x.wall_s:.3g}", f"{x.around_s:.3g}", f"{x.kernel_s:.3g}", str(x.grants),
                 f"{x.per_grant * 1e3:.3g}"]) for x in measured.distributed]  # fmt: skip
        head = ["nodes in", "wall s", "start and end s", "kernel s", "grants", "ms per grant beside the kernel"]
        parts.append(_table(head, body, 1))
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
        f"on one core, in one process, without a recording. Real-time factors are of CPU time, as on a core of its "
        f"own; wall time stands beside. Python {m.python}, heavylift {m.heavylift}."
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
    return "<ul>" + "".join(f"<li>{escape(line)}</li>" for line in lines) + "</ul>"


def _table(head: Sequence[str], body: Sequence[tuple[str, Sequence[Cell]]], left: int) -> str:
    """Rows with a class each; the first `left` columns are text."""

    def cell(i: int, content: Cell) -> str:
        text, over = content if isinstance(content, tuple) else (content, False)
        classes = " ".join(name for name, on in (("left", i < left), ("over", over)) if on)
        return f'<td class="{classes}">{escape(text)}</td>' if classes else f"<td>{escape(text)}</td>"

    kind = ' class="named"' if left > 2 else ""
    heads = "".join(f'<th class="left">{escape(h)}</th>' if i < left else f"<th>{escape(h)}</th>"
                    for i, h in enumerate(head))  # fmt: skip
    rows = [
        f'<tr class="{mark}">' * bool(mark) + "<tr>" * (not mark) + "".join(map(cell, range(len(cells)), cells))
        + "</tr>" for mark, cells in body
    ]  # fmt: skip
    return f'<div class="wide"><table{kind}><thead><tr>{heads}</tr></thead><tbody>{"".join(rows)}</tbody></table></div>'
