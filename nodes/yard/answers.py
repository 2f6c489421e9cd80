"""The results that `heavylift check` and `heavylift run` print for a yard, made from the numbers of its runs."""

from collections.abc import Mapping, Sequence
from datetime import timedelta
from math import ceil, inf, sqrt
from pathlib import Path
from statistics import fmean

from heavylift.recordings.sheets.sheet import Cell, Chart, Marked, Notes, Part, Sheet, Table, columns, stated
from scipy.special import bdtr, bdtrc

from .calendars import DAY
from .dispatching import NO_SHIFT, NOT_READY, WEATHER
from .exchange import gantt
from .fields import at, variance
from .lifts import WAYS
from .models import expected
from .network import RULES, Activity, Yard, chain, dates, serial
from .reading import DELIVERY

Values = Mapping[str, Sequence[float]]  # of all runs, by "dispatcher.ends[3]"
MOST = 20  # blocks that are listed
STOPPED = "weather, in the middle of a lift"
DOUBT = 0.025  # probability, on each side, that a verdict from a sample of runs is wrong


def quantile(values: Sequence[float], part: float) -> float:
    """Return the smallest of the values that at least the fraction `part` of all values do not exceed."""
    return sorted(values)[max(0, ceil(part * len(values) - 1e-9) - 1)]


def examined(yard: Yard) -> Sheet:
    """Return the report of `check` for a yard: schedules, the critical path, and the contract dates."""
    known, path = dates(yard), chain(yard)
    rows = list[tuple[Cell, ...]]()
    for rule, short in RULES.items():
        ends = [max(end for _, end in serial(yard, rule)) / 1e9] if not yard.holding else []
        ends.append(expected(yard, rule).delivery)
        texts = [x for end in ends for x in (at_end(yard, end), end * 1e9 / DAY)]
        rows.append((f"{rule} ({short})", *((None, None) if yard.holding else ()), *texts))
    early = {DELIVERY: max(known.early_finish)}
    for n, one in enumerate(yard.activities):
        early[one.block] = max(early.get(one.block, 0), known.early_finish[n])
    contract = [(key, at_end(yard, early[key] / 1e9), str(day)) for key, day in yard.contract.items()]
    late = [early[key] > _limit(yard, key) * 1e9 for key in yard.contract]
    marked = [(a, Marked(b, "red") if x else b, c) for (a, b, c), x in zip(contract, late, strict=True)]
    names, mean, spread = path
    lines = [
        " - ".join(yard.activities[n].name for n in names),
        f"{mean / 3600:.6g} h of work, standard deviation {sqrt(spread) / 3600:.4g} h (PERT, this path alone)",
    ]
    unsaid = [step for step, source in yard.sources.items() if not source]
    size = f"{len({x.block for x in yard.activities})} blocks, {len(yard.activities)} activities"
    heads = columns("rule", "serial", "after [days] .2", "parallel, as run", "after [days] .2")
    parts: list[Part] = [
        Table("Schedules with expected durations", heads, tuple(rows)),
        Notes("Critical path, resources aside", tuple(lines)),
        Table("Contract", columns("of", "earliest", "contract"), tuple(marked)),
    ]  # fmt: skip
    parts += [*_lifts(yard), *_waves(yard)]
    if unsaid:
        parts.append(Notes("Durations without a source", (", ".join(unsaid),)))
    state = "red" if any(late) or impossible(yard) else "green"
    lead = "a contract date is before the earliest possible one" if any(late) else "all contract dates are possible"
    leads = [_red_lifts(yard), lead if yard.contract else "no contract dates are given"]
    return Sheet(f"{yard.name}: {size}", stated(state, *leads), state, tuple(parts))


def impossible(yard: Yard) -> list[Activity]:
    """Return the activities whose lift cannot be carried out, because its verdict is red."""
    return [one for one in yard.activities if one.lift and one.lift.state == "red"]


def _red_lifts(yard: Yard) -> str:
    red = impossible(yard)
    return f"{len(red)} lift{'s' * (len(red) > 1)} cannot be carried out, first {red[0].block}" if red else ""


def _lifts(yard: Yard) -> list[Table]:
    """Return the table of lifts by scene and method, with their durations and wind limits, and the table of lifts that
    cannot be carried out."""
    groups = dict[tuple[str, str, str], list[Activity]]()
    for one in yard.activities:
        if one.lift and one.order:
            groups.setdefault((one.step, Path(one.order.scene).stem, WAYS[one.order.way]), []).append(one)
    rows = list[tuple[Cell, ...]]()
    for key, own in groups.items():
        able = [one.lift for one in own if one.lift and one.lift.stages]
        if able:
            times, winds = [x.seconds / 60 for x in able], [min(x.wind for x in able), min(x.stop for x in able)]
            limits = [wind if wind < inf else None for wind in winds]
            rows.append((*key, len(own), min(times), max(times), 100 * max(x.error for x in able), *limits))
    heads = columns("step", "scene", "how", "lifts .0", "least [min] .1", "most [min] .1", "error [%] .2",
                    "begins up to [m/s] .1", "stops at [m/s] .1")  # fmt: skip
    sure = sum(one.lift.error * one.lift.seconds for one in yard.activities if one.lift) / 3600
    notes = (f"All errors together are {sure:.2g} h of work.", *((f"Wind limits: error {most:.2%}.",) if (most := max(
        (one.lift.wind_error for one in yard.activities if one.lift), default=0.0)) else ()))  # fmt: skip
    red = tuple((one.block, one.step, Marked(one.lift.why)) for one in impossible(yard) if one.lift)
    return [
        Table("Lifts, from the mechanics", heads, tuple(rows), notes),
        Table("Lifts that cannot be carried out", columns("block", "step", "why"), red[:MOST]),
    ]


def _waves(yard: Yard) -> list[Notes]:
    """Return what the series of the sea does not say about peak periods that limits of steps depend on."""
    sea, found = yard.weather.sea, list[str]()
    for step, limit in {one.step: one.sea for one in yard.activities if one.sea}.items():
        if sea and limit and not sea.periods and not limit.steady:
            found.append(
                f"{step}: the sea has no peak periods, so the limit is the lowest of all, {limit.at(None):g} m"
            )
        elif sea and limit and (beyond := sum(limit.at(x) < 0.0 for x in sea.periods)):
            found.append(f"{step}: closed in {beyond} of {len(sea.periods)} hours, whose peak period has no limit")
    return [Notes("Waves", tuple(found))] if found else []


def delivery(values: Values) -> Sequence[float]:
    """Return the delivery time of the yard [s] in each run."""
    return values["dispatcher.delivery"]


def finishes(yard: Yard, values: Values) -> dict[str, Sequence[float]]:
    """Return the finish times [s], one for each run, of the yard and of each block with a contract date."""
    found: dict[str, Sequence[float]] = {DELIVERY: delivery(values)}
    for block in yard.contract:
        own = [n for n, one in enumerate(yard.activities) if one.block == block]
        if own:
            found[block] = [max(row) for row in zip(*(values[f"dispatcher.ends[{n}]"] for n in own), strict=True)]
    return found


def chances(yard: Yard, values: Values) -> dict[str, float]:
    """Return, for each contract date, the fraction of the runs that meet the date."""
    found = finishes(yard, values)
    return {key: sum(t <= _limit(yard, key) for t in found[key]) / len(found[key]) for key in yard.contract}


def contract_states(yard: Yard, values: Values) -> dict[str, str]:
    """Return the state of each contract date of a yard: red, undecided, amber or green.

    Undecided if the replications leave open whether it is met with the required probability; amber if it is met in a
    single run, but durations or winds are random.

    The test is the exact one for a proportion (Clopper and Pearson 1934, Biometrika 26)."""
    runs, found = len(delivery(values)), dict[str, str]()
    drawn = any(x and x.drawn for x in (yard.weather.wind, yard.weather.sea))
    certain = not drawn and not any(variance(one.takes) for one in yard.activities)
    for key, chance in chances(yard, values).items():
        kept = round(chance * runs)
        if certain or runs == 1:
            found[key] = ("green" if certain else "amber") if kept == runs else "red"
        else:
            lucky, unlucky = bdtrc(kept - 1, runs, yard.quantile), bdtr(kept, runs, yard.quantile)
            found[key] = "green" if lucky <= DOUBT else "red" if unlucky <= DOUBT else "undecided"
    return found


def state_of(yard: Yard, values: Values) -> str:
    """Return the state of the yard's plan: the worst state of its contract dates, or red if a lift is impossible."""
    found = {*contract_states(yard, values).values()}
    if impossible(yard) or _red_runs(values):
        return "red"
    return next((state for state in ("red", "undecided", "amber") if state in found), "green")


def _red_runs(values: Values) -> float:
    return sum(sum(x) for key, x in values.items() if key.endswith(".red"))


def answered(yard: Yard, values: Values, drawn: bool = False) -> Sheet:
    """Return the report of `run` for a yard: quantiles of key dates, their sensitivities, and causes of waiting.

    For a single run also the schedule, with a Gantt chart if `drawn`."""
    runs, kept, judged = len(delivery(values)), chances(yard, values), contract_states(yard, values)
    rows = list[tuple[Cell, ...]]()
    for key, ends in finishes(yard, values).items():
        texts: list[Cell] = [at_end(yard, quantile(ends, part)) for part in (0.1, 0.5, 0.9)]
        cell = Marked(100 * kept[key], judged[key]) if key in kept else None
        rows.append((key, *(texts if runs > 1 else texts[:1]), str(yard.contract.get(key, "")), cell))
    heads = ("P10", "P50", "P90") if runs > 1 else ("done",)
    parts: list[Part] = [
        Table("Key dates", columns("of", *heads, "contract", "kept [%] .1"), tuple(rows)),
        Table("Waiting of all activities, by cause", columns("for", "mean [h] .1"), tuple(waits(yard, values))),
        _use(yard, values),
        *_lifts(yard),
        *_waves(yard),
        _criticality(yard, values, runs) if runs > 1 else _schedule(yard, values, drawn),
    ]
    if drawn and runs == 1:
        title = "Schedule, a row for each block; what was critical is outlined"
        parts.insert(1, Chart(title, gantt(yard, spans(yard, values))))
    title = f"{yard.name}: {runs} replications" if runs > 1 else f"{yard.name}: one run with expected durations"
    simulated = f"{_red_runs(values):g} lifts were red when they were simulated" if _red_runs(values) else ""
    lead = _promised(yard, judged, runs) if yard.contract else f"delivery {rows[0][1]}"
    state = state_of(yard, values)
    return Sheet(title, stated(state, _red_lifts(yard), simulated, lead), state, tuple(parts))


def _promised(yard: Yard, judged: Mapping[str, str], runs: int) -> str:
    """Return in words which contract dates are met with the required probability."""
    late, open_ = ([key for key, x in judged.items() if x == state] for state in ("red", "undecided"))
    percent = f"{100 * yard.quantile:g} %"
    if late:
        return f"late at P{100 * yard.quantile:g}: {', '.join(late)}" if runs > 1 else f"late: {', '.join(late)}"
    if open_:
        return f"{runs} replications leave open whether {', '.join(open_)} is met with {percent}; run more of them"
    if "amber" in judged.values():
        return f"contract dates are met in this run; '--replications 100' shows whether they are with {percent}"
    return f"contract dates are met with at least {percent}" if runs > 1 else "contract dates are met"


def waits(yard: Yard, values: Values) -> list[tuple[str, float]]:
    """Return the total time [h] that all activities waited, by cause, as a mean over the runs."""
    causes = (NOT_READY, NO_SHIFT, WEATHER, *yard.capacities)
    means = [fmean(values[f"dispatcher.waits[{n}]"]) / 3600 for n in range(len(causes))]
    stopped = sum(fmean(x) for key, x in values.items() if key.endswith(".stopped")) / 3600
    return [(cause, mean) for cause, mean in [*zip(causes, means, strict=True), (STOPPED, stopped)] if mean]


def _use(yard: Yard, values: Values) -> Table:
    """Return the table of resources: number of units, and mean and largest number in use."""
    rows = [
        (name, units, fmean(values[f"resource-{name}.used"]), max(values[f"resource-{name}.most"]))
        for name, units in yard.capacities.items()
    ]
    return Table("Resources", columns("resource", "units [1] .0", "mean use [1] .2", "most [1] .0"), tuple(rows))


def _criticality(yard: Yard, values: Values, runs: int) -> Table:
    """Return the table of the share of runs in which each activity was on the critical sequence."""
    shares = [100 * sum(values[f"dispatcher.critical[{n}]"]) / runs for n in range(len(yard.activities))]
    order = sorted(range(len(shares)), key=lambda n: (-shares[n], n))
    rows = [(yard.activities[n].block, yard.activities[n].step, shares[n]) for n in order[:MOST] if shares[n]]
    return Table("On the critical sequence", columns("block", "step", "of runs [%] .1"), tuple(rows))


def spans(yard: Yard, values: Values) -> list[tuple[float, float, bool]]:
    """Return, for each activity in a single run, its start and end [s] and whether it is critical."""
    keys = ("starts", "ends", "critical")
    rows = [[values[f"dispatcher.{key}[{n}]"][0] for key in keys] for n in range(len(yard.activities))]
    return [(start, end, bool(critical)) for start, end, critical in rows]


def _schedule(yard: Yard, values: Values, whole: bool) -> Table:
    """Return the table with start and end of each critical activity, or of all activities if `whole`."""
    rows = [
        (one.block, one.step, at_end(yard, start), at_end(yard, end), *(("yes" if critical else "",) if whole else ()))
        for one, (start, end, critical) in zip(yard.activities, spans(yard, values), strict=True)
        if critical or whole
    ]
    heads = columns("block", "step", "start", "end", *(("critical",) if whole else ()))
    if whole:
        return Table("Schedule", heads, tuple(rows))
    rows.sort(key=lambda row: row[2:])
    note = f"'--report schedule.csv' writes all {len(yard.activities)} activities."
    return Table("Critical sequence of this run", heads, tuple(rows), (note,))


def at_end(yard: Yard, t: float) -> str:
    """Return a time since the start of the yard [s] as date and time of day."""
    return f"{at(yard.start, t):%Y-%m-%d %H:%M}"


def _limit(yard: Yard, key: str) -> float:
    """Return the end [s] of the day of a contract date."""
    return (yard.contract[key] + timedelta(1) - yard.start).days * DAY / 1e9
