"""Possible accelerations of an action list: speeds of orders, ramps, moves that begin before the previous ones have
ended.

A step goes from the present value (0) to the boldest that can be tried (1); its texts are those of the scene language,
at paths of the scene's data. Waits are kept, as people need them.

Also replacing values in a scene's text, which is otherwise unchanged.

Also comparing two timings of a lift: duration of each stage, and what limits it.
"""

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Literal

from heavylift.coordinator.record.in_memory import Played
from heavylift.kernel.errors import SceneError
from heavylift.nodes.models.commander.conditions import terms
from heavylift.nodes.models.parts.messages import Done
from heavylift.nodes.plan.actions import Action, LandedCondition, LiftedCondition, Move, SlingsCondition, Turn, Wait
from heavylift.nodes.plan.plan import driven
from heavylift.nodes.plan.verbs import VERBS
from heavylift.nodes.scene import LoadedScene
from heavylift.nodes.scene.text.source import Mark, Path, SourceText, ordered, read
from heavylift.nodes.scene.text.spelling import NUMBER
from heavylift.recordings.sheets.sheet import Cell, Table, columns, table_text

CREEP = 0.1  # of the loaded hoisting speed, with which loads are lifted off and set down unless they are ordered faster
TURNS = 4.0  # times the rate that is written: a turn has no limit of its own, but that of what follows it
SPARE_s, LEAST_s = 2.0, 5.0  # by which a move begins and ends after the one that it overlaps; overlap worth it
SPEED = re.compile(rf"^(\s*\w+\s+)({NUMBER})")
RAMP = re.compile(r"\s+ramp\s.+?(?=\s(?:by|to|until)\s)")
BEHIND_SPEED = re.compile(r"(?=\s(?:by|to|until)\s)")


@dataclass(frozen=True)
class TimingStep:
    """A possible change that shortens an action, by a higher speed, another ramp, or an overlap with the previous
    action.

    `now`, `most`: present and largest value at `paths` of the scene; actions are numbered from 0. Speeds of an action
    are scaled by a common factor; a ramp is written as `words`; for an overlap `now` and `most` are times [s]. `why`:
    what limits `most`; "" if only a trial can show it.
    """

    kind: Literal["speed", "ramp", "overlap"]
    action: int
    paths: tuple[Path, ...]
    now: float
    most: float
    words: str = ""
    why: str = ""

    @property
    def halved(self) -> bool:
        """Whether a fraction of the change may be tried if the whole change makes the verdict red."""
        return self.kind == "overlap" or not self.why

    def value(self, part: float) -> float:
        """Return the speed factor, or the overlap time [s], if only the fraction `part` of this timing change is
        applied."""
        return self.most if part >= 1.0 else self.now + (self.most - self.now) * part

    def text(self, before: str, part: float) -> str:
        """Return the text of a value with the fraction `part` of this change applied; `before`: its present text."""
        x = self.value(part)
        if self.kind == "overlap":
            return f"after {x:.1f} s"
        if self.kind == "ramp":
            return BEHIND_SPEED.sub(f" ramp {self.words}", RAMP.sub("", before), count=1) if part else before
        return SPEED.sub(lambda m: f"{m[1]}{float(m[2]) * x:.4g}", before, count=1)


def speeds(scene: LoadedScene) -> Iterator[TimingStep]:
    """Yield, for each action, changes that raise the speeds of its orders up to those of the drives, the largest change
    first."""
    actuators = {a.name: a for machine in scene.plan.machines for a in machine.actuators}
    for i, action in enumerate(scene.scene.actions):
        moves = [o for o in scene.plan.actions[i].orders if isinstance(o, Move) and actuators[o.actuator].speed]
        moves = [o for o in moves if VERBS[o.verb].units == "sliding"]
        paths = tuple(("actions", i, target) for target, phrase in action.orders.items() if phrase.speed > 0.0)
        if any(isinstance(o, Turn) for o in scene.plan.actions[i].orders):
            yield TimingStep("speed", i, paths, 1.0, TURNS)
        elif len(moves) == len(scene.plan.actions[i].orders):
            creeps = _creeps(scene, i, moves)
            for loaded in (True,) if creeps else (False, True):
                own = {m: actuators[m.actuator] for m in moves}
                limits = {m: (loaded and x.loaded) or x.speed or 0.0 for m, x in own.items()}
                limits |= {m: CREEP * limits[m] for m in moves if creeps and VERBS[m.verb].sign}
                first = min(moves, key=lambda m: limits[m] / abs(m.speed))
                factor = float(f"{limits[first] / abs(first.speed):.9g}")
                load = " with a load" if loaded and VERBS[first.verb].sign else ""
                load = " at lift-off and landing, assumed" if creeps else load
                if factor > 1.0:
                    message = f"{driven(first.actuator)} can {limits[first] * 60.0:g} m/min{load}"
                    yield TimingStep("speed", i, paths, 1.0, factor, why=message)


def _creeps(scene: LoadedScene, number: int, moves: Sequence[Move]) -> bool:
    """Return whether loads are lifted off or set down in an action, by its conditions or on the equilibrium path."""
    meets = any(
        isinstance(t, SlingsCondition | LiftedCondition | LandedCondition) for m in moves for t in terms(m.until)
    )
    slings = [tie.rope for machine in scene.plan.machines for tie in machine.ties]
    stands = (x.tensions for x in scene.statics.states if x.action == number + 1 and x.grounded)
    carries = meets or any(tensions.get(sling, 0.0) > 0.0 for tensions in stands for sling in slings)
    return carries and any(VERBS[m.verb].sign for m in moves)


def ramps(scene: LoadedScene) -> Iterator[TimingStep]:
    """Yield changes of travel and traverse moves to swing-free ramps: with two acceleration pulses, or one swing period
    long."""
    for i, action in enumerate(scene.scene.actions):
        along = [(t, p) for t, p in action.orders.items() if VERBS[p.verb].along]
        moves = [o for o in scene.plan.actions[i].orders if isinstance(o, Move) and VERBS[o.verb].along]
        paths = tuple(("actions", i, target) for target, _ in along)
        own = [
            a.accel for machine in scene.plan.machines for a in machine.actuators for m in moves if a.name == m.actuator
        ]
        for words in (f"{min(own):g} m/s2 in two pulses", "one swing") if own else ():
            yield TimingStep("ramp", i, paths, 0.0, 1.0, words, "the swing of what hangs there")


def overlaps(scene: LoadedScene, lasts: Sequence[float]) -> Iterator[TimingStep]:
    """Yield changes that let an action begin while the previous action still moves; `lasts`: duration of each action
    [s].

    Only moves without conditions are overlapped, each actuator moving once, and an action still ends after the previous
    one.
    """
    listed = scene.plan.actions
    for i in range(1, min(len(listed), len(lasts))):
        before, here = listed[i - 1].orders, listed[i].orders
        moves = [o for o in (*before, *here) if isinstance(o, Move) and o.until is None]
        alone = len({o.actuator for o in moves}) == len(moves) == len(before) + len(here)
        soonest = max(SPARE_s, lasts[i - 1] - lasts[i] + SPARE_s)
        if alone and here and before and not listed[i].when and lasts[i - 1] - soonest > LEAST_s:
            message = f"'{listed[i - 1].stage or f'action {i}'}' has to begin and to end first"
            yield TimingStep("overlap", i, (("actions", i, "when"),), lasts[i - 1], soonest, why=message)


def rewritten(text: str, name: str, changes: Mapping[Path, str]) -> str:
    """Return the text of a scene with new values at paths; a key that is missing is added as the first of its mapping.

    A comment after a value keeps its column as long as there is room. Raises SceneError if a value cannot be replaced
    alone: a value of several lines, an alias, or a value in another file.
    """
    source, lines = read(text, name), text.splitlines(keepends=True)
    at = {path: _mark(source, path) for path in changes}
    for path in sorted(changes, key=lambda path: (at[path].line, at[path].column), reverse=True):  # the last one first
        line, column, value = at[path].line - 1, at[path].column - 1, changes[path]
        before, after = lines[line][:column], lines[line][column:]
        if path in source.values:
            lines[line] = before + _replaced(after, str(source.at(path)), value)
        elif before.strip(" -"):  # in braces, or the only key of its line
            lines[line] = f"{before}{path[-1]}: {value}, {after}"
        else:
            lines[line] = f"{before}{path[-1]}: {value}\n{' ' * column}{after}"
    found = "".join(lines)
    for path, value in changes.items():
        inside = source.at(path[:-1])
        if isinstance(inside, dict) and isinstance(path[-1], str):
            inside[path[-1]] = value
    if ordered(read(found, name).data) != ordered(source.data):
        raise SceneError(
            f"{name}: cannot be changed without losing its comments; write each order on a line of its own"
        )
    return found


def _mark(source: SourceText, path: Path) -> Mark:
    """Return the place of a value, or of the key before which a new one is inserted."""
    if path in source.values:
        return source.values[path]
    inside = source.at(path[:-1])
    keys = [source.keys[(*path[:-1], key)] for key in inside] if isinstance(inside, dict) else []
    own = [mark for mark in keys[1:2] if mark.line > keys[0].line]
    return (own or keys or [source.mark(path)])[0]


def _replaced(text: str, old: str, new: str) -> str:
    """Return the rest of a line with the value at its beginning replaced."""
    if not text.startswith(old):
        return text
    rest = text[len(old) :]
    blanks = len(rest) - len(rest.lstrip(" "))
    if rest[blanks : blanks + 1] == "#":
        rest = " " * max(1, blanks + len(old) - len(new)) + rest[blanks:]
    return new + rest


HEADS = columns("stage", "before [h:min:s] .0", "after [h:min:s] .0", "what limits it")
Parts = dict[TimingStep, float]  # how far each step is taken, of 1


@dataclass(frozen=True)
class FoundTiming:
    """Result of a search for the shortest timing: scene and run before and after, with the changes applied."""

    before: LoadedScene
    run_before: Played | None
    after: LoadedScene | None = None
    run_after: Played | None = None
    parts: Parts = field(default_factory=dict)
    why: Mapping[TimingStep, str] = field(default_factory=dict)  # what limits each change
    wrong: str = ""  # why no timing was found

    @property
    def gain(self) -> float:
        """Time saved until the end of the last move [s]."""
        if self.run_before is None or self.run_after is None:
            return 0.0
        return done(self.run_before) - done(self.run_after)

    @property
    def message(self) -> list[str]:
        """The stages before and after as a table, and the verdict, as text for people."""
        assert self.run_before is not None
        assert self.run_after is not None
        ends = [done(run) for run in (self.run_before, self.run_after)]
        rows: list[tuple[Cell, ...]] = [*self.rows, ("all moves are done", *ends, f"{self.gain / ends[0]:.0%} sooner")]
        return [table_text(Table("Timing", HEADS, tuple(rows))), self.run_after.verdict.line]

    def data(self) -> dict[str, object]:
        """Return the timing as plain data in SI units."""
        assert self.run_before is not None
        assert self.run_after is not None
        keys = ("stage", "before", "after", "why")
        return {
            "before": done(self.run_before),
            "after": done(self.run_after),
            "stages": [dict(zip(keys, row, strict=True)) for row in self.rows],
            "verdict": self.run_after.verdict.line,
            "digest": self.run_after.digest,
        }

    @property
    def rows(self) -> Iterator[tuple[str, float, float, str]]:
        """Name of each stage, its duration before and after [s], and what limits it."""
        assert self.run_before is not None
        assert self.run_after is not None
        after = {number: lasts for number, _, lasts in _stages(self.run_after)}
        for number, name, lasts in _stages(self.run_before):
            reasons = [x for step, x in self.why.items() if step.action == number]
            yield name, lasts, after.get(number, 0.0), "; ".join(dict.fromkeys(reasons))


def last_wait(actions: Sequence[Action]) -> int:
    """Return the index of the first of the waits that end an action list; without such waits, the number of actions."""
    n = len(actions)
    while n and all(isinstance(order, Wait) for order in actions[n - 1].orders):
        n -= 1
    return n


def _stages(run: Played) -> Iterator[tuple[int, str, float]]:
    """Yield the action number, name and duration [s] of each stage."""
    ends = [t for t, _, _ in run.conduct.stages[1:]] + [run.end_ns * 1e-9]
    for (t, number, name), end in zip(run.conduct.stages, ends, strict=True):
        yield number, name, end - t


def done(run: Played) -> float:
    """Return the time [s] at which the last move of a run ends."""
    return max((e.t for e in run.events if isinstance(e.value, Done)), default=0) * 1e-9
