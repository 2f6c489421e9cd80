"""Error estimates of a run's figures: `2651 +- 4 (numerical) +- 9 (model) +- 80 kN (inputs: ...)`, at a level of 95 %.

After ASME V&V 20-2009 (u_num, u_input); effects that the model level omits are listed, too. Numerical and model errors
are those of `looking.as_it_is`; the error of inputs is the root of the sum of squares of each input's effect, from two
runs each (`sensitivities`).
"""

from collections.abc import Iterator, Sequence
from concurrent.futures import Future
from contextlib import contextmanager
from dataclasses import asdict, dataclass, field
from math import floor, hypot, inf, log10
from pathlib import Path

from heavylift.coordinator.ladder.choosing import chosen
from heavylift.coordinator.ladder.figures import AskedFigure
from heavylift.coordinator.ladder.looking import tighter
from heavylift.coordinator.ladder.measuring import Errors
from heavylift.coordinator.ladder.model_levels import Ladder, ModelLevel
from heavylift.coordinator.ladder.run_pool import Ran, Start, result, starting
from heavylift.coordinator.participants.configuration import OPERATOR
from heavylift.coordinator.supervision.pool import cores
from heavylift.kernel.errors import HeavyliftError, ModelError, RecordingError
from heavylift.nodes.plan.fidelity import Asked
from heavylift.nodes.scene import LoadedScene
from heavylift.nodes.scene.inputs import UncertainInput, uncertain_inputs, unstated
from heavylift.recordings import Recording
from heavylift.recordings.read.export import amended
from heavylift.recordings.render.curves import larger

from .sensitivities import STEPS, Moved, Sensitivities, effects, moved, of_unstated

ROUNDING = 1e-9  # of a figure: what is left of a bar that is nothing


@dataclass(frozen=True)
class FigureErrors:
    """A result figure with the half-widths of its error estimates in the unit of the figure; None for an estimate that
    is missing."""

    name: str
    quantity: Asked
    unit: str
    value: float
    numerical: float | None
    model: float | None
    inputs: float | None

    @property
    def whole(self) -> float:
        """Total half-width: the root of the sum of squares of all error estimates."""
        return hypot(*(x for x in (self.numerical, self.model, self.inputs) if x is not None))

    def message(self, inputs: str) -> str:
        """Return the figure with its error estimates as text; `inputs`: names of the uncertain inputs."""
        factor, unit = larger(self.unit)
        places = 1 - floor(log10(factor * self.whole)) if self.whole > 0.0 else 6
        halves = {"numerical": self.numerical, "model": self.model, f"inputs: {inputs}": self.inputs}
        parts = [f"+- {factor * half:.2g} ({what})" for what, half in halves.items() if half is not None]
        if parts:
            parts[-1] = parts[-1].replace(" (", f" {unit} (", 1)
        lacks = [what.partition(":")[0] for what, half in halves.items() if half is None]
        message = " ".join([f"{factor * self.value:.{max(0, places)}f}", *(parts or [unit])]).replace("  ", " ")
        return f"{self.name}: {message}" + f", no error estimate ({', '.join(lacks)})" * bool(lacks)


@dataclass(frozen=True)
class Certificate:
    """Error estimates of all figures of a run, the reasons for missing estimates, inputs with and without stated
    uncertainty, and the CPU time [s]."""

    bars: list[FigureErrors]
    missing: dict[str, str]
    inputs: list[UncertainInput]
    unstated: list[str]
    cpu_s: float
    notes: list[str] = field(default_factory=list)

    @property
    def message(self) -> list[str]:
        """The certificate as text, with one line per figure or note."""
        inputs = ", ".join(x.spread for x in self.inputs)
        most = max((bar for bar in self.bars if bar.quantity == "limits"), key=lambda bar: bar.value, default=None)
        lines = [bar.message(inputs) for bar in self.bars if bar.quantity != "limits" or bar is most]
        lines += [f"no error estimate ({part}): {why}" for part, why in self.missing.items()]
        lines += [of_unstated(self.unstated)] if self.unstated else []
        return lines + self.notes

    def data(self) -> dict[str, object]:
        """Return the certificate as plain data in SI units, with half-widths of 95 % intervals."""
        return {
            "bars": [asdict(bar) | {"whole": bar.whole} for bar in self.bars],
            "missing": self.missing,
            "inputs": [{"name": x.name, "value": x.value, "kind": x.kind, "sd": x.sd} for x in self.inputs],
            "unstated": self.unstated, "cpu_s": self.cpu_s, "told": self.message,
        }  # fmt: skip


@contextmanager
def certifying(scene: LoadedScene, given: Sequence[str] = (), at_once: int | None = None) -> "Iterator[Certifying]":
    """Prepare the additional runs that estimate the errors of a run's figures, `at_once` in parallel.

    `given`: uncertainties in addition to those of the scene. Raises HeavyliftError.
    """
    scene, inputs = chosen(scene), uncertain_inputs(scene, given)
    with starting(max(1, cores() - 1) if at_once is None else at_once) as start:
        yield Certifying(scene, inputs, start)


class Certifying:
    """The additional runs of a scene that estimate the errors of a run's figures."""

    def __init__(self, scene: LoadedScene, inputs: list[UncertainInput], start: Start) -> None:
        self._scene, self._inputs, self._start = scene, inputs, start
        self._begun: tuple[Future[Ran], list[Moved]] | None = None

    @property
    def price(self) -> str:
        """A sentence that announces how many additional runs will be made."""
        candidate, ladder = ModelLevel(self._scene.plan), Ladder(self._scene.plan)
        other = next(iter(ladder.witnesses(candidate.plan.fidelity)), ladder.poorer)
        n = 2 * sum(x.sd > 0.0 for x in self._inputs)
        runs = [f"{1 + len(tighter(candidate))} for the steps"]
        if other:
            own = 1 + (ladder.in_own_steps(candidate) != candidate)
            runs.append(f"{own} for the model, {'one ' * (own > 1)}with {candidate.on(other).level}")
        runs += [f"{n} for {len(self._inputs)} uncertain input{'s' * (len(self._inputs) > 1)}"] if n else []
        return f"certifying beside the run, by runs of their own: {', '.join(runs)}; new equations are compiled first"

    def begin(self) -> None:
        """Start all additional runs."""
        own = self._start(self._scene.plan, measured=True)
        self._begun = own, [moved(self._scene, one, STEPS, self._start) for one in self._inputs]

    def written(self, path: Path) -> Certificate:
        """Wait for all additional runs and write the certificate into the recording."""
        try:
            if Recording(path).events(OPERATOR):
                raise RecordingError(
                    "an operator gave orders, which the additional runs cannot repeat; "
                    "run without orders to obtain a certificate"
                )
            found = self.certificate()
            amended(path, {"certified": found.data()})
        except HeavyliftError as error:
            raise type(error)(f"{path}: the recording is complete but has no certificate: {error}") from None
        return found

    def certificate(self) -> Certificate:
        """Wait for all additional runs and return the certificate."""
        if self._begun is None:
            self.begin()
        assert self._begun is not None
        own = result(self._begun[0])
        if isinstance(own, str):
            raise ModelError(own)
        figures, missing = own.figures, {**own.missing}
        found = effects(self._scene, self._begun[1], figures, self._start) if self._inputs else None
        if found is None:
            missing["inputs"] = "no uncertainty is stated; write one behind a value, such as 'mass: 480 t +- 3 %'"
        bars = [
            FigureErrors(
                f.name, f.quantity, f.unit, f.value, _half(own.steps, f), _half(own.model, f), _input_error(found, f)
            )
            for f in figures
        ]
        exact, notes = (found.unstated, found.notes) if found else (unstated(self._scene, []), [])
        return Certificate(bars, missing, self._inputs, exact, own.cpu_s + (found.cpu_s if found else 0.0), notes)


def _half(errors: Errors, figure: AskedFigure) -> float | None:
    """Return the half-width of a figure's error estimate; None if a run does not show this figure."""
    if (error := errors.get(figure.name, inf)) == inf:
        return None
    return error * figure.scale + figure.misread + ROUNDING * abs(figure.scale)


def _input_error(found: Sensitivities | None, figure: AskedFigure) -> float | None:
    """Return the error of a figure due to all inputs together; None if the runs of every input failed."""
    return found.bar(figure.name) if found and len(found.failed) < len(found.inputs) else None
