"""Checks for orders that cannot be carried out in the state in which they are given: too fast, too far, too early.

Each check gets an action, the static state at its beginning and the states during it. It yields (subject, place in the
scene, sentence); if several subjects have the same error, the first is reported in full.
"""

from collections.abc import Callable, Container, Iterable, Iterator
from functools import cached_property
from math import degrees, inf, pi, radians, sqrt

from heavylift.kernel.algebra.elementary import atan2
from heavylift.kernel.description.mechanics import Joint, Point
from heavylift.kernel.errors import ModelError
from heavylift.nodes.models.commander.actuator_registry import first_lugs
from heavylift.nodes.models.commander.conditions import terms
from heavylift.nodes.models.commander.order_checks import Machines, sling_fault
from heavylift.nodes.plan import actions, plan
from heavylift.nodes.plan.connections import beneath, ties_on
from heavylift.nodes.plan.fidelity import held_by
from heavylift.nodes.plan.verbs import MOTIONS, VERBS
from heavylift.nodes.scene.keys import schema
from heavylift.nodes.statics.aiming import SLACK, world
from heavylift.nodes.statics.state import Acted, StaticState
from heavylift.nodes.statics.static_path import Followed

from .geometry import Findings, Violations, goal_checks, named, reach

SAME = 1.0 + 1e-6  # times a speed that is not faster
LOADED = 10e3  # [N] of a sling: what taking up its slack leaves in it is no load
TIPS = radians(10.0)  # of a block that leans as it is lifted


class CheckedOrder:
    """An action to be checked, with the static state at its beginning and the static states during the action.

    `hooked`, `lugs`: lugs of the hooked slings before and after the action's own orders (other hooked ropes have no
    lug); `parted`: slings that broke before the action.
    """

    def __init__(
        self,
        scene: schema.Scene,
        machines: Machines,
        action: plan.Action,
        acted: Acted,
        states: list[StaticState],
        hooked: dict[str, str],
        parted: set[str],
    ) -> None:
        self.scene, self.machines, self.plan, self.action, self.states = scene, machines, machines.plan, action, states
        self.before: StaticState = acted.before
        self.taut = set(acted.taut)
        self.hooked, self.parted = hooked, parted
        self.lugs = dict(hooked)
        for order in action.orders:
            _hook(order, self.lugs)

    def hooks(self, move: actions.Move) -> list[plan.Hoist]:
        """Return the hooks that an order moves, directly by their winch or with the drive that carries them."""
        joint, own = self.machines.joints.get(move.actuator), (m for m in self.machines.parts if m.name == move.model)
        hooks = ((hook, beneath(machine, hook.on)) for machine in own for hook in machine.hooks)
        return [hook for hook, below in hooks if hook.rope == move.actuator or (joint and joint in below)]

    def tied(self, hooks: Iterable[plan.Hoist], taut: Container[str]) -> list[tuple[str, Point]]:
        """Return the taut slings below the given hooks that hold a load, each with its lug."""
        ties = (tie for hook in hooks for tie in ties_on(self.machines.parts, hook) if tie.rope in taut)
        ends = ((tie.rope, tie.lower or self.machines.lugs.get(self.hooked.get(tie.rope, ""))) for tie in ties)
        return [(rope, end) for rope, end in ends if end is not None and end.body in self.cargo]

    @cached_property
    def cargo(self) -> dict[str, plan.Mechanism]:
        """The machine that each lifted body belongs to."""
        return {cargo.body: machine for machine in self.machines.parts for cargo in machine.cargo}

    def grounded(self, body: str, x: StaticState) -> bool:
        """Return whether a load stands on a support in the state x."""
        return any(x.supports.get(s.name, 0.0) > 0.0 for s in self.cargo[body].system.supports)

    def loaded(self, x: StaticState, move: actions.Move) -> bool:
        """Return whether the hooks of a move carry a load in the state x, even if the load also stands on supports."""
        carry = {rope for rope, tension in x.tensions.items() if tension > LOADED}
        return bool(self.tied(self.hooks(move), carry))


def order_checks(scene: schema.Scene, built: plan.Plan, path: Followed) -> list[tuple[str, str]]:
    """Return the errors of the orders along the equilibrium path, as (place in the scene, sentence)."""
    found, machines, parted = Findings(), Machines(built), set[str]()
    hooked = {rope.name: "" for m in built.machines for rope in m.system.all_ropes if rope.hooked}
    hooked |= first_lugs(machines.parts)
    for number, acted in enumerate(path.acted, 1):
        action = built.actions[number - 1]
        order = CheckedOrder(
            scene, machines, action, acted, [x for x in path.states if x.action == number], hooked, parted
        )
        hooked = order.lugs
        parted = parted | {o.sling for o in action.orders if isinstance(o, actions.UnhookSling) and o.parted}
        for check in CHECKS:
            for each in check(order):
                found.take(f"{each[1]} {check.__name__}", iter([each]), where=each[1])
        goal_checks(found, built, acted.before, action)
        if found.sentences:
            break
    return found.list()


def _hook(order: actions.Order, lugs: dict[str, str]) -> None:
    """Update the lugs of the hooked slings with the effect of an order."""
    if isinstance(order, actions.Hookup):
        lugs[order.sling] = order.lug
    elif isinstance(order, actions.UnhookSling):
        lugs.pop(order.sling, None)


def held_orders(built: plan.Plan) -> list[tuple[str, str]]:
    """Return an error (place in the scene, sentence) for the first order to each joint that the model level locks.

    Planar motion locks the joints that would leave the plane; the key `locked` locks the joints that it names. A turn
    moves the trolleys of those hooks that carry slings when the turn is ordered.
    """
    found = Findings()
    machines = Machines(built)
    lugs = first_lugs(machines.parts)
    for action in built.actions:
        for order in action.orders:
            _hook(order, lugs)
            ordered = [joint for joint in _moved(machines, order, lugs) if joint.name in built.fidelity.locked]
            violations = (
                (joint.name, order.where, f"{held_by(built.fidelity, joint)}, or leave the order out")
                for joint in ordered
            )
            found.take(f"{order.where} held", violations, where=order.where)
    return found.list()


def _moved(machines: Machines, order: actions.Order, lugs: dict[str, str]) -> list[Joint]:
    """Return the joints that an order moves; none for an impossible turn, which another check reports."""
    try:
        return machines.moved(order, lugs)
    except ModelError:
        return []


# ---- checks ---------------------------------------------------------------------------------------------------


def _spoken(x: CheckedOrder) -> Violations:
    """Yield an error for a condition on slings none of which is hooked at that time."""
    untils = [(o.until, x.lugs) for o in x.action.orders if isinstance(o, actions.Move | actions.Turn)]
    slings = {tie.rope for machine in x.machines.parts for tie in machine.ties}
    for condition, lugs in [(x.action.when, x.hooked), *untils]:
        for term in terms(condition):
            if (
                isinstance(term, actions.SlingsCondition)
                and set(term.names) <= slings
                and not set(term.names) & set(lugs)
            ):
                message = f"'{term.text}' cannot hold here: none of {len(term.names)} slings is hooked"
                yield term.text, term.where, message


def _reaches(x: CheckedOrder) -> Violations:
    """Yield an error for a sling that is to be hooked out of its reach."""
    ties = {tie.rope: (tie, machine.name) for machine in x.machines.parts for tie in machine.ties}
    lengths = {rope.name: rope.L0 for machine in x.machines.parts for rope in machine.system.straight_ropes}
    for order in x.action.orders:
        if isinstance(order, actions.Hookup) and order.sling in lengths and order.sling in ties:
            tie, machine = ties[order.sling]
            lug = tie.lower or x.machines.lugs.get(order.lug)
            if lug is None:
                continue
            upper, place = world(x.before, tie.upper.body, tie.upper.p), world(x.before, lug.body, lug.p)
            called = order.lug or tie.lug or next((name for name, p in x.machines.lugs.items() if p == lug), lug.body)
            if message := reach(tie.rope, lengths[tie.rope], called, upper, place):
                yield machine, order.where, message


def _hangs(x: CheckedOrder) -> Violations:
    """Yield an error for hooking a sling that is hooked already, and for unhooking one that is not."""
    for order in x.action.orders:
        if not isinstance(order, actions.Hookup | actions.UnhookSling):
            continue
        if fault := sling_fault(order, x.hooked, x.hooked, x.parted):
            yield order.sling, order.where, fault


def _lets_fall(x: CheckedOrder) -> Violations:
    """Yield an error for orders that unhook the last taut sling of a suspended load."""
    unhooked = {o.sling for o in x.action.orders if isinstance(o, actions.UnhookSling) and not o.parted}
    taut = {rope for rope, tension in x.before.tensions.items() if tension > SLACK}
    hooks = [hook for machine in x.machines.parts for hook in machine.hooks]
    holding: dict[str, set[str]] = {}
    for rope, end in x.tied(hooks, taut):
        holding.setdefault(end.body, set()).add(rope)
    for body, slings in holding.items():
        if slings & unhooked and not slings & x.lugs.keys() and not x.grounded(body, x.before):
            yield body, x.action.where, f"no taut sling is left: the {named(body)} would fall ({x.action.stage})"


def _turns(x: CheckedOrder) -> Violations:
    """Yield an error for turning a block that is not suspended from hooks that can follow the turn."""
    for order in x.action.orders:
        if not isinstance(order, actions.Turn):
            continue
        if order.block in x.cargo and x.grounded(order.block, x.before):
            yield order.block, order.where, "the block stands on its supports and cannot turn: hoist it first"
            continue
        try:
            x.machines.followers(order, x.lugs)
        except ModelError as error:
            yield order.block, order.where, str(error)


def _drags(x: CheckedOrder) -> Violations:
    """Yield an error for a crane that moves sideways while its taut slings hold a load that stands on supports."""
    for m in _moves(x, [verb.name for verb in VERBS.values() if verb.along]):
        tied = [(rope, end) for rope, end in x.tied(x.hooks(m), x.taut) if x.grounded(end.body, x.before)]
        if tied:
            rope, end = tied[0]
            message = f"{m.model} would {m.verb} while the {named(end.body)} is on its supports and {rope} taut"
            yield m.actuator, m.where, f"{message}: slacken or unhook the slings first"


def _fast(x: CheckedOrder) -> Violations:
    """Yield an error for a winch that is faster than allowed with a load."""
    limits = {a.name: a.loaded for machine in x.machines.parts for a in machine.actuators if a.loaded is not None}
    for m in (m for m in _moves(x, MOTIONS) if m.actuator in limits):
        moving = (state for state in x.states if abs(state.speeds.get(m.actuator, 0.0)) > 0.0)
        limit = limits[m.actuator]
        if abs(m.speed) > limit * SAME and any(x.loaded(state, m) for state in (x.before, *moving)):
            message = f"{m.verb} {abs(m.speed) * 60:g} m/min is faster than {m.model} can with a load"
            yield m.actuator, m.where, f"{message}: {limit * 60:g} m/min"


def _pushes(x: CheckedOrder) -> Violations:
    """Yield an error for a tugger line of which more tension is taken away than it has."""
    for m in _moves(x, ["pull"]):
        tension = x.before.tensions.get(m.actuator, 0.0)
        if m.by is not None and tension + m.by < -SLACK:
            message = f"'{m.actuator}' has {tension / 1e3:.3g} kN, and 'by {m.by / 1e3:.3g} kN' leaves less than 0 kN"
            yield m.actuator, m.where, f"{message}: a line cannot push"


def _follows(x: CheckedOrder) -> Violations:
    """Yield an error for a winch or trolley that would have to follow a turn faster than its maximum speed."""
    drives = [(each.name, each.loaded or each.speed) for machine in x.machines.parts for each in machine.actuators]
    for order in (order for order in x.action.orders if isinstance(order, actions.Turn)):
        for name, limit in drives:
            speed = max((abs(state.speeds.get(name, 0.0)) for state in x.states), default=0.0)
            if limit is not None and speed > limit * SAME:
                message = f"{plan.driven(name)} would have to follow the turn at {speed * 60:.1f} m/min"
                yield name, order.where, f"{message}, but its maximum is {limit * 60:g} m/min"


def _tips(x: CheckedOrder) -> Violations:
    """Yield an error for a lifted load that tips over: its centre of mass is outside the lugs that should carry it, or
    some of them carry nothing."""
    if any(isinstance(o, actions.Turn) for o in x.action.orders):
        return
    for body in (body for body in x.cargo if x.grounded(body, x.before)):
        hung = [s for s in x.states if not x.grounded(body, s)]
        first = next((s for s in hung if _lean(s, body) > TIPS), None)
        if first is None:
            continue
        tips, held = f"tips by {degrees(_lean(first, body)):.0f} degrees", _held(x.machines, first, body)
        slack = [next((name for name in sorted(held) if s.tensions[name] <= 0.0), "") for s in (hung[0], first)]
        if slack[0] and _between(x, body, held):
            message = f"the {named(body)} is lifted while {slack[0]} is slack, and {tips} in the end"
            yield body, x.action.where, f"{message}: hoist the hook of this sling first, or shorten it"
            continue
        hint = f", and {slack[1]} goes slack" if slack[1] else ""
        message = f"the {named(body)} {tips} as it is lifted{hint}"
        yield body, x.action.where, f"{message}: its centre of mass is not between the lugs that carry it"


def _held(machines: Machines, x: StaticState, body: str) -> set[str]:
    """Return the slings that are hooked to a body in a state."""
    ends = ((name, machines.lugs.get(lug)) for name, lug in x.hooked.items())
    return {name for name, end in ends if end is not None and end.body == body}


def _between(x: CheckedOrder, body: str, slings: Container[str]) -> bool:
    """Return whether the centre of mass of a load is, in plan, between the hooks that carry these slings: no vertical
    plane through it has all of them on one side."""
    com = next(b.com for b in x.cargo[body].system.bodies if b.name == body)
    hooks = (hook for machine in x.machines.parts for hook in machine.hooks)
    eyes = (hook.eye for hook in hooks if any(tie.rope in slings for tie in ties_on(x.machines.parts, hook)))
    places, (cx, cy, _) = [world(x.before, eye.body, eye.p) for eye in eyes], world(x.before, body, com)
    around = sorted(atan2(float(p[1] - cy), float(p[0] - cx)) for p in places)
    gaps = (b - a for a, b in zip(around, [*around[1:], *(a + 2.0 * pi for a in around[:1])], strict=True))
    return max(gaps, default=inf) <= pi * SAME


def _lean(x: StaticState, body: str) -> float:
    """Return the angle [rad] between the vertical and the axis of a body that is closest to the vertical."""
    R = x.poses[body][1]
    upright = min(1.0, max(abs(R[2][i]) for i in range(3)))
    return float(atan2(sqrt(1.0 - upright * upright), upright))


def _moves(x: CheckedOrder, verbs: Iterable[str]) -> Iterator[actions.Move]:
    for order in x.action.orders:
        if isinstance(order, actions.Move) and order.verb in verbs:
            yield order


CHECKS: tuple[Callable[[CheckedOrder], Violations], ...] = (
    _spoken, _hangs, _reaches, _lets_fall, _turns, _drags, _fast, _pushes, _follows, _tips,
)  # fmt: skip
