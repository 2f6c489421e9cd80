"""Sensitivity of each result figure to each uncertain input: central differences, or a small design of runs where
events switch.

Each uncertain input is moved by one standard uncertainty to either side. If the two differences are not nearly
opposite, or a figure is missing in one of the runs, an event switches in between: then two more runs are made, at the
ends of the input's range (of 95 % of it), and the largest deviation counts. Contributions are added as squares, since
inputs are assumed to be independent (GUM, JCGM 100:2008, 5.1.2); half-widths are two standard uncertainties.
"""

import logging
from collections.abc import Callable, Sequence
from concurrent.futures import Future
from dataclasses import dataclass
from math import hypot, sqrt
from pathlib import Path

from heavylift.coordinator.ladder.choosing import chosen
from heavylift.coordinator.ladder.figures import AskedFigure
from heavylift.coordinator.ladder.run_pool import Ran, Start, result, starting
from heavylift.coordinator.supervision.pool import cores
from heavylift.kernel.errors import HeavyliftError, ModelError
from heavylift.nodes.scene import LoadedScene, loaded
from heavylift.nodes.scene.inputs import UncertainInput, uncertain_inputs, unstated, varied
from heavylift.recordings.render.curves import larger
from heavylift.recordings.sheets.sheet import Table, columns, part_text

LOG = logging.getLogger("heavylift.ladder")
LEVEL = 2.0  # standard uncertainties of a bar
STEPS = (-1.0, 1.0)  # standard uncertainties by which an input is moved
BENT = 0.5  # of the difference of two runs: as much as their mean may be off the nominal one where nothing switches
SHOWN = 12  # inputs that are named
NOISE = 1e-4  # of a figure: what is less is that of the steps


@dataclass(frozen=True)
class Effect:
    """Change of a figure [SI] when an input is increased by two standard uncertainties.

    `switches`: the figure does not respond proportionally, and the change is the largest deviation among several runs.
    """

    input: str
    moves: float
    switches: bool = False


@dataclass(frozen=True)
class Sensitivities:
    """Nominal figures of a scene, and the effects of its uncertain inputs on each figure, largest first.

    Also inputs, failed inputs with the reasons, inputs without a stated uncertainty, notes, and CPU time [s].
    """

    figures: list[AskedFigure]
    effects: dict[str, list[Effect]]
    inputs: list[UncertainInput]
    failed: dict[str, str]
    unstated: list[str]
    notes: list[str]
    cpu_s: float = 0.0

    def bar(self, figure: str) -> float:
        """Return the half-width of a figure's uncertainty due to the uncertainties of all inputs together [SI]."""
        return hypot(*(effect.moves for effect in self.effects[figure]))

    def __str__(self) -> str:
        parts = [part_text(self._table(figure)) for figure in sorted(self.figures, key=self._relative, reverse=True)]
        return "\n\n".join([*parts, *([of_unstated(self.unstated)] if self.unstated else []), *self.notes])

    def data(self) -> dict[str, object]:
        """Return the sensitivities as plain data in SI units, with half-widths of 95 % intervals."""
        return {
            "figures": [
                {"name": f.name, "quantity": f.quantity, "unit": f.unit, "value": f.value, "bar": self.bar(f.name),
                 "effects": [{"input": e.input, "moves": e.moves, "share": self._share(f.name, e),
                              "switches": e.switches} for e in self.effects[f.name]]}
                for f in self.figures
            ],
            "inputs": [{"name": x.name, "value": x.value, "kind": x.kind, "sd": x.sd} for x in self.inputs],
            "failed": self.failed, "unstated": self.unstated, "notes": self.notes,
        }  # fmt: skip

    def _relative(self, figure: AskedFigure) -> float:
        return self.bar(figure.name) / (abs(figure.scale) or 1.0)

    def _share(self, figure: str, effect: Effect) -> float:
        return effect.moves**2 / (self.bar(figure) ** 2 or 1.0)

    def _table(self, figure: AskedFigure) -> Table:
        factor, unit = larger(figure.unit)
        known = {each.name: str(each) for each in self.inputs}
        bar = factor * self.bar(figure.name)
        part = f" ({100.0 * self._relative(figure):.2g} %)" if figure.value == figure.scale else ""
        rows = (
            (
                known[e.input],
                f"{factor * e.moves:+.2g} {unit}",
                100.0 * self._share(figure.name, e),
                "switches" * e.switches,
            )
            for e in self.effects[figure.name]
        )
        title = f"{figure.name}: {factor * figure.value:.5g} +- {bar:.2g} {unit}{part} by its inputs"
        return Table(title, columns("input", "moves it by", "share [%] .0", ""), tuple(rows))


@dataclass(frozen=True)
class Moved:
    """Runs in which one input was changed, by its change in standard uncertainties; a text states why a run could
    not start."""

    input: UncertainInput
    runs: dict[float, Future[Ran] | str]


def sensitivities(
    scene: LoadedScene | str | Path, given: Sequence[str] = (), at_once: int | None = None,
    say: Callable[[str], None] = LOG.info,
) -> Sensitivities:  # fmt: skip
    """Compute the effects of the uncertain inputs of a scene (loaded, its path or name) on the figures of its run;
    raises HeavyliftError.

    `at_once`: parallel processes (default: one per core; 0: runs in this process); `given`: uncertainties in addition
    to those of the scene, such as `block.mass +- 3 %`.
    """
    scene = chosen(loaded(scene), say)
    inputs = uncertain_inputs(scene, given)
    if not inputs:
        raise ModelError(
            f"{scene.path.name}: states no uncertainties; add one after a value, such as 'mass: 480 t +- 3 %', "
            "or give --input 'block.mass +- 3 %'"
        )
    at_once = min(cores(), 2 * len(inputs)) if at_once is None else at_once
    with starting(at_once) as start:
        nominal = result(start(scene.plan))
        if isinstance(nominal, str):
            raise ModelError(nominal)
        each, n = f"{nominal.cpu_s:.2g} s each", max(at_once, 1)
        say(f"{2 * len(inputs)} runs of about {each}, {n} at a time; two more for an input that makes events switch")
        return effects(scene, [moved(scene, one, STEPS, start) for one in inputs], nominal.figures, start)


def of_unstated(names: Sequence[str]) -> str:
    """Return a sentence that names the inputs without a stated uncertainty."""
    more = f" and {len(names) - SHOWN} more" if len(names) > SHOWN else ""
    return f"no uncertainty is stated of, and so none counted: {', '.join(names[:SHOWN])}{more}"


def moved(scene: LoadedScene, one: UncertainInput, steps: Sequence[float], start: Start) -> Moved:
    """Start runs in which one input is changed by `steps` standard uncertainties; none for an exactly known input."""
    runs: dict[float, Future[Ran] | str] = {}
    for step in steps if one.sd else ():
        try:
            runs[step] = start(varied(scene, [one], [one.value + step * one.sd]).plan)
        except HeavyliftError as error:
            runs[step] = " ".join(str(error).split())
    return Moved(one, runs)


def effects(scene: LoadedScene, begun: Sequence[Moved], nominal: list[AskedFigure], start: Start) -> Sensitivities:
    """Wait for the started runs, and return the effects of their inputs on the nominal figures."""
    seen = [_Seen(each) for each in begun]
    for one in [x for x in seen if not x.failed and any(x.switches(figure) for figure in nominal)]:
        one.more(moved(scene, one.input, (-one.end, one.end), start))
    counted = [x for x in seen if not x.failed]
    found = {f.name: sorted((x.effect(f) for x in counted), key=lambda e: -abs(e.moves)) for f in nominal}
    inputs, failed = [x.input for x in seen], {x.input.name: x.failed for x in seen if x.failed}
    notes = [f"{name} is missing in all bars: {why}" for name, why in failed.items()]
    spent = sum(x.cpu_s for x in seen)
    known = Sensitivities(nominal, found, inputs, failed, unstated(scene, inputs), notes, spent)
    known.notes.extend(_finer(scene, known))
    return known


class _Seen:
    """Results of the runs with one input moved: figures by step."""

    def __init__(self, begun: Moved) -> None:
        self.input, self.failed, self.cpu_s = begun.input, "", 0.0
        self.values: dict[float, dict[str, float]] = {}
        self.end = sqrt(3.0) if self.input.kind == "uniform" else LEVEL
        self.more(begun)

    def more(self, begun: Moved) -> None:
        """Wait for the runs in which this input was changed, and add their figures to the results."""
        for step, run in begun.runs.items():
            ended = run if isinstance(run, str) else result(run)
            if isinstance(ended, str):
                value = self.input.rounded(self.input.value + step * self.input.sd, self.input.sd)[0]
                self.failed = f"the run with {value} fails: {ended}"
            else:
                self.cpu_s += ended.cpu_s
                self.values[step] = {figure.name: figure.value for figure in ended.figures}

    def switches(self, figure: AskedFigure) -> bool:
        """Return whether a figure responds nonlinearly to the input, for example because ropes go slack or bodies
        collide."""
        if not self.input.sd:
            return False
        down, up = (self.values[step].get(figure.name) for step in STEPS)
        if down is None or up is None:
            return True
        bend = abs(0.5 * (up + down) - figure.value)
        return bend > BENT * 0.5 * abs(up - down) and bend > NOISE * abs(figure.scale)

    def effect(self, figure: AskedFigure) -> Effect:
        """Return the change of a figure if the input changes by the half-width of its 95 % interval."""
        if not self.input.sd:
            return Effect(self.input.name, 0.0)
        if not self.switches(figure):
            half = 0.5 * (self.values[1.0][figure.name] - self.values[-1.0][figure.name])
            return Effect(self.input.name, LEVEL * half)
        off = (values.get(figure.name, figure.value) - figure.value for values in self.values.values())
        return Effect(self.input.name, max(off, key=abs), switches=True)


def _finer(scene: LoadedScene, found: Sensitivities) -> list[str]:
    """Return notes on accuracies that the scene requests beyond the uncertainty of its inputs."""
    wanted, notes = scene.facts.accuracy, []
    for quantity in scene.facts.own:
        parts = [(found.bar(f.name) / (abs(f.scale) or 1.0), f.name) for f in found.figures if f.quantity == quantity]
        part, name = max(parts, default=(0.0, ""))
        if part > wanted:
            asked = f"{quantity} is asked to {100.0 * wanted:.3g} %"
            notes.append(f"{asked}, finer than the inputs carry: they leave {name} uncertain by {100.0 * part:.2g} %")
    return notes
