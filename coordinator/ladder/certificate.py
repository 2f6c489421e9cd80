"""How sure the figures of a run are: `2651 +- 4 (numerical) +- 9 (model) +- 80 kN (inputs: ...)`, at a level of 95 %.

After ASME V&V 20-2009, whose u_num and u_input these are; what the level leaves out stands beside them.

numerical   twice the difference to the same run with steps a tenth as tolerant, or half as long; with rigid ropes,
            whose impacts can fork, the larger one of two such runs
model       twice the difference of its level to the witness of that, both in steps of the ladder
inputs      two runs for each uncertain input, added up as squares (`sensitivities`)
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from concurrent.futures import Future
from contextlib import contextmanager
from dataclasses import asdict, dataclass, field
from math import floor, hypot, log10
from pathlib import Path

from heavylift.coordinator.participants.configuration import OPERATOR
from heavylift.coordinator.supervision.pool import cores
from heavylift.kernel.errors import HeavyliftError, ModelError, RecordingError
from heavylift.nodes.models import system
from heavylift.nodes.plan.fidelity import Asked
from heavylift.nodes.plan.plan import Plan
from heavylift.nodes.scene import LoadedScene
from heavylift.nodes.scene.inputs import UncertainInput, uncertain_inputs, unstated
from heavylift.recordings import Recording
from heavylift.recordings.read.extended import amended
from heavylift.recordings.render.curves import larger

from .choosing import chosen
from .figures import AskedFigure
from .measuring import WITNESSED
from .model_levels import DECADE, Ladder, ModelLevel
from .run_pool import Ran, Start, result, starting
from .sensitivities import STEPS, Moved, Sensitivities, effects, moved, of_unstated

ROUNDING = 1e-9  # of a figure: what is left of a bar that is nothing


@dataclass(frozen=True)
class Bar:
    """A figure with the half-widths of its bars in its unit; None where there is none."""

    name: str
    quantity: Asked
    unit: str
    value: float
    numerical: float | None
    model: float | None
    inputs: float | None

    @property
    def whole(self) -> float:
        """All that there are, added up as squares."""
        return hypot(*(x for x in (self.numerical, self.model, self.inputs) if x is not None))

    def told(self, inputs: str) -> str:
        """For people; `inputs`: what is uncertain of them."""
        factor, unit = larger(self.unit)
        places = 1 - floor(log10(factor * self.whole)) if self.whole > 0.0 else 6
        halves = {"numerical": self.numerical, "model": self.model, f"inputs: {inputs}": self.inputs}
        parts = [f"+- {factor * half:.2g} ({what})" for what, half in halves.items() if half is not None]
        if parts:
            parts[-1] = parts[-1].replace(" (", f" {unit} (", 1)
        lacks = [what.partition(":")[0] for what, half in halves.items() if half is None]
        told = " ".join([f"{factor * self.value:.{max(0, places)}f}", *(parts or [unit])]).replace("  ", " ")
        return f"{self.name}: {told}" + f", no bar ({', '.join(lacks)})" * bool(lacks)


@dataclass(frozen=True)
class Certificate:
    """Bars of all figures; why parts of them are missing, by part; the inputs that count, and those that do not; CPU
    time of all runs besides the certified one [s]."""

    bars: list[Bar]
    missing: dict[str, str]
    inputs: list[UncertainInput]
    unstated: list[str]
    cpu_s: float
    notes: list[str] = field(default_factory=list)

    @property
    def told(self) -> list[str]:
        """For people, a line each."""
        inputs = ", ".join(x.spread for x in self.inputs)
        most = max((bar for bar in self.bars if bar.quantity == "limits"), key=lambda bar: bar.value, default=None)
        lines = [bar.told(inputs) for bar in self.bars if bar.quantity != "limits" or bar is most]
        lines += [f"no bar ({part}): {why}" for part, why in self.missing.items()]
        lines += [of_unstated(self.unstated)] if self.unstated else []
        return lines + self.notes

    def data(self) -> dict[str, object]:
        """As plain data, SI units, half-widths at 95 %."""
        return {
            "bars": [asdict(bar) | {"whole": bar.whole} for bar in self.bars],
            "missing": self.missing,
            "inputs": [{"name": x.name, "value": x.value, "kind": x.kind, "sd": x.sd} for x in self.inputs],
            "unstated": self.unstated, "cpu_s": self.cpu_s, "told": self.told,
        }  # fmt: skip


def tighter(plan: Plan) -> list[Plan]:
    """The same with tighter steps, the last one most."""
    once = ModelLevel(plan).tighter
    return [once.plan, once.tighter.plan] if system(plan).rigid_ropes else [once.plan]


def richer(plan: Plan) -> tuple[Plan, Plan] | None:
    """The level of a plan and its witness, both in steps of the ladder; None where there is but one level."""
    ladder = Ladder(plan)
    level = plan.fidelity
    others = ladder.witnesses(level) or ([ladder.poorer] if ladder.poorer else [])
    if not others:
        return None
    steps = ladder.rungs(level)
    rung = steps[min(DECADE, len(steps) - 1)]
    return rung.plan, rung.on(others[0]).plan


@contextmanager
def certifying(scene: LoadedScene, given: Sequence[str] = (), at_once: int | None = None) -> Iterator[Certifying]:
    """Runs beside a run that is to be certified, `at_once` in processes of their own (default: all cores but one).

    `given`: uncertainties besides those that the scene states.  Raises HeavyliftError.
    """
    scene, inputs = chosen(scene), uncertain_inputs(scene, given)
    with starting(max(1, cores() - 1) if at_once is None else at_once) as start:
        yield Certifying(scene, inputs, start)


class Certifying:
    """Runs of which `price` tells how many there are; `certificate` waits for them."""

    def __init__(self, scene: LoadedScene, inputs: list[UncertainInput], start: Start) -> None:
        self._scene, self._inputs, self._start = scene, inputs, start
        self._tight, self._levels = tighter(scene.plan), richer(scene.plan) or ()
        self._begun: tuple[list[Future[Ran]], list[Future[Ran]], list[Moved]] | None = None

    @property
    def price(self) -> str:
        """What the certificate costs, in a sentence."""
        n = 2 * sum(x.sd > 0.0 for x in self._inputs)
        runs = [f"{1 + len(self._tight)} for the steps"]
        runs += [f"2 for the model, one with {ModelLevel(self._levels[1]).level}"] if self._levels else []
        runs += [f"{n} for {len(self._inputs)} uncertain input{'s' * (len(self._inputs) > 1)}"] if n else []
        return f"certifying beside the run, by runs of their own: {', '.join(runs)}; new equations are compiled first"

    def begin(self) -> None:
        """Start all runs."""
        steps = [self._start(plan) for plan in (self._scene.plan, *self._tight)]
        levels = [self._start(plan) for plan in self._levels]
        self._begun = steps, levels, [moved(self._scene, one, STEPS, self._start) for one in self._inputs]

    def written(self, path: Path) -> Certificate:
        """The certificate of the recorded run, once all others have ended; the recording then has it, too."""
        try:
            if Recording(path).events(OPERATOR):
                raise RecordingError("an operator gave orders, which the runs beside it have not had; run without them")
            found = self.certificate()
            amended(path, {"certified": found.data()})
        except HeavyliftError as error:
            raise type(error)(f"{path}: is whole, but has no certificate: {error}") from None
        return found

    def certificate(self) -> Certificate:
        """The certificate of the run."""
        if self._begun is None:
            self.begin()
        assert self._begun is not None
        own, *tight = [result(run) for run in self._begun[0]]
        levels = [result(run) for run in self._begun[1]]
        if isinstance(own, str):
            raise ModelError(own)
        missing: dict[str, str] = {}
        steps = [_halves("numerical", own, each, missing) for each in tight]
        numerical = {f.name: max(x[f.name] for x in steps) for f in own[0] if all(f.name in x for x in steps)}
        model = _halves("model", levels[0], levels[1], missing) if levels else {}
        if not levels:
            missing["model"] = "it is modelled as it is written, there is no richer level"
        elif lost := [f.name for f in own[0] if f.name not in model]:
            missing.setdefault("model", f"the richer level shows no {', '.join(lost[:3])}")
        found = effects(self._scene, self._begun[2], own[0], self._start) if self._inputs else None
        if found is None:
            missing["inputs"] = "no uncertainty is stated; write one behind a value, such as 'mass: 480 t +- 3 %'"
        bars = [
            Bar(f.name, f.quantity, f.unit, f.value, numerical.get(f.name), model.get(f.name), _input_bar(found, f))
            for f in own[0]
        ]
        spent = sum(run[1] for run in (own, *tight, *levels) if isinstance(run, tuple)) + (
            found.cpu_s if found else 0.0
        )
        exact = found.unstated if found else unstated(self._scene, [])
        return Certificate(bars, missing, self._inputs, exact, spent, found.notes if found else [])


def _halves(part: str, run: Ran, other: Ran, missing: dict[str, str]) -> dict[str, float]:
    """Half-widths by figure of what two runs differ by; why some are missing."""
    if isinstance(run, str) or isinstance(other, str):
        missing[part] = f"a run beside it does not come to its end: {run if isinstance(run, str) else other}"
        return {}
    seen = {f.name: f.value for f in other[0]}
    if lost := [f.name for f in run[0] if f.name not in seen]:
        missing[part] = f"the run beside it shows no {', '.join(lost[:3])}"
    return {
        f.name: WITNESSED * abs(f.value - seen[f.name]) + f.misread + ROUNDING * abs(f.scale)
        for f in run[0]
        if f.name in seen
    }


def _input_bar(found: Sensitivities | None, figure: AskedFigure) -> float | None:
    """None where nothing is known of any input."""
    return found.bar(figure.name) if found and len(found.failed) < len(found.inputs) else None
