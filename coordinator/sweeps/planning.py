"""Search for the shortest timing of a lift within its limits: steps of `timing`, as far as the verdict stays green.

First along the equilibrium path, which costs little: each step by itself, as far as the checks of the scene and the
static limits allow. Then in runs: all steps at once; if a run turns red, the steps of that stage, or of the nearest one
before it, are halved until a run is green; then half of what was lost is tried again. Only steps that save time are
taken.
"""

import logging
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import groupby, pairwise

from heavylift.coordinator.ladder.choosing import answered, chosen
from heavylift.coordinator.record.in_memory import CUT, Played, play
from heavylift.kernel.description.findings import clock
from heavylift.kernel.errors import HeavyliftError, SceneError
from heavylift.nodes.scene import LoadedScene
from heavylift.nodes.scene.keys.validate import override
from heavylift.nodes.scene.loading import parse
from heavylift.nodes.scene.text.source import Data, Path, SourceText, read

from .timing import FoundTiming, Parts, TimingStep, done, last_wait, overlaps, ramps, rewritten, speeds
from .variant import first_sentence

LOG = logging.getLogger("heavylift.sweeps")
WORTH_s = 0.5  # of a gain that counts
HALVINGS = 5  # of a step that the path at rest does not allow whole
LEAST = 0.2  # part of a step below which it is given up in runs


def planned(scene: LoadedScene, budget: float, say: Callable[[str], None] = LOG.info) -> FoundTiming:
    """Find the shortest timing of a scene within `budget` [s] of wall time; raises SceneError if the scene cannot be
    planned."""
    scene = chosen(scene, say)
    search = _Search(scene, time.monotonic() + budget, say)
    try:
        first = search.run(scene, "as it is written")
    except HeavyliftError as error:
        return FoundTiming(scene, None, wrong=f"the scene as it is written cannot be run: {error}")
    if first.verdict.red:
        return FoundTiming(scene, first, wrong=f"red at the start, {first.verdict.line}: correct that first")
    if why := search.at_rest():
        return FoundTiming(scene, first, wrong=f"the scene as it is written has no equilibrium path: {why}")
    if first.verdict.state == "undecided":  # no step can be blamed for that
        search.bad = ("red",)
    found = search.in_runs(first)
    if found is None:
        message = "its budget is used up" if search.spent else "it is as quick as its limits and drives allow"
        return FoundTiming(scene, first, wrong=f"no quicker timing was found that is green: {message}")
    return FoundTiming(scene, first, *found, parts=dict(search.parts), why=dict(search.why))


@dataclass(frozen=True)
class _Outlook:
    """Static check of a variant: scene, begin of its actions and end of all moves [s]; `why` it is refused."""

    scene: LoadedScene | None = None
    begins: tuple[float, ...] = ()
    done: float = 0.0
    why: str = ""


class _Search:
    """Search for the shortest timing; `parts`: fraction to which each step is taken; `why`: the reason that limits each
    step."""

    def __init__(self, scene: LoadedScene, until: float, say: Callable[[str], None]) -> None:
        self.scene, self.until, self.say = scene, until, say
        self.text = _own_text(scene)
        self.parts, self.why = Parts(), dict[TimingStep, str]()
        self.bad: tuple[str, ...] = ("red", "undecided")  # states of a verdict that end a step

    @property
    def spent(self) -> bool:
        return time.monotonic() >= self.until

    # ---- along the path at rest -----------------------------------------------------------------------------

    def at_rest(self) -> str:
        """Shorten each stage as far as the static checks allow; return why the unchanged scene fails them, or ""."""
        self.best = self.outlook(self.parts)
        if self.best.why:
            return self.best.why
        for _, alternatives in groupby(speeds(self.scene), lambda step: step.action):
            self._take(list(alternatives))
        for _, alternatives in groupby(ramps(self.scene), lambda step: step.action):
            self._take(list(alternatives), best=True)
        for i in range(1, len(self.scene.plan.actions)):
            lasts = [b - a for a, b in pairwise((*self.best.begins, self.best.done))]
            self._take([step for step in overlaps(self.scene, lasts) if step.action == i])
        return ""

    def _take(self, alternatives: Sequence[TimingStep], best: bool = False) -> None:
        """Of an action's alternative steps, take the first that saves time, or if `best` the one that saves most; a
        step that the checks do not allow in full is taken in part."""
        others = {x: part for x, part in self.parts.items() if x not in alternatives}
        for step in alternatives:
            if self.spent:
                return
            part, found, why = self._taken(step, others)
            if part and found.done < self.best.done - WORTH_s:
                self.best, self.parts = found, {**others, step: part}
                self.why = {x: message for x, message in self.why.items() if x not in alternatives} | {step: why}
                self.say(f"at rest: {_named(self.scene, step)}: {clock(found.done)} until all moves are done")
                if not best:
                    return
            elif not part and not best:
                self.why[step] = why

    def _taken(self, step: TimingStep, others: Parts) -> tuple[float, _Outlook, str]:
        """Return the largest allowed fraction of a step together with others, its static check, and the reason for the
        limit."""
        found = self.outlook({**others, step: 1.0})
        if not found.why:
            return 1.0, found, step.why
        low, high, green, why = 0.0, 1.0, found, found.why
        for _ in range(HALVINGS if step.halved else 0):
            middle = 0.5 * (low + high)
            found = self.outlook({**others, step: middle})
            if found.why:
                high, why = middle, found.why
            else:
                low, green = middle, found
        return low, green, why

    def outlook(self, parts: Mapping[TimingStep, float]) -> _Outlook:
        """Check the equilibrium path of the scene with each timing change applied to its given fraction."""
        try:
            scene = self.variant(parts)
        except HeavyliftError as error:
            return _Outlook(why=first_sentence(str(error)))
        red = next((x.sentence for x in scene.findings if x.state == "red"), "")
        if red or not scene.statics.known:
            return _Outlook(why=red or scene.statics.why)
        begins = tuple(x.t for x in scene.statics.acted)
        last = last_wait(scene.plan.actions)
        return _Outlook(scene, begins, begins[last] if last < len(begins) else scene.statics.states[-1].t)

    def variant(self, parts: Mapping[TimingStep, float]) -> LoadedScene:
        """Return the scene at the present model level with timing changes, of each the fraction (0 to 1) in `parts`."""
        found, answer = parse(self.written(parts), str(self.scene.path), passing=True), self.scene.answer
        return answered(found, answer) if answer else found

    def written(self, parts: Mapping[TimingStep, float]) -> str:
        """Return the text of the scene with timing changes, of each the fraction (0 to 1) in `parts`."""
        source, texts = read(self.text, str(self.scene.path)), dict[Path, str]()
        for step, part in parts.items():
            for path in step.paths if part else ():
                texts[path] = step.text(texts.get(path, str(source.at(path))), part)
        return rewritten(self.text, str(self.scene.path), texts)

    # ---- in runs --------------------------------------------------------------------------------------------

    def run(self, scene: LoadedScene, message: str) -> Played:
        """Simulate a variant of the scene within the wall time that is left, and report its result."""
        began = time.monotonic()
        found = play(scene.plan, max(0.0, self.until - began), errors=scene.errors)
        self.say(
            f"run {message}: {clock(done(found))}, {found.verdict.line} ({time.monotonic() - began:.0f} s of wall time)"
        )
        return found

    def in_runs(self, first: Played) -> tuple[LoadedScene, Played] | None:
        """Return the quickest timing whose simulated run is green, with this run; None if there is none.

        The search starts from the timing found by statics and reverts part of the changes of stages that turn red.
        """
        lost = Parts()
        while self.parts and not self.spent:
            found = self._green(lost)
            if found is None:
                continue
            if done(found[1]) > done(first) - WORTH_s:
                return None
            return self._regained(found, lost)
        return None

    def _green(self, lost: Parts) -> tuple[LoadedScene, Played] | None:
        """Run the present variant and return it; if not green, reduce steps, note them in `lost`, return None."""
        try:
            scene = self.variant(self.parts)
            run = self.run(scene, f"with {len(self.parts)} steps")
        except HeavyliftError as error:
            if CUT not in str(error):
                self.say(f"no run: {first_sentence(str(error))}")
                self._back({step: first_sentence(str(error)) for step in _latest(self.parts)}, lost)
            return None
        if run.verdict.state not in self.bad:
            return scene, run
        stages = {name: number for _, number, name in run.conduct.stages}
        guilty = dict[TimingStep, str]()
        for f in (check for check in run.verdict.checks if check.state in self.bad):
            here = stages.get(f.stage, len(self.scene.plan.actions))
            near = max((step.action for step in self.parts if step.action <= here), default=None)
            guilty |= {step: f.sentence for step in self.parts if near is None or step.action == near}
        self._back(guilty, lost)
        return None

    def _back(self, guilty: Mapping[TimingStep, str], lost: Parts) -> None:
        for step, message in guilty.items():
            lost[step] = part = self.parts.pop(step)
            self.why[step] = message
            if step.kind != "ramp" and part / 2.0 >= LEAST:
                self.parts[step] = part / 2.0

    def _regained(self, found: tuple[LoadedScene, Played], lost: Parts) -> tuple[LoadedScene, Played]:
        """Try half of each reduction again, and return the better variant."""
        parts = dict(self.parts)
        self.parts |= {step: 0.5 * (parts.get(step, 0.0) + part) for step, part in lost.items() if step.kind != "ramp"}
        if lost and not self.spent:
            again = self._green(Parts())
            if again is not None and done(again[1]) < done(found[1]) - WORTH_s:
                return again
        self.parts = parts
        return found


def _own_text(scene: LoadedScene) -> str:
    """Return the scene file's text with its settings applied; raises SceneError for one without a line."""
    name, text = str(scene.path), scene.text
    if "actions" not in read(text, name).data:
        raise SceneError(f"{name}: has no action list of its own; plan the scene that it extends")
    for setting in scene.settings:
        source = read(text, name)
        override(source, setting)
        changes = dict(_changed(read(text, name), source.data, ()))
        try:
            text = rewritten(text, name, changes)
        except SceneError:
            raise SceneError(f"--set '{setting}': {name} has no line for this value; write one first") from None
    return text


def _changed(source: SourceText, data: Data, path: Path) -> Iterator[tuple[Path, str]]:
    """Yield the paths and texts of values that differ from those of a source."""
    if isinstance(data, dict | list) and isinstance(source.at(path), type(data)):
        for key, value in data.items() if isinstance(data, dict) else enumerate(data):
            yield from _changed(source, value, (*path, key))
    elif data != source.at(path):
        yield path, str(data)


def _latest(parts: Parts) -> list[TimingStep]:
    """Return the steps that may have caused an error: the overlaps, or else all steps."""
    return [step for step in parts if step.kind == "overlap"] or list(parts)


def _named(scene: LoadedScene, step: TimingStep) -> str:
    action = scene.plan.actions[step.action]
    return f"{step.kind} of '{action.stage or f'action {step.action + 1}'}'"
