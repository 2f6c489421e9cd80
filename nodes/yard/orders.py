"""Lifts as a yard file describes them: scene, settings of each block, method by which the results are found, and the
cranes used."""

from dataclasses import dataclass
from typing import get_args

from heavylift.kernel.errors import SceneError, closest
from heavylift.nodes.scene.text.files import scene_file
from heavylift.nodes.scene.text.spelling import number_and_unit, range_of
from heavylift.nodes.scene.text.table_files import TableCell, with_unit
from heavylift.nodes.scene.text.units import SPEED

from .fields import Taking
from .lifts import LiftOrder, Way, cranes

MOST = 1000  # runs of a table


@dataclass(frozen=True)
class LiftStep:
    """The lift of a step as written in a yard file: scene, settings, and method that finds the duration.

    `sets`: pairs of path and text or =column; `over`: axes of the table of results, if any."""

    step: str
    scene: str
    sets: tuple[tuple[str, str], ...]
    way: Way
    over: tuple[tuple[str, tuple[str, ...]], ...]
    windy: float

    @property
    def columns(self) -> set[str]:
        """The columns of the table of blocks from which the settings of the lift take values."""
        return {text[1:] for _, text in self.sets if text[:1] == "="}


def lift_steps(given: Taking, steps: list[str]) -> dict[str, LiftStep]:
    """Return the steps that are lifts, by name."""
    found = dict[str, LiftStep]()
    for step in steps:
        at = ("steps", step)
        scene = given.source.at((*at, "lift"))
        alone = [key for key in ("by", "set", "over", "wind") if given.source.at((*at, key)) is not None]
        if scene is None:
            if alone:
                given.source.fault((*at, alone[0]), "this is for steps with a 'lift'", on_key=True)
            continue
        way = str(given.source.at((*at, "by")) or "rest")
        given.known((*at, "by"), way, get_args(Way), "way to know a lift")
        sets = given.source.at((*at, "set"))
        pairs = tuple((str(key), str(x)) for key, x in sets.items()) if isinstance(sets, dict) else ()
        axes = given.source.at((*at, "over"))
        over = tuple(
            (axis, given.take((*at, "over", axis), lambda x: values(str(x)), ("0",)))
            for axis in (axes if isinstance(axes, dict) else ())
        )
        windy = given.take((*at, "wind"), lambda x: SPEED.read(str(x)), 0.0)
        path = given.take((*at, "lift"), lambda x: found_scene(given, str(x)), "")
        one = found[step] = LiftStep(step, path, pairs, way, over, windy)  # type: ignore[arg-type]
        for axis, _ in over:
            given.known((*at, "over", axis), axis, one.columns, "column that 'set' names,")
        if (way == "table") != bool(over):
            given.source.fault(at, "a table of lifts needs 'by: table', and axes 'over: {mass: 100..500 t by 200 t}'")
        if runs(over) > MOST:
            given.source.fault((*at, "over"), f"this table needs more than {MOST} runs")
    return found


def values(text: str) -> tuple[str, ...]:
    """Return the values on an axis such as `100..500 t by 200 t`, each with its unit."""
    found = range_of(text)
    low, high, by = (float(found.low), float(found.high), float(found.step or 0)) if found else (0.0, 0.0, 0.0)
    if not found or not low < high or not 0 < by <= high - low or (high - low) / by > MOST:
        raise ValueError(f"'{text}' is not a valid axis of a table: write it as '100..500 t by 200 t'")
    count = int((high - low) / by + 1e-9) + 1
    return tuple(f"{low + n * by:.12g} {found.unit}".strip() for n in range(count))


def runs(over: tuple[tuple[str, tuple[str, ...]], ...]) -> int:
    """Return the number of runs for all combinations of the values on these axes."""
    count = 1
    for _, texts in over:
        count *= len(texts)
    return count


def order_of(
    given: Taking, one: LiftStep, row: TableCell, cells: dict[str, TableCell], units: dict[str, str]
) -> LiftOrder:
    """Return the lift of a block in a step of the yard; an error refers to the block's row in the table of blocks.

    A block with its own scene does not use the table of the step: its lift follows the equilibrium path."""
    at, texts, own = ("blocks", row.text), dict[str, str](), cells.get("scene")
    for column in sorted(one.columns):
        if column in cells:
            texts[column] = with_unit(cells[column].text, units[column])
        else:
            text = f"the step '{one.step}' sets the {column} of '{row.text}', which has none"
            given.source.fault(at, text, mark=row.mark)
            texts[column] = "0"
    place = list[float]()
    for axis, marks in () if own else one.over:
        number, unit = number_and_unit(texts.get(axis, "0"))
        if not number or unit != number_and_unit(marks[0])[1]:
            text = f"write the {axis} in the unit of the step's table, such as {marks[0]}"
            given.source.fault(at, text, mark=cells[axis].mark if axis in cells else row.mark)
        x, ends = float(number or 0), [float(number_and_unit(mark)[0]) for mark in (marks[0], marks[-1])]
        if not ends[0] <= x <= ends[1]:
            text = f"{axis} {texts[axis]} is beyond the step's table, from {marks[0]} to {marks[-1]}"
            given.source.fault(at, text, mark=cells[axis].mark if axis in cells else row.mark)
        place.append(x)
    axes = {axis for axis, _ in one.over}
    sets = [(path, text[1:] if text[:1] == "=" else "", text) for path, text in one.sets]
    settings = tuple(f"{path}={texts[column] if column else text}" for path, column, text in sets)
    grid = tuple(
        f"{path}=\0{column}\0" if column in axes else f"{path}={texts[column] if column else text}"
        for path, column, text in sets
    )
    if own:
        path = given.take(("steps", one.step, "lift"), lambda x: found_scene(given, x), own.text, own.mark, own.text)
        return LiftOrder(path, settings, "rest" if one.over else one.way, windy=one.windy)
    return LiftOrder(one.scene, settings, one.way, one.over, tuple(place), grid if one.over else (), one.windy)


def found_scene(given: Taking, name: str) -> str:
    """Return the path of a scene in the yard file's folder, or the name of a bundled scene; SceneError if neither."""
    beside = given.source.root / name
    scene = str(beside) if beside.is_file() else name
    scene_file(scene)
    return scene


def taken(
    given: Taking, order: LiftOrder, step: str, types: dict[str, str], capacities: dict[str, int]
) -> dict[str, int]:
    """Return the number of units of each resource that the cranes of a lift occupy.

    Each crane uses the resource with its own name and type or, if there is none, a resource of its type."""
    found = dict[str, int]()
    try:
        machines = cranes(order.scene)
    except SceneError as error:
        given.source.fault(("steps", step, "lift"), str(error).splitlines()[0])
        return found
    for name, kind in machines.items():
        of_kind = [x for x in types if types[x] == kind]
        free = [x for x in of_kind if found.get(x, 0) < capacities[x]]
        own = name if name in free else next(iter(free), "")
        if own:
            found[own] = found.get(own, 0) + 1
        else:
            more = "more " if of_kind else ""
            text = f"'{order.scene}' lifts with {len(machines)} cranes; the yard has no {more}'{kind}' in its resources"
            given.source.fault(("steps", step, "lift"), text, closest(kind, sorted({*types.values()} - {""})))
    return found
