"""Conditions of the action list: their evaluation, the times at which they can become true, and their description.

A condition is evaluated only when a report or a time arrives, on the observed state, so a condition that holds already
takes effect at once. Real numbers are compared by thresholds of the kernel, never here.

The module also holds the state of the lift as the commander knows it from reports, and the exception for orders and
conditions that are refused. Its text does not name lines of the scene: for an operator's command it is the answer, and
for the action list the line is put before it.
"""

from collections.abc import Iterator
from dataclasses import dataclass, field

from heavylift.kernel.description.mechanics import Threshold
from heavylift.kernel.errors import ModelError
from heavylift.nodes.devs import seconds
from heavylift.nodes.models.parts import messages as m
from heavylift.nodes.plan import actions as scene
from heavylift.nodes.plan.plan import Plan, driven

OFF = "unhooked"


@dataclass
class ObservedState:
    """State of the lift known from reports: of ropes (taut, slack, unhooked), supports of bodies, and thresholds."""

    ropes: dict[str, str] = field(default_factory=dict)
    bodies: dict[str, tuple[str, ...]] = field(default_factory=dict)  # bodies with supports, by model
    grounded: set[str] = field(default_factory=set)  # bodies that a support touches
    landed: set[str] = field(default_factory=set)  # bodies that stand on a whole face
    reached: set[str] = field(default_factory=set)  # thresholds
    parted: set[str] = field(default_factory=set)  # slings and ropes that broke
    tripped: set[str] = field(default_factory=set)  # interlocks
    begun: set[str] = field(default_factory=set)  # lifts whose lists the whole scene's has begun
    ended: set[str] = field(default_factory=set)  # lifts whose lists are done

    def on_ground(self, model: str) -> bool:
        """Return whether any body of a machine or block touches a support."""
        return any(body in self.grounded for body in self.bodies.get(model, ()))

    def note(self, report: m.Report) -> None:
        """Update the observed state of the lift by a report."""
        actor = report.actor
        match report:
            case m.RopeState():
                if self.ropes[actor] != OFF:
                    self.ropes[actor] = report.state
            case m.Hooked():
                self.ropes[actor] = "slack"
            case m.Unhooked():
                self.ropes[actor] = OFF
            case m.Touched():
                self.grounded.add(actor)
            case m.Landed():
                self.landed.add(actor)
            case m.Lifted():
                self.grounded.discard(actor)
                self.landed.discard(actor)
            case m.Reached():
                self.reached.add(actor)
            case m.Begun():
                self.begun.add(actor)
            case m.Ended():
                self.ended.add(actor)
            case m.Tripped():
                self.tripped = self.tripped | {actor} if report.over else self.tripped - {actor}


class OrderRejected(ModelError):
    """Raised for an order that cannot be carried out.

    `by`: numbers (action, order) of the order that conflicts with it, if any."""

    def __init__(self, sentence: str, by: tuple[int, ...] = ()) -> None:
        super().__init__(sentence)
        self.by = by


@dataclass(frozen=True)
class EvaluationContext:
    """Data for the evaluation of a condition, in addition to the observed state of the lift.

    They are the present time, the time from which durations count, and the orders still open, for `moves done`."""

    now_ns: int
    since_ns: int
    open: tuple[tuple[str, str, bool], ...] = ()  # verb, actor, whether something stopped it


def terms(condition: scene.Condition | None) -> Iterator[scene.Condition]:
    """Yield the terms that a condition joins by `and`."""
    if isinstance(condition, scene.And):
        for part in condition.all:
            yield from terms(part)
    elif condition is not None:
        yield condition


def crossings(condition: scene.Condition | None) -> list[tuple[int, scene.CrossingCondition]]:
    """Return the thresholds in a condition, each with the index of the term that contains it."""
    return [(i, term) for i, term in enumerate(terms(condition)) if isinstance(term, scene.CrossingCondition)]


def crossed(action: scene.Action) -> Iterator[scene.CrossingCondition]:
    """Return the thresholds that the condition of an action and the `until` of its orders wait for."""
    untils = [order.until for order in action.orders if isinstance(order, (scene.Move, scene.Turn))]
    return (crossing for condition in (action.when, *untils) for _, crossing in crossings(condition))


def watched(plan: Plan) -> dict[str, tuple[Threshold, ...]]:
    """Return the thresholds that each model must watch for the action list."""
    found: dict[str, dict[str, Threshold]] = {}
    for crossing in (crossing for action in plan.actions for crossing in crossed(action)):
        found.setdefault(crossing.model, {})[crossing.threshold.name] = crossing.threshold
    return {model: tuple(thresholds.values()) for model, thresholds in found.items()}


def concerned(plan: Plan) -> set[str]:
    """Return the names of the models, ropes and lifts that the conditions of the actions mention."""
    found = set[str]()
    for term in (term for action in plan.actions for term in terms(action.when)):
        match term:
            case scene.SlingsCondition():
                found |= {*term.names}
            case scene.LiftedCondition() | scene.LandedCondition() | scene.CrossingCondition():
                found.add(term.model)
            case scene.EndedCondition():
                found.add(term.lift)
    return found


def holds(condition: scene.Condition, state: ObservedState, moment: EvaluationContext) -> bool:
    """Return whether the condition is true now."""
    return all(_true(term, state, moment) for term in terms(condition))


def next_time(condition: scene.Condition | None, moment: EvaluationContext) -> list[int]:
    """Return the future times [ns] at which the condition can become true by the mere lapse of time."""
    times = [
        moment.since_ns + seconds(term.seconds) for term in terms(condition) if isinstance(term, scene.AfterCondition)
    ]
    return [t for t in times if t > moment.now_ns]


def words(condition: scene.Condition, state: ObservedState, moment: EvaluationContext) -> str:
    """Return a description of why a condition does not hold yet, as in "all slings taut (legs.sling-2 is slack)"."""
    missing = [term for term in terms(condition) if not _true(term, state, moment)]
    return " and ".join(_words(term, state, moment) for term in missing)


def _true(term: scene.Condition, state: ObservedState, moment: EvaluationContext) -> bool:
    match term:
        case scene.SlingsCondition():
            states = [state.ropes[name] == term.state for name in _hooked(term, state)]
            return all(states) if term.each == "all" else any(states)
        case scene.MovesDone():
            return not _open(term, moment)
        case scene.LiftedCondition():
            return not state.on_ground(term.model)
        case scene.LandedCondition():
            bodies = state.bodies.get(term.model, ())
            return bool(bodies) and all(body in state.landed for body in bodies)
        case scene.CrossingCondition():
            return term.threshold.name in state.reached
        case scene.AfterCondition():
            return moment.now_ns >= moment.since_ns + seconds(term.seconds)
        case scene.BegunCondition():
            return term.lift in state.begun
        case scene.EndedCondition():
            return term.lift in state.ended
        case scene.And():
            return holds(term, state, moment)


def _words(term: scene.Condition, state: ObservedState, moment: EvaluationContext) -> str:
    match term:
        case scene.SlingsCondition():
            wrong = [name for name in _hooked(term, state) if state.ropes[name] != term.state]
            states = _list([f"{name} is {state.ropes[name]}" for name in wrong])
            return f"{term.text or f'{term.each} of {len(term.names)} slings {term.state}'} ({states})"
        case scene.MovesDone():
            return f"{term.text or 'moves done'} ({_list([_message(*x) for x in _open(term, moment)])})"
        case scene.LiftedCondition() | scene.LandedCondition():
            wanted = "lifted" if isinstance(term, scene.LiftedCondition) else "landed"
            return f"{term.text or f'{term.model} {wanted}'}"
        case scene.CrossingCondition():
            guard = f"{term.threshold.quantity} {'>=' if term.rising else '<='} {term.value:g}"
            return term.text or f"{guard} of {term.model}"
        case scene.AfterCondition():
            return term.text or f"after {term.seconds:g} s"
        case scene.BegunCondition():
            return f"the list of the whole scene to begin {term.lift}"
        case scene.EndedCondition():
            return term.text or f"{term.lift} done"
        case scene.And():
            return words(term, state, moment)


def _hooked(term: scene.SlingsCondition, state: ObservedState) -> list[str]:
    names = [name for name in term.names if state.ropes.get(name, OFF) != OFF]
    if not names:
        what, whom = term.text or f"{term.each} slings {term.state}", _list(list(term.names))
        raise OrderRejected(f"`{what}` refers to no sling: none of {whom} is hooked")
    return names


def _message(verb: str, actor: str) -> str:
    return f"{verb} until {actor}" if verb == "wait" else f"{verb} of {driven(actor)}"


def _open(term: scene.MovesDone, moment: EvaluationContext) -> list[tuple[str, str]]:
    found = (x for x in moment.open if not term.verbs or x[0] in term.verbs)
    return [(verb, actor) for verb, actor, stopped in found if not (stopped and term.stopped)]


def _list(names: list[str], most: int = 3) -> str:
    more = f" and {len(names) - most} more" if len(names) > most else ""
    return ", ".join(names[:most]) + more
