"""Findings about the course of a run compared with its action list: hooks at their limit switches, orders that moved
nothing, an end that cuts the lift, an operator's stop, and the kernel's notes on its accuracy."""

from bisect import bisect_right
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from math import inf, sqrt
from typing import Any

from heavylift.kernel.description.findings import Check, finding
from heavylift.nodes.devs import Event
from heavylift.nodes.models.commander.actuator_registry import TURN
from heavylift.nodes.models.commander.conditions import terms
from heavylift.nodes.models.parts.kernel_messages import StateEvent
from heavylift.nodes.models.parts.messages import (
    BrakeState,
    Limit,
    OperatorCommand,
    Overload,
    SetProfile,
    Skipped,
    Stage,
    Tripped,
)  # fmt: skip
from heavylift.nodes.plan.actions import Action, Condition, LandedCondition, Move, Turn
from heavylift.nodes.plan.plan import Plan, driven
from heavylift.recordings import Recording
from heavylift.recordings.read.verdict import recorded_peaks

Meant = Sequence[tuple[frozenset[str], float, float]]  # names of two things that may touch, from when to when [s]
ENDED = 1e-9  # [rad, s] rounding of the angle and the time at which a turn ends
TOUCHES = ("impact", "closed", "open")  # of contacts, and of supports
UPPER = "upper limit"
FINISHED = "finished"


@dataclass
class Conduct:
    """Record of the course of a run: stages, orders that did not begin, end positions reached, overloads,
    interlocks."""

    stages: list[tuple[float, int, str]] = field(default_factory=list)
    skipped: list[tuple[float, int, str]] = field(default_factory=list)
    stopped: list[tuple[float, str, str]] = field(default_factory=list)  # actor, limit
    tripped: list[tuple[float, str, bool]] = field(default_factory=list)  # interlock, whether it was bypassed
    bypassed: list[tuple[float, str]] = field(default_factory=list)  # brake, lock or interlock
    overloads: dict[str, tuple[float, float]] = field(default_factory=dict)  # actor -> tension [N], when [s]
    turns: list[tuple[float, str, float, float, float]] = field(default_factory=list)  # master, speed, accel, angle
    touched: list[tuple[float, str, str]] = field(default_factory=list)  # contact, what the kernel reported of it
    words: list[tuple[float, str, bool]] = field(default_factory=list)  # an operator's, and whether they end the run
    notes: Sequence[tuple[float, str]] = ()
    shortfall: Sequence[str] = ()  # why its errors exceed the accepted ones, or were not measured
    peaks: dict[str, tuple[float, float]] = field(default_factory=dict)
    end: float = 0.0
    unfinished: str = ""
    status: str = FINISHED
    reason: str = ""

    def hear(self, t_ns: int, kind: str, value: dict[str, Any]) -> None:
        """Update the record of the run's course with a recorded event: time [ns], type and fields of its message."""
        t = t_ns * 1e-9
        match kind:
            case Stage.__name__:
                self.stages.append((t, int(value["action"]), str(value["name"])))
            case Skipped.__name__:
                self.skipped.append((t, int(value["action"]), str(value["actor"])))
            case SetProfile.__name__ if value["actuator"].endswith(TURN):
                speed, accel, distance = (float(value[x] or 0.0) for x in ("speed", "accel", "distance"))
                self.turns.append((t, str(value["actuator"]), speed, accel, distance))
            case Limit.__name__:
                self.stopped.append((t, str(value["actor"]), str(value["limit"])))
            case Overload.__name__ if value["over"]:
                self.overloads.setdefault(str(value["actor"]), (float(value["tension"]), t))
            case Tripped.__name__ if value["over"]:
                self.tripped.append((t, str(value["actor"]), bool(value["bypassed"])))
            case BrakeState.__name__ if not value["engaged"]:
                self.bypassed.append((t, str(value["actor"])))
            case StateEvent.__name__ if value["what"] in TOUCHES:
                self.touched.append((t, str(value["name"]), str(value["what"])))
            case OperatorCommand.__name__:
                self.words.append((t, str(value["text"]), not value["action"]))

    def stage_at(self, t: float) -> str:
        """Return the name of the stage at a time [s]."""
        return next((name for start, _, name in reversed(self.stages) if name and start <= t), "")

    def event(self, e: Event) -> None:
        """Update the record of the run's course with an event of a run in progress."""
        if e.type in RECORDED:
            value = e.value
            self.hear(e.t, e.type, {name: getattr(value, name) for name in RECORDED[e.type]})


KINDS = (SetProfile, StateEvent, Stage, Skipped, Limit, Overload, Tripped, BrakeState, OperatorCommand)
RECORDED = {kind.__name__: kind.__struct_fields__ for kind in KINDS}


def conduct_of(rec: Recording) -> Conduct:
    """Read the record of a run's course from its recording."""
    given = {"shortfall": rec.fact("answer", {}).get("notes", ()), "reason": rec.result.get("reason", "")}
    found = Conduct(notes=rec.notes(), status=rec.result.get("status", "cut off"), **given)
    for e in rec.events():
        if e.type in RECORDED and isinstance(e.value, dict):
            found.hear(e.t_ns, e.type, e.value)
        found.end = max(found.end, e.t_ns * 1e-9)
    found.end = rec.fact("sim_s", found.end)
    found.unfinished = str(rec.result.get("unfinished", ""))
    found.peaks = {name: (peak.tension, peak.time) for name, peak in recorded_peaks(rec).items()}
    return found


def conduct_findings(plan: Plan, text: Conduct) -> Iterator[Check]:
    """Yield all findings about the course of a run, in no particular order."""
    lift = any(machine.cargo for machine in plan.machines)
    yield from _stops(plan, text)
    yield from _interlocks(plan, text)
    yield from _at_once(plan, text)
    for t, words, ends in text.words:
        rest = f", which was {text.unfinished}" if text.unfinished else ""
        message = f"an operator stopped the run{rest}" if ends else f"an operator ordered '{words}'"
        yield finding("red" if ends else "none", "operator", "operator", message, t=t)
    if text.status != FINISHED:
        message = "the run did not reach its end" if text.reason else "the recording is cut off"
        yield finding("red", "cut", "run", message, t=text.end)
    elif text.unfinished and not any(ends for _, _, ends in text.words):
        bound = f"the end of the scene at {plan.end:g} s" if plan.end is not None else "its end"
        message = f"{bound} cut the {'lift' if lift else 'run'}: {text.unfinished}"
        yield finding("red" if lift else "none", "cut", "run", message, t=text.end)
    for message in text.shortfall:
        yield finding("amber", "accuracy", "run", message)
    for t, note in text.notes:
        yield finding("amber", "computation", "kernel", note, t=t)


def touching(plan: Plan, text: Conduct) -> list[tuple[frozenset[str], float, float]]:
    """Return the contacts that a scene orders or allows: names of the two parts, begin and end [s]."""
    found = [(frozenset(x.names), -inf, inf) for x in plan.may_touch]
    for begin, end, actions in _stages(plan, text):
        touches = (touch for action in actions for touch in action.may_touch)
        found += [(frozenset(x.names), begin, inf if x.stays else end) for x in touches]
    return found


def landing(plan: Plan, text: Conduct) -> list[tuple[float, float]]:
    """Return the intervals [s] in which an order to land is carried out."""
    return [
        (begin, end)
        for begin, end, actions in _stages(plan, text)
        if any(isinstance(x, Move) and _lands(x.until) for action in actions for x in action.orders)
    ]


def turning(plan: Plan, text: Conduct) -> list[tuple[str, float, float]]:
    """Return the blocks that are ordered to turn, each with the interval [s] of the stage that orders it."""
    stages = _stages(plan, text)
    return [(x.block, t, end) for t, end, some in stages for a in some for x in a.orders if isinstance(x, Turn)]


def turned(plan: Plan, text: Conduct) -> Iterator[tuple[int, float]]:
    """Yield the number (from 1) of each action whose turn ended at the ordered angle, and the time [s] of the end."""
    masters = [(f"{own.name}-{TURN}", own.first, own.start) for own in plan.lists] or [(TURN, 0, plan.start)]
    for (master, first, angle), (_, after, _) in pairwise([*masters, ("", len(plan.actions), 0.0)]):
        orders = [(n, x.to) for n in range(first, after) for x in plan.actions[n].orders if isinstance(x, Turn)]
        moves = [x for x in text.turns if x[1] == master]
        for (t, _, v, a, distance), (then, *_) in pairwise([*moves, (text.end + ENDED, "", 0.0, 0.0, 0.0)]):
            way, angle = abs(distance), angle + distance
            if not v * a * way:
                continue  # a stop
            end = t + (way / v + v / a if a * way > v * v else 2.0 * sqrt(way / a))
            number = next((n for n, to in orders if abs(to - angle) < ENDED), None)
            if number is not None and end <= then:
                yield number + 1, end
                orders = [x for x in orders if x[0] > number]


def _stages(plan: Plan, text: Conduct) -> Iterator[tuple[float, float, Sequence[Action]]]:
    """Yield the interval [s] of each stage with its actions, including the unnamed ones that follow."""
    firsts = [own.first for own in plan.lists] or [0]
    for first, after in (x for x in pairwise([*firsts, len(plan.actions)]) if x[0] < x[1]):
        begun = [(0.0, first), *((t, number) for t, number, _ in text.stages if first <= number < after)]
        named = [first, *(i for i in range(first + 1, after) if plan.actions[i].stage), after]
        for (t, number), (end, _) in pairwise([*begun, (max(text.end, begun[-1][0]), after)]):
            i = bisect_right(named, number) - 1
            yield t, end, plan.actions[named[i] : named[i + 1]]


def _lands(until: Condition | None) -> bool:
    return any(isinstance(x, LandedCondition) for x in terms(until))


def _stops(plan: Plan, text: Conduct) -> Iterator[Check]:
    """Yield findings for two-blocked hooks and drives at their end stops; each once."""
    hooks = [(machine.name, hook.rope) for machine in plan.machines for hook in machine.hooks]
    names = {rope: f"the hook {rope.removeprefix(f'{name}.')} of {name}" for name, rope in hooks}
    seen = set()
    for t, actor, limit in text.stopped:
        if (actor, limit) in seen or limit.startswith("interlock "):
            continue
        seen.add((actor, limit))
        if limit == UPPER:
            message = f"{names.get(actor) or driven(actor)} was two-blocked: its upper limit switch stopped it"
            yield finding("red", "hook height", actor, message, t=t)
        else:
            message = f"{names.get(actor) or driven(actor)} was stopped by its limit '{limit}'"
            yield finding("amber", "limit", actor, message, t=t)


def _interlocks(plan: Plan, text: Conduct) -> Iterator[Check]:
    """Yield findings for interlocks that tripped or were bypassed; each once."""
    known, seen = {x.name: x for x in plan.interlocks}, set()
    for t, name in text.bypassed:
        if name in known:
            message = f"the interlock {name} was bypassed"
            yield finding("amber", "bypass", name, message, t=t)
    for t, name, bypassed in text.tripped:
        if name in known and (name, bypassed) not in seen:
            state, message = known[name].message(bypassed)
            yield finding(state, "interlock", name, message, where=known[name].where, t=t)
        seen.add((name, bypassed))


def _at_once(plan: Plan, text: Conduct) -> Iterator[Check]:
    """Yield findings for stages that ended as soon as they began although they had moves."""
    found: dict[int, tuple[float, str]] = {}
    for t, number, _ in text.skipped:
        if number < len(plan.actions):
            until = next((_until(x) for x in plan.actions[number].orders if _until(x)), "")
            found.setdefault(
                number, (t, f"'{until}' held already, so it moved nothing" if until else "it moved nothing")
            )
    for (t, number, _), (after, following, _) in pairwise(text.stages):
        action = plan.actions[number] if number < len(plan.actions) else None
        if action and after == t and following == number + 1 and _moves(action) and not plan.actions[following].when:
            found.setdefault(number, (t, "it took 0 s, for everything stood already where it was ordered"))
    names = {number: name for _, number, name in text.stages}
    for number, (t, why) in sorted(found.items()):
        name = f"the stage '{names[number]}'" if number in names else f"action {number + 1}"
        subject, place = names.get(number, f"action {number + 1}"), (plan.actions[number].where, names.get(number, ""))
        yield finding("red", "stage", subject, f"{name} ended at once: {why}", where=place[0], stage=place[1], t=t)


def _moves(action: Action) -> bool:
    """Return whether the action has moves."""
    return any(isinstance(order, Turn) or (isinstance(order, Move) and not order.trims) for order in action.orders)


def _until(order: object) -> str:
    """Return the text of the condition in an order's `until`; "" without one."""
    if not isinstance(order, Move) or order.until is None:
        return ""
    return order.until.text or type(order.until).__name__.lower()
