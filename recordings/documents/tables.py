"""The tables of a report, for all kinds of cranes: each table is a function of `Facts`; `TABLES` gives their order.

Each checked limit automatically has a row in the table of its quantity; a table for which the scene is needed is stored
with the verdict (`RecordedVerdict.tables`). To add another table, write its function and add it to `TABLES`.
"""

from collections.abc import Callable, Iterable, Iterator
from math import degrees

from heavylift.kernel.description.findings import Check
from heavylift.recordings.sheets.sheet import Cell, Marked, Table, columns, trimmed, words

from .facts import Facts, block_rows, scene_table

TONNE = 9806.65  # [N] its weight
LEAST = 0.01  # [%] of an error that is listed
SAME = 1e-9  # of a value: closer ones differ by rounding
UNITS = {
    "N": ("kN", 1e-3, 1),
    "N m": ("kN m", 1e-3, 1),
    "kg": ("t", 1e-3, 1),
    "rad": ("deg", degrees(1.0), 2),
    "Pa": ("kPa", 1e-3, 0),
}  # as people read them
OF_QUANTITY = {
    **dict.fromkeys(("lift-off speed", "landing speed"), ("m/min", 60.0, 2)),
    **dict.fromkeys(("uplift", "interlock"), ("%", 100.0, 1)),
}
LISTED = ("peak tension", "use of", "smallest clearance")  # figures whose errors stand beside them
ELSEWHERE = ("rope tension", "sling tension", "clearance")  # quantities that have tables of their own


def _findings(f: Facts) -> Iterator[Table]:
    """Yield the table of findings, with red ones first."""
    rows: list[tuple[Cell, ...]] = []
    for x in f.verdict.findings if f.verdict else ():
        message = f"{x.sentence} [{x.where}]" if x.where else x.sentence
        rows.append((x.word, Marked(message) if x.state == "red" else message, x.t, x.stage))
    yield Table("Findings", columns("", "what", "at [h:min:s]", "stage"), tuple(rows))
    notes = ((Marked(message), t) for t, message in f.rec.notes())
    yield Table("Notes of the kernel", columns("what", "at [h:min:s]"), tuple(notes))


def _checks(f: Facts) -> Iterator[Table]:
    """Yield the short table of all checks, with the governing check of each quantity."""
    yield from f.verdict.tables[:1] if f.verdict else ()


def _clearances(f: Facts) -> Iterator[Table]:
    rows: list[tuple[Cell, ...]] = []
    for c in f.verdict.clearances if f.verdict else ():
        red = f.verdict and any(
            x.quantity == "clearance" and x.subject == f"{c.a} and {c.b}" for x in f.verdict.findings
        )
        rows.append((f"{c.a} and {c.b}", Marked(c.distance) if red else c.distance, c.limit, c.t, c.place))
    unseen = tuple(f"Not modelled: {x}." for x in f.verdict.not_modelled) if f.verdict else ()
    heads = columns("between", "smallest [m] .2", "required [m] .2", "at [h:min:s]", "where")
    yield Table("Smallest clearances", heads, tuple(rows), (*unseen, "Required 0: not through each other."))


def _of_verdict(f: Facts) -> Iterator[Table]:
    yield from f.verdict.tables[1:] if f.verdict else ()


def _scene(f: Facts) -> Iterator[Table]:
    rows = ((what, *values, *[None] * (3 - len(values)), unit) for what, values, unit in block_rows(f.plan))
    yield trimmed(Table("Block", columns("", "value, u or x .3", "v or y .3", "w or z .3", "unit"), tuple(rows)))
    yield words("Scene", ("", ""), scene_table(f.rec, f.plan))


def _ropes(f: Facts) -> Iterator[Table]:
    """Yield the table of the peak tension of each rope, with its limit."""
    limits = {c.subject: c for c in (f.verdict.checks if f.verdict else ()) if c.quantity in ELSEWHERE[:2]}
    rated, rows = f.rec.fact("rated", {}), list[tuple[Cell, ...]]()
    for name, peak in f.peaks.items():
        check = limits.get(name)
        limit = check.limit if check else rated.get(name)
        worst = check.value if check and check.value and check.value > peak.tension * (1.0 + SAME) else None
        use = 100.0 * (worst or peak.tension) / limit if limit else None
        state = check.state if check else "red" if limit and peak.tension > limit else ""
        error = check.error / 1e3 if check and check.error is not None else None
        rows.append((name, peak.tension / 1e3, peak.tension / TONNE, peak.time, f.stage_at(peak.time),
                     worst / 1e3 if worst else None, limit / 1e3 if limit else None,
                     Marked(use, state) if state else use, error))  # fmt: skip
    heads = columns("rope", "peak tension [kN] .1", "as a mass [t] .1", "at [h:min:s]", "stage",
                    "with contingencies [kN] .1", "limit [kN] .1",
                    "use [%] .1", "error [kN] .1")  # fmt: skip
    bases = dict.fromkeys(f"{c.quantity}: {c.basis}." for c in limits.values() if c.basis)
    yield trimmed(Table("Ropes and slings", heads, tuple(rows), tuple(bases)))


def _quantities(f: Facts) -> Iterator[Table]:
    """Yield a table for each quantity that has a limit, from hook to ground."""
    groups: dict[tuple[str, str], list[Check]] = {}
    for c in f.verdict.checks if f.verdict else ():
        if c.basis and c.quantity not in ELSEWHERE and c.value is not None:
            groups.setdefault((c.quantity, c.unit), []).append(c)
    for (quantity, unit), checks in groups.items():
        message, factor, digits = OF_QUANTITY.get(quantity) or UNITS.get(unit, (unit, 1.0, 2))
        form = f"[{message}] .{digits}" if message else f".{digits}"
        heads = columns("item", f"worst {form}", f"limit {form}", "allowed", "use [%] .1", f"error {form}",
                        "at [h:min:s]", "stage", "state", "basis")  # fmt: skip
        bases = list(dict.fromkeys(c.basis for c in checks))
        rows = []
        for c in sorted(checks, key=lambda c: c.subject):
            worst, limit, error = (None if x is None else factor * x for x in (c.value, c.limit, c.error))
            use = None if c.use is None or c.between else 100.0 * c.use
            allowed = (None, c.allowed) if c.between else (limit, "")
            state = Marked(c.word, c.state)
            rows.append((c.subject, worst, *allowed, use, error, c.t, c.stage, state, c.basis if bases[1:] else ""))
        notes = [f"Basis: {bases[0]}."] if len(bases) == 1 else []
        notes += ["The limit is the least value."] if any(c.allowed.startswith("at least") for c in checks) else []
        yield trimmed(Table(quantity.capitalize(), heads, tuple(rows), tuple(notes)))


def _errors(f: Facts) -> Iterator[Table]:
    """Yield the table of error estimates for results that are in no other table."""
    known = f.rec.fact("errors", {}).items()
    errors = [(name, 100.0 * x) for name, x in known if isinstance(x, float) and not name.startswith(LISTED)]
    large = tuple(sorted((x for x in errors if x[1] >= LEAST), key=lambda x: -x[1]))
    others = (f"{len(errors) - len(large)} others: within {LEAST:g} %.",) if len(large) < len(errors) else ()
    yield Table("Errors of figures", columns("figure", "error [%] .2"), large, others)
    for fact, head, title in (
        ("measured", "run less log, uncertainties at 95 %", "Beside a measured lift"),
        ("certified", "figures, with half-widths at 95 %", "Certificate"),
    ):
        yield words(title, (head,), ([line] for line in f.rec.message(fact)))


TABLES: tuple[Callable[[Facts], Iterable[Table]], ...] = (
    _findings, _checks, _scene, _of_verdict, _ropes, _quantities, _clearances, _errors
)  # fmt: skip


def tables_of(found: Facts) -> list[Table]:
    """Return all tables of a report that have rows, in reading order."""
    with found.rec.reading():
        return [table for make in TABLES for table in make(found) if table.rows]
