"""What-if studies of a yard: comparison of variants, the limit of a number, the cost in days of each resource and
spread.

All variants use common random numbers: the duration drawn for a block is the same in each variant.
"""

from collections.abc import Callable, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass
from itertools import product

from heavylift.coordinator.run.replications import replicate
from heavylift.kernel.errors import SceneError
from heavylift.nodes.scene.text.spelling import range_of
from heavylift.nodes.yard.answers import Values, at_end, chances, delivery, quantile, state_of, waits
from heavylift.nodes.yard.calendars import DAY
from heavylift.nodes.yard.exchange import exported
from heavylift.nodes.yard.network import Yard
from heavylift.nodes.yard.optimising import optimised
from heavylift.nodes.yard.orders import values as steps_of
from heavylift.recordings.sheets.sheet import Cell, Marked, Sheet, Table, columns, stated

from .model import load_yard

MOST = 1000  # variants
PARTS = (0.1, 0.5, 0.9)
NEAR = 0.01  # of a range that is no whole number


@dataclass(frozen=True)
class Replicated:
    """A yard and the results of its replications."""

    yard: Yard
    values: Values

    @property
    def days(self) -> Sequence[float]:
        """Number of days from the start to the delivery, for each replication."""
        return [t * 1e9 / DAY for t in delivery(self.values)]

    @property
    def state(self) -> str:
        """Verdict on the yard: whether all lifts can be made and contract dates are met with the required
        probability."""
        return state_of(self.yard, self.values)

    def cells(self) -> list[Cell]:
        """Return cells of a table row for these replications: quantiles of the delivery date, chance of meeting
        contract dates, main cause of waiting."""
        dates = [at_end(self.yard, quantile(delivery(self.values), part)) for part in PARTS]
        kept = min((100 * x for x in chances(self.yard, self.values).values()), default=None)
        most = max(waits(self.yard, self.values), key=lambda x: x[1], default=("", 0.0))
        return [*dates, Marked(kept, self.state), most[0]]


Say = Callable[[str], None]
HEADS = ("P10", "P50", "P90", "contracts kept [%] .1", "waits most for")


@dataclass(frozen=True)
class YardStudy:
    """Replications of variants of a yard file, all with the same seed, on any executor of concurrent.futures."""

    file: str
    settings: tuple[str, ...] = ()
    count: int = 100
    seed: int = 1
    executor: Executor | None = None
    workers: int = 0
    say: Say = lambda text: None

    def of(self, *more: str, file: str = "") -> Replicated:
        """Replicate the yard with further settings, or the yard in `file`, and return the results; raises
        HeavyliftError for invalid settings."""
        file, settings = file or self.file, [*self.settings, *more]
        yard = load_yard(file, settings)
        build = f"heavylift.coordinator.yards.model:yard({file!r}, {settings!r})"
        found = replicate(build, self.count, self.seed, executor=self.executor, workers=self.workers).values
        made = Replicated(yard, {key.partition(".")[2]: x for key, x in found.items()})
        self.say(f"{', '.join(more) or file}: P90 {at_end(yard, quantile(delivery(made.values), 0.9))}")
        return made

    def varied(self, vary: Sequence[str]) -> Sheet:
        """Replicate the yard for all combinations of values of the axes, each written as `PATH=VALUES`."""
        axes = [axis_of(text) for text in vary]
        variants = [*product(*(texts for _, texts in axes))]
        if not vary or len(variants) > MOST:
            raise SceneError(f"--vary: {len(variants)} variants; give at least one axis, and at most {MOST} in all")
        rows, states = list[tuple[Cell, ...]](), list[str]()
        for texts in variants:
            made = self.of(*(f"{path}={text}" for (path, _), text in zip(axes, texts, strict=True)))
            rows.append((*texts, *made.cells()))
            states.append(made.state)
        heads = columns(*(path for path, _ in axes), *HEADS)
        counts = {state: states.count(state) for state in ("green", "undecided", "red")}
        lead = ", ".join(f"{count} {state}" for state, count in counts.items() if count)
        table = Table(f"Variants, {self.count} replications each", heads, tuple(rows))
        best = next(state for state, count in counts.items() if count)
        return Sheet(f"Variants of {self.file}", stated(best, f"{len(states)} variants: {lead}"), best, (table,))

    def beside(self, other: str) -> Sheet:
        """Compare the replications of two yard files, with the distribution of their difference."""
        a, b = self.of(), self.of(file=other)
        later = [y - x for x, y in zip(a.days, b.days, strict=True)]
        rows = [(name, *made.cells()) for name, made in ((self.file, a), (other, b))]
        named = [*dict.fromkeys(cause for made in (a, b) for cause, _ in waits(made.yard, made.values))]
        hours = [dict(waits(made.yard, made.values)) for made in (a, b)]
        gap = tuple(quantile(later, part) for part in PARTS)
        heads = columns("plan", *HEADS)
        lead = f"the second is {abs(gap[1]):.1f} days {'later' if gap[1] > 0 else 'earlier'} (P50)"
        parts = (
            Table(f"Two plans, {self.count} replications each", heads, tuple(rows)),
            Table("The second is later by", columns("P10 [days] .2", "P50 [days] .2", "P90 [days] .2"), (gap,)),
            Table("Waiting", columns("for", "first [h] .1", "second [h] .1"),
                  tuple((cause, *(x.get(cause, 0.0) for x in hours)) for cause in named)),
        )  # fmt: skip
        return Sheet(f"{self.file} beside {other}", stated(b.state, lead), b.state, parts)

    def planned(self, out: str, effort: float, force: bool) -> Sheet:
        """Optimise the schedule with CP-SAT, write it to a file, and compare it with the schedule by the yard's
        dispatch rule."""
        yard = load_yard(self.file, self.settings)
        found = optimised(yard, effort)
        spans = [(a / 1e9, b / 1e9, False) for a, b in found.spans]
        path = exported(yard, spans, out, force)
        both = (("as it is", self.of()), (f"plan {path.name}", self.of(f"plan={path.name}")))
        rows = [(name, *made.cells()) for name, made in both]
        lead = (
            f"done {at_end(yard, found.end / 1e9)} by {found.how} with expected durations; no schedule is done before "
            f"{at_end(yard, found.bound / 1e9)}, gap {found.gap:.1%}"
        )
        table = Table(f"Robustness, {self.count} replications each", columns("plan", *HEADS), tuple(rows))
        return Sheet(f"Schedule of {self.file}", stated("green", lead), "green", (table,))

    def sensitivities(self) -> Sheet:
        """Compute the days that one more unit of each resource saves, from expected durations and without weather."""
        base = self.of()
        yard, rows = base.yard, list[tuple[Cell, ...]]()
        mean = {one.step: one.takes.mean for one in yard.activities}
        cases = [
            (f"{name}, one more", _units(self.file, self.settings, name, units + 1))
            for name, units in yard.capacities.items()
        ]
        cases += [(f"{step} takes what is expected", f"steps.{step}.takes={x!r} s") for step, x in mean.items()]
        cases += [("no weather", "weather=none")] if yard.weather.wind or yard.weather.sea else []
        for name, setting in cases:
            days = self.of(setting).days
            gains = (quantile(base.days, part) - quantile(days, part) for part in PARTS[1:])
            rows.append((name, *gains))
        rows.sort(key=lambda row: -float(str(row[2])))
        heads = columns("change", "earlier at P50 [days] .2", "earlier at P90 [days] .2")
        table = Table(f"Days earlier, {self.count} replications each", heads, tuple(rows))
        return Sheet(f"Sensitivities of {self.file}", stated(base.state, f"most: {rows[0][0]}"), base.state, (table,))

    def limit(self, of: str) -> Sheet:
        """Find the last number in a range such as `PATH=72..40` at which contract dates are met often enough."""
        path, _, text = (part.strip() for part in of.partition("="))
        found = range_of(text)
        if found is None:
            raise SceneError(f"--of '{of}': write PATH=FROM..TO, such as 'resources.welders=72..40'")
        low, high, unit = float(found.low), float(found.high), found.unit
        whole = low.is_integer() and high.is_integer() and not unit
        near, shown = (1.0, int) if whole else (NEAR * abs(high - low), float)

        def green(x: float) -> bool:
            return self.of(f"{path}={shown(x)} {unit}".strip()).state == "green"

        state = "green"
        if not green(low):
            lead, low, high, state = f"{path} is not green at the start, {shown(low)} {unit}", high, low, "red"
        elif green(high):
            lead, low = f"{path} is green up to {shown(high)} {unit}, the end of the range", high
        else:
            while abs(high - low) > near:
                middle = (low + high) / 2
                middle = float(int(middle)) if whole else middle
                low, high = (middle, high) if green(middle) else (low, middle)
            lead = f"{path}: green up to {shown(low)} {unit}, not green at {shown(high)} {unit}"
        row = path, f"{low:g} {unit}", f"{high:g} {unit}"
        table = Table("Limit", columns("number", "green up to", "not green at"), (row,))
        return Sheet(f"Limit of {self.file}", stated(state, lead.replace(" ,", ",").strip()), state, (table,))


def axis_of(text: str) -> tuple[str, tuple[str, ...]]:
    """Return path and values of an axis written as `PATH=1..3 by 1` or `PATH={one, another}`."""
    path, equals, values = (part.strip() for part in text.partition("="))
    if not (equals and path and values):
        raise SceneError(f"--vary '{text}': write PATH=VALUES, such as 'resources.welders.units=1..3 by 1'")
    if values[0] == "{" and values[-1] == "}" and ":" not in values:
        return path, tuple(part.strip() for part in values[1:-1].split(","))
    try:
        return path, steps_of(values) if range_of(values) else (values,)
    except ValueError as error:
        raise SceneError(f"--vary '{text}': {error}") from None


def _units(file: str, settings: Sequence[str], name: str, units: int) -> str:
    """Return the setting that changes the number of units of a resource, in either form in which the file may state
    it."""
    from heavylift.nodes.yard.reading import source_of

    typed = isinstance(source_of(file, settings).at(("resources", name)), dict)
    return f"resources.{name}{'.units' if typed else ''}={units}"
