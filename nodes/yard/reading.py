"""Reading of a yard file and its table of blocks, with every error at its file, row and column.

The order of the activities of a block is given by `after` of the steps. A block comes after another block when its step
that begins the erection comes after the other block's step that ends the erection.
"""

from collections.abc import Sequence
from dataclasses import replace
from datetime import date
from functools import partial
from graphlib import CycleError, TopologicalSorter
from pathlib import Path as FilePath
from typing import Any

from heavylift.kernel.errors import closest, path_text
from heavylift.nodes.queueing.distributions import Fixed
from heavylift.nodes.scene.text.faults import raise_faults
from heavylift.nodes.scene.text.files import scene_text
from heavylift.nodes.scene.text.overlay import override
from heavylift.nodes.scene.text.source import Mark, Path, SourceText, read
from heavylift.nodes.scene.text.table_files import TableCell, with_unit
from heavylift.nodes.scene.text.units import RATIO

from . import fields
from .beginning import HEAD, yard_path
from .calendars import Calendar, Shift, public_holidays, working
from .fields import Taking
from .lifts import Lifter, LiftOrder, rested
from .network import RULES, Activity, Need, Yard, rule_named
from .orders import lift_steps, order_of, taken
from .plans import planned
from .waves import wave_limit
from .weather import weather_of

KEYS = {
    *(HEAD, "name", "start", "calendar", "resources", "blocks", "steps", "erection", "rule", "order", "contract"),
    *("quantile", "weather", "plan"),
}
OF_CALENDAR = {"days", "country", "holidays", "shifts"}
OF_STEP = {"takes", "needs", "until", "after", "works", "source", "lift", "by", "set", "over", "wind", "limits"}
REMARKS = {"mass", "size", "com", "lugs", "stage", "remark", "scene"}
DELIVERY = "delivery"


def load(path: str | FilePath, settings: Sequence[str] = (), lifter: Lifter = rested) -> Yard:
    """Return the yard of a yard file with settings applied; raises SceneError with all errors. `lifter`: function that
    returns the results of the lifts."""
    source = source_of(path, settings)
    yard = _Reading(source, lifter).yard()
    raise_faults(source, source.faults)
    assert yard is not None
    return yard


def source_of(path: str | FilePath, settings: Sequence[str] = ()) -> SourceText:
    """Return the data of a yard file with settings applied; raises SceneError if the file is invalid."""
    path, name = yard_path(path), path_text(path)
    source = read(scene_text(path, name), name, path.parent)
    raise_faults(source, source.faults)
    for setting in settings:
        override(source, setting, lambda *_: None)
    raise_faults(source, source.faults)
    return source


class _Reading(Taking):
    """Reader of a yard from the data of its file."""

    def __init__(self, source: SourceText, lifter: Lifter) -> None:
        super().__init__(source)
        self.start, self.lifter = date.min, lifter

    def yard(self) -> Yard | None:
        """Return the yard that the file describes; None if there were errors."""
        given = self.mapping((), KEYS)
        for key in (HEAD, "start", "resources", "blocks", "steps"):
            if given.get(key) is None:
                self.source.fault((), f"the yard has no '{key}'")
        if given.get(HEAD) != 1:
            self.source.fault((HEAD,), "this version reads 'heavylift yard: 1'")
        self.start = self.take(("start",), fields.day, date(2000, 1, 1))
        calendars = self.calendars()
        capacities, self.types = dict[str, int](), dict[str, str]()
        for key, value in self.mapping(("resources",)).items():
            at = ("resources", key, "units") if isinstance(value, dict) else ("resources", key)
            if isinstance(value, dict):
                self.types[key] = str(self.mapping(("resources", key), {"type", "units"}).get("type") or "")
            capacities[key] = self.take(at, fields.units, 1)
        steps = self.steps(capacities, calendars)
        rule = self.take(("rule",), rule_named, next(iter(RULES)))
        quantile = self.take(("quantile",), RATIO.read, 0.9)
        if not 0 < quantile < 1:
            self.source.fault(("quantile",), "a quantile is between 0 % and 100 %, such as '90 %'")
        if self.source.faults:
            return None
        weather = weather_of(self, self.start)
        activities, blocks = self.activities(steps, capacities, calendars)
        plan = planned(self, self.start, activities)
        if self.source.faults:
            return None
        if plan:
            activities = tuple(replace(x, ready=max(x.ready, t)) for x, t in zip(activities, plan, strict=True))
        return Yard(
            str(given.get("name") or FilePath(self.source.name).stem), self.start, activities, capacities, rule,
            self.order(blocks), self.contract(blocks), quantile,
            {step: str(self.source.at(("steps", step, "source")) or "") for step in steps}, weather, plan,
        )  # fmt: skip

    def calendars(self) -> dict[str, tuple[Shift, ...]]:
        """Return the working intervals of each shift, by name.

        Under "": the intervals of all shifts or, without shifts, the whole day."""
        self.mapping(("calendar",), OF_CALENDAR)
        of_day = self.mapping(("calendar", "shifts"))
        shifts = {key: self.take(("calendar", "shifts", key), fields.shift, ()) for key in of_day}
        return shifts | {"": tuple(w for windows in shifts.values() for w in windows) or ((0, 1440),)}

    def calendar(self, path: Path, words: list[str], shifts: dict[str, tuple[Shift, ...]]) -> Calendar:
        """Return the calendar of the named shifts."""
        if self.source.at(("calendar",)) is None:
            return Calendar()
        listed = self.source.at(("calendar", "holidays"))
        off = set[date]()
        for i, _ in enumerate(listed if isinstance(listed, list) else ()):
            off.update(self.take(("calendar", "holidays", i), lambda x: [*fields.days_off(x)], []))
        if listed is not None and not isinstance(listed, list):
            self.source.fault(("calendar", "holidays"), "list days and ranges: [2027-02-06..2027-02-10]")
        off |= self.take(("calendar", "country"), lambda x: public_holidays(str(x), self.start), frozenset())
        days = self.take(("calendar", "days"), fields.weekdays, (0, 1, 2, 3, 4))
        windows = tuple(w for word in words for w in shifts[word])
        return self.take(path, lambda _: working(self.start, days, windows, frozenset(off)), Calendar(), value=1)

    def steps(self, capacities: dict[str, int], shifts: dict[str, Any]) -> list[str]:
        """Return the steps of a block in topological order, so that each step follows its predecessors."""
        given = self.mapping(("steps",))
        for step in given:
            at = ("steps", step)
            self.mapping(at, OF_STEP)
            self.mapping((*at, "limits"), {"Hs", "from"})
            for resource in self.mapping((*at, "needs")):
                self.known((*at, "needs", resource), resource, capacities, "resource")
                self.needed((*at, "needs", resource), resource, capacities)
            for resource in self.mapping((*at, "until")):
                held = self.mapping((*at, "needs")) if self.source.at((*at, "lift")) is None else capacities
                self.known((*at, "until", resource), resource, held, "need")
                self.known((*at, "until", resource), self.source.at((*at, "until", resource)), given, "step")
            for key, among, what in (("after", given, "step"), ("works", shifts, "shift")):
                for word in fields.words(self.source.at((*at, key))):
                    self.known((*at, key), word, among, what)
        for step in fields.words(self.source.at(("erection",))):
            self.known(("erection",), step, given, "step")
        try:
            after = {s: fields.words(self.source.at(("steps", s, "after"))) for s in given}
            order = [step for step in TopologicalSorter(after).static_order() if step in given]
        except CycleError as error:
            self.source.fault(("steps",), f"steps come after each other in a circle: {_circle(error)}")
            return []
        before: dict[str, set[str]] = {}
        for step in order:
            before[step] = {step}.union(*(before.get(x, set()) for x in after[step]))
        for step in order:
            for resource, until in self.mapping(("steps", step, "until")).items():
                if step not in before.get(str(until), {step}):
                    self.source.fault(("steps", step, "until", resource), f"'{until}' does not come after '{step}'")
        return order

    def needed(self, path: Path, resource: str, capacities: dict[str, int], cell: TableCell | None = None) -> int:
        """Return the number of units of a resource that a step needs; add an error if the resource has fewer units."""
        mark, most = cell.mark if cell else None, capacities.get(resource, 0)
        units = self.take(path, fields.units, 0, mark, cell.text if cell else None)
        if resource in capacities and units > most:
            self.source.fault(path, f"needs {units} of '{resource}', which has {most}", mark=mark)
        return units

    def activities(
        self, steps: list[str], capacities: dict[str, int], shifts: dict[str, Any]
    ) -> tuple[tuple[Activity, ...], list[str]]:
        """Return all activities, block by block, and the names of the blocks."""
        self.mapping(("blocks",), {"from"})
        head, rows = self.table(("blocks", "from"))
        lifts, orders, machines = lift_steps(self, steps), dict[int, LiftOrder](), dict[str, dict[str, int]]()
        if self.source.faults:
            return (), []
        if not rows or not steps:
            self.source.fault(("blocks", "from"), "a yard has at least one block and one step")
        names = [f"{c.key} {c.axis}".strip() if c.key not in REMARKS else c.key for c in head]
        columns = {"after", "ready", *steps, *(f"{s} {r}" for s in steps for r in capacities), *REMARKS}
        columns |= {column for lift in lifts.values() for column in lift.columns}
        for column, name in zip(head[1:], names[1:], strict=True):
            if name not in columns:
                self.source.fault(
                    ("blocks",), f"there is no column '{name}'", closest(name, sorted(columns)), mark=column.mark
                )
        blocks = [row[0].text for row in rows]
        for n, row in enumerate(rows):
            if row[0].text in blocks[:n]:
                self.source.fault(("blocks",), f"the block '{row[0].text}' is given twice", mark=row[0].mark)
        if self.source.faults:
            return (), blocks
        calendars = {
            s: self.calendar(("steps", s), fields.words(self.source.at(("steps", s, "works"))) or [""], shifts)
            for s in steps
        }
        seas = {step: wave_limit(self, step) for step in steps}
        begins, ends = self.erection(steps)
        number = {(block, step): i * len(steps) + j for i, block in enumerate(blocks) for j, step in enumerate(steps)}
        made, marks, waits_for = list[Activity](), list[Mark](), dict[str, list[str]]()
        for row in rows:
            cells = {name: cell for name, cell in zip(names, row, strict=True) if cell.text}
            units = {name: column.unit for name, column in zip(names, head, strict=True)}
            block, at = row[0].text, ("blocks", row[0].text)
            marks.append(cells["after"].mark if "after" in cells else row[0].mark)
            predecessors = self.cell(cells, "after", at, fields.before, [])
            waits_for[block] = [name for name, _ in predecessors]
            for name, _ in predecessors:
                if name not in blocks:
                    self.source.fault(
                        at, f"there is no block '{name}'", closest(name, blocks), mark=cells["after"].mark
                    )
            ready = self.cell(cells, "ready", at, lambda x: fields.instant(self.start, fields.day(x)), 0)
            for step in steps:
                text = self.source.at(("steps", step, "takes"))
                if step in cells:
                    read_one = partial(with_unit, unit=units[step])
                    takes = self.cell(cells, step, at, lambda x: fields.duration(read_one(x)), Fixed(0))  # noqa: B023
                else:
                    takes = self.take(("steps", step, "takes"), lambda x: fields.duration(str(x)), Fixed(0))
                    if text is None and step not in lifts:
                        self.source.fault(at, f"neither column nor step says what '{step}' takes", mark=row[0].mark)
                after = [(number[block, s], 0) for s in fields.words(self.source.at(("steps", step, "after")))]
                if step in begins:
                    after += [(number[b, s], lag) for b, lag in predecessors if b in blocks for s in ends]
                more = dict[str, int]()
                if step in lifts:
                    order = orders[len(made)] = order_of(self, lifts[step], row[0], cells, units)
                    if order.scene not in machines:
                        machines[order.scene] = taken(self, order, step, self.types, capacities)
                    more = machines[order.scene]
                needs = self.needs(step, block, cells, capacities, number, more)
                one = Activity(block, step, takes, needs, tuple(after), max(0, ready), calendars[step], sea=seas[step])
                made.append(one)
        try:
            TopologicalSorter(waits_for).prepare()
            TopologicalSorter({n: [m for m, _ in one.after] for n, one in enumerate(made)}).prepare()
        except CycleError as error:
            first = error.args[1][-1]
            mark = marks[blocks.index(first) if first in blocks else first // len(steps)]
            circle = _circle(error) if first in blocks else " after ".join(made[n].name for n in error.args[1][::-1])
            self.source.fault(("blocks",), f"blocks come after each other in a circle: {circle}", mark=mark)
        return tuple(made) if self.source.faults else self.lifted(made, orders, marks), blocks

    def lifted(self, made: list[Activity], orders: dict[int, LiftOrder], marks: list[Mark]) -> tuple[Activity, ...]:
        """Return the activities with the results of their lifts added."""
        steps = len(made) // len(marks)
        for (n, order), lift in zip(orders.items(), self.lifter([*orders.values()]) if orders else (), strict=True):
            at = marks[n // steps]
            placed = f"{at.file}:{at.line}:{at.column}: {lift.why}" if lift.state == "red" else lift.why
            made[n] = replace(made[n], lift=replace(lift, why=placed), order=order)
            if lift.state == "wrong":
                self.source.fault(("steps", made[n].step, "set"), f"block '{made[n].block}': {lift.why}", mark=at)
                break
        return tuple(made)

    def erection(self, steps: list[str]) -> tuple[list[str], list[str]]:
        """Return the steps that begin the erection of a block, and the steps that end it."""
        given = fields.words(self.source.at(("erection",)))
        if given and len(given) != 2:
            self.source.fault(("erection",), "name the step that begins the erection and the one that ends it")
        after = {s: fields.words(self.source.at(("steps", s, "after"))) for s in steps}
        before = {x for xs in after.values() for x in xs}
        return given[:1] or [s for s in steps if not after[s]], given[1:] or [s for s in steps if s not in before]

    def needs(
        self, step: str, block: str, cells: dict[str, TableCell], capacities: dict[str, int],
        number: dict[tuple[str, str], int], more: dict[str, int],
    ) -> tuple[Need, ...]:  # fmt: skip
        """Return the resources that a step of a block needs, in the order of the list of resources."""
        found = list[Need]()
        for resource in capacities:
            path = ("steps", step, "needs", resource)
            units = self.needed(path, resource, capacities, cells.get(f"{step} {resource}"))
            units = max(units, more.get(resource, 0))
            if units:
                until = self.source.at(("steps", step, "until", resource)) or step
                found.append(Need(resource, units, number[block, str(until)]))
        return tuple(found)

    def order(self, blocks: list[str]) -> tuple[str, ...]:
        """Return the blocks in the order that the yard file gives, followed by all other blocks."""
        given = fields.words(self.source.at(("order",)))
        for block in given:
            self.known(("order",), block, blocks, "block")
        return tuple(dict.fromkeys([*given, *blocks])) if given else ()

    def contract(self, blocks: list[str]) -> dict[str, date]:
        """Return the contract dates of blocks and of the whole delivery, as far as the yard file gives them."""
        given = self.mapping(("contract",))
        for key in given:
            self.known(("contract", key), key, [DELIVERY, *blocks], "block")
        return {key: self.take(("contract", key), fields.day, date.max) for key in given}


def _circle(error: CycleError) -> str:
    return " after ".join(map(str, error.args[1][::-1]))
