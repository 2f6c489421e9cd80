"""How sure the figures of a run are: `2651 +- 4 (numerical) +- 9 (model) +- 80 kN (inputs: ...)`, at a level of 95 %.

After ASME V&V 20-2009, whose u_num and u_input these are; what the rung leaves out stands beside them.

numerical   TWICE the difference to the same rung by DOP853 at 1e-10: a method of high order that damps nothing, so that
            it judges fixed steps and methods that damp (SDIRK) as well, of which no Richardson extrapolation holds.
            Rigid ropes: two such runs, at 1e-9 and 1e-10, must agree, else there is no bar: impacts can fork.
model       TWICE the difference of that to the next richer spatial rung: two lumps a rope, elastic slings and girder,
            nothing locked; of a rung with lumps, twice as many.  REST: what two lumps leave out, measured on random
            lifts against four.  A mechanism is what its file says: it has no richer rung, and no such bar.
inputs      two runs for each uncertain input, added up as squares (`sensitivities`)
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from concurrent.futures import Future
from contextlib import contextmanager
from dataclasses import asdict, dataclass, field
from math import floor, hypot, log10
from pathlib import Path

import msgspec
from heavylift.coordinator.participants.configuration import OPERATOR
from heavylift.coordinator.supervision.pool import cores
from heavylift.coordinator.tradeoff.measuring import unit_of
from heavylift.kernel.errors import HeavyliftError, RecordingError
from heavylift.nodes.fidelity.case import case_of
from heavylift.nodes.fidelity.cost import cost
from heavylift.nodes.fidelity.method import METHODS
from heavylift.nodes.plan.fidelity import Asked
from heavylift.nodes.plan.plan import Fidelity, Plan
from heavylift.nodes.scene import LoadedScene
from heavylift.nodes.scene.inputs import UncertainInput, uncertain_inputs, unstated
from heavylift.recordings import Recording
from heavylift.recordings.read.extended import amended
from heavylift.recordings.render.curves import larger

from .figures import Figure, figures, recorded
from .running import Played, Start, result, starting
from .sensitivities import STEPS, Moved, Sensitivities, effects, moved, of_unstated

TWICE = 2.0
TIGHT, SECOND = 1e-10, 1e-9  # tolerances; the second of rigid ropes
RICH = 1e-7  # tolerance of the richer rung, whose steps are short for its own sake
FINEST = 1e-12  # tolerance of a step
AGREE = 1e-3  # of a figure: what two tight runs may differ by
REST: dict[Asked, float] = {"rope tension": 5e-5, "swing": 1e-4, "position": 5e-5, "lift-off time": 1e-5}
STEADY = 1e-7  # of a figure: what is rounded away in a recording
SECONDS, LEAST = 5e-8, 0.1  # of an evaluation, for each state, with samples and messages; of any run [s]


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
        told = " ".join([f"{factor * self.value:.{max(0, places)}f}", *(parts or [unit])])
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
        lines = [bar.told(inputs) for bar in self.bars]
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
    """The same rung with steps that count as exact, the last one most; none where the run has such steps itself."""
    finest = min(TIGHT, 1e-2 * plan.tolerance if plan.step is None else TIGHT)
    if finest < FINEST:
        return []
    rigid = plan.fidelity.ropes == "rigid" and plan.lift
    rigid = rigid or any(system.rigid_ropes for system in (m.system for m in plan.mechanisms))
    tolerances = (finest * SECOND / TIGHT, finest) if rigid else (finest,)
    return [_stepped(plan, plan.fidelity, tolerance) for tolerance in tolerances]


def richer(plan: Plan) -> Plan | None:
    """The next richer spatial rung; None of a mechanism and of machines made of parts."""
    if not plan.lift:
        return None
    at = plan.fidelity
    lumps = 2 * at.lumps if at.ropes == "massive" else 2
    rung = Fidelity(ropes="massive", lumps=lumps, rope_mass="lumped", girder="elastic", islands=at.islands)
    return _stepped(plan, rung, RICH, "dopri5")


@contextmanager
def certifying(scene: LoadedScene, given: Sequence[str] = (), at_once: int | None = None) -> Iterator[Certifying]:
    """Runs beside a run that is to be certified, `at_once` in processes of their own (default: all cores but one).

    `given`: uncertainties besides those that the scene states.  Raises HeavyliftError.
    """
    inputs = uncertain_inputs(scene, given)
    with starting(max(1, cores() - 1) if at_once is None else at_once) as start:
        yield Certifying(scene, inputs, start)


class Certifying:
    """Runs that have begun; `price` tells what they cost, `certificate` waits for them."""

    def __init__(self, scene: LoadedScene, inputs: list[UncertainInput], start: Start) -> None:
        self._scene, self._inputs, self._start, self._unit = scene, inputs, start, unit_of(scene)
        self._rich, self._tight = richer(scene.plan), tighter(scene.plan)
        self._begun: tuple[list[Future[Played]], Future[Played] | None, list[Moved]] | None = None

    @property
    def price(self) -> str:
        """What the certificate costs, in a sentence."""
        plan, n = self._scene.plan, 2 * sum(x.sd > 0.0 for x in self._inputs)
        case = case_of(plan, self._scene.followed) if plan.block and self._scene.followed else None

        def seconds(one: Plan) -> float | None:
            if case is None or one.method not in METHODS:
                return None
            at = one.fidelity
            spent = METHODS[one.method](case, at, one.tolerance).cost if at.ropes != "rigid" else cost(case, at)
            return LEAST + spent.product * SECONDS

        runs = [(f"the same rung at {self._tight[-1].tolerance:.0e}", self._tight)] if self._tight else []
        runs += (
            [(f"the next richer rung, {self._rich.fidelity.lumps} lumps a rope", [self._rich])] if self._rich else []
        )
        runs += (
            [(f"{n} runs for {len(self._inputs)} uncertain input{'s' * (len(self._inputs) > 1)}", [plan] * n)]
            if n
            else []
        )
        times = [[seconds(one) for one in plans] for _, plans in runs]
        parts = []
        for (what, _), each in zip(runs, times, strict=True):
            known = [x for x in each if x is not None]
            parts.append(f"{what} (about {sum(known):.2g} s)" if len(known) == len(each) else what)
        known = [x for each in times for x in each if x is not None]
        complete = len(known) == sum(map(len, times))
        own = "" if complete else "; what is not predicted takes about as long as the run itself, each"
        return f"certifying beside the run: {', '.join(parts)}{own}; equations that are new are compiled first"

    def begin(self) -> None:
        """Start all runs."""
        tight = [self._start(plan, self._unit) for plan in self._tight]
        rich = self._start(self._rich, self._unit) if self._rich else None
        self._begun = tight, rich, [moved(self._scene, one, STEPS, self._start) for one in self._inputs]

    def written(self, path: Path) -> Certificate:
        """The certificate of the recorded run, once all others have ended; the recording then has it, too."""
        rec = Recording(path)
        try:
            if rec.events(OPERATOR):
                raise RecordingError("an operator gave orders, which the runs beside it have not had; run without them")
            found = self.certificate(figures(recorded(self._scene.plan, rec), self._unit))
            amended(path, {"certified": found.data()})
        except HeavyliftError as error:
            raise type(error)(f"{path}: is whole, but has no certificate: {error}") from None
        return found

    def certificate(self, own: list[Figure]) -> Certificate:
        """The certificate of a run with these figures."""
        if self._begun is None:
            self.begin()
        assert self._begun is not None
        tight = [result(run) for run in self._begun[0]]
        rich = result(self._begun[1]) if self._begun[1] else None
        missing: dict[str, str] = {}
        steps, ends = self._numerical(own, tight, missing)
        model = self._model(own, ends, rich, missing)
        found = effects(self._scene, self._begun[2], own, self._start) if self._inputs else None
        if found is None:
            missing["inputs"] = "no uncertainty is stated; write one behind a value, such as 'mass: 480 t +- 3 %'"
        bars = [
            Bar(f.name, f.quantity, f.unit, f.value, steps[f.name], model[f.name], _input_bar(found, f)) for f in own
        ]
        spent = sum(run[1] for run in (*tight, rich) if isinstance(run, tuple)) + (found.cpu_s if found else 0.0)
        exact = found.unstated if found else unstated(self._scene, [])
        return Certificate(bars, missing, self._inputs, exact, spent, found.notes if found else [])

    def _numerical(
        self, own: list[Figure], tight: list[Played], missing: dict[str, str]
    ) -> tuple[dict[str, float | None], dict[str, float]]:
        """Half-widths by figure, and the figures with tight steps, or the run's own without."""
        values = [{f.name: f.value for f in run[0]} for run in tight if isinstance(run, tuple)]
        if len(values) < len(tight) or not tight:
            why = next((run for run in tight if isinstance(run, str)), "the run's own steps are as tight")
            missing["numerical"] = why if not tight else f"the same rung with tighter steps does not run: {why}"
            return dict.fromkeys((f.name for f in own), None), {f.name: f.value for f in own}
        halves: dict[str, float | None] = {}
        for f in own:
            exact = [seen[f.name] for seen in values if f.name in seen]
            if len(exact) < len(tight):
                missing["numerical"] = f"with tighter steps there is no {f.name}"
            elif max(exact) - min(exact) > AGREE * abs(f.scale):
                missing["numerical"] = f"two runs with tight steps differ by {max(exact) - min(exact):.2g} in {f.name}"
            else:
                halves[f.name] = TWICE * max(abs(f.value - x) for x in exact) + STEADY * abs(f.scale)
        return {f.name: halves.get(f.name) for f in own}, {f.name: values[-1].get(f.name, f.value) for f in own}

    def _model(
        self, own: list[Figure], ends: dict[str, float], rich: Played | None, missing: dict[str, str]
    ) -> dict[str, float | None]:
        """Half-widths by figure."""
        if not isinstance(rich, tuple):
            missing["model"] = rich or "a mechanism is modelled as it is written, there is no richer rung"
            return dict.fromkeys((f.name for f in own), None)
        seen = {f.name: f.value for f in rich[0]}
        if lost := [f.name for f in own if f.name not in seen]:
            missing["model"] = f"the richer rung shows no {', '.join(lost)}"
        return {
            f.name: TWICE * abs(ends[f.name] - seen[f.name]) + REST[f.quantity] * abs(f.scale)
            if f.name in seen
            else None
            for f in own
        }


def _input_bar(found: Sensitivities | None, figure: Figure) -> float | None:
    """None where nothing is known of any input."""
    return found.bar(figure.name) if found and len(found.failed) < len(found.inputs) else None


def _stepped(plan: Plan, rung: Fidelity, tolerance: float, method: str = "dop853") -> Plan:
    steps = {"method": method, "tolerance": tolerance, "step": None}
    return msgspec.structs.replace(plan, fidelity=rung, **steps)
