"""Orders that cannot be carried out in the state in which they are given: too fast, too far, too soon.

Each check sees the action, the static state in which it begins and what the path was while it lasted.  It yields
(subject, where, sentence); of several subjects with the same trouble the first is reported in full.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from math import degrees, radians, sqrt

from heavylift.kernel.algebra.elementary import atan2
from heavylift.kernel.errors import ModelError
from heavylift.nodes.models.commander.actuator_registry import first_lugs
from heavylift.nodes.models.commander.conditions import terms
from heavylift.nodes.models.commander.order_checks import Machines, sling_fault
from heavylift.nodes.plan import actions, plan
from heavylift.nodes.plan.fidelity import held_by
from heavylift.nodes.plan.verbs import MOTIONS, VERBS
from heavylift.nodes.scene.keys import schema
from heavylift.nodes.statics.state import Acted, StaticState
from heavylift.nodes.statics.static_state import Following, State, Step, goals, is_taut, lift_state, world

from .findings import Findings, Violations
from .geometry import goal_checks, reach

SAME = 1.0 + 1e-6  # times a speed that is not faster
FALLS = 1.0  # [m] that a block sinks at once when it is let go
TIPS = radians(10.0)  # of a block that leans as it is lifted


class Order:
    """One action with the state in which it begins, and the states that it leads through.

    `hooked`, `lugs`: slings and their lugs once the orders before it, and its own, are carried out, and ropes of a
    mechanism with no lug; `parted`: what broke before it.
    """

    def __init__(
        self,
        scene: schema.Scene,
        machines: Machines,
        action: plan.Action,
        acted: Acted,
        steps: list[Step],
        hooked: dict[str, str],
        parted: set[str],
    ) -> None:
        self.scene, self.machines, self.plan, self.action, self.steps = scene, machines, machines.plan, action, steps
        self.before: StaticState = acted.before
        self.state: State = lift_state(self.plan, acted.before)
        self.taut = set(acted.taut)
        self.hooked, self.parted = hooked, parted
        self.lugs = dict(hooked)
        for order in action.orders:
            _hook(order, self.lugs)

    def carrying(self, loaders: set[str]) -> list[str]:
        """Loaders with a taut sling among these."""
        return [x.name for x in self.plan.loaders if x.name in loaders and self._carries(x.name)]

    def _carries(self, loader: str) -> bool:
        return any(s.name in self.taut for s in self.plan.rig.slings if s.loader == loader)

    def moved(self, move: actions.Move) -> set[str]:
        """Loaders that a move takes along."""
        found = set()
        for crane in self.plan.cranes:
            for hook in crane.hooks:
                drives = {hook.rope, plan.drive_name(crane.name, hook.trolley), plan.drive_name(crane.name, "gantry")}
                if move.actuator in drives:
                    found |= {r.carries for r in self.plan.rig.hook_ropes if r.name == hook.rope}
        return found


def order_checks(scene: schema.Scene, built: plan.Plan, followed: Following) -> list[tuple[str, str]]:
    """What is wrong with the orders that could be followed."""
    found = Findings()
    machines, parted = Machines(built), set[str]()
    hooked = first_lugs(machines.parts)
    hooked |= {rope.name: "" for m in built.mechanisms for rope in m.system.all_ropes if rope.hooked}
    for number, acted in enumerate(followed.path.acted, 1):
        action = built.actions[number - 1]
        steps = [step for step in followed.steps if step.static.action == number]
        order = Order(scene, machines, action, acted, steps, hooked, parted)
        hooked = order.lugs
        parted = parted | {o.sling for o in action.orders if isinstance(o, actions.Unhook) and o.parted}
        for check in CHECKS:
            for each in check(order):
                found.take(f"{each[1]} {check.__name__}", iter([each]), where=each[1])
        goal_checks(found, scene, built, order.state, goals(built, action, order.state), action)
        if found.sentences:
            break
    return found.list()


def _hook(order: actions.Order, lugs: dict[str, str]) -> None:
    """The lug of each hooked sling, once an order is carried out."""
    if isinstance(order, actions.Hookup):
        lugs[order.sling] = order.lug
    elif isinstance(order, actions.Unhook):
        lugs.pop(order.sling, None)


def held_orders(built: plan.Plan) -> list[tuple[str, str]]:
    """(where, sentence) of each order to a joint that the fidelity locks; of several to one joint the first.

    A planar motion locks what would leave its plane, the list `locked` what it names.  A turn orders the trolleys of
    the hooks that carry slings then.
    """
    found = Findings()
    machines = Machines(built)
    lugs = first_lugs(machines.parts)
    for action in built.actions:
        for order in action.orders:
            _hook(order, lugs)
            ordered = [joint for joint in _moved(machines, order, lugs) if joint in built.fidelity.locked]
            violations = (
                (joint, order.where, f"{held_by(built.fidelity, joint)}, or leave the order out") for joint in ordered
            )
            found.take(f"{order.where} held", violations, where=order.where)
    return found.list()


def _moved(machines: Machines, order: actions.Order, lugs: dict[str, str]) -> list[str]:
    """Joints that an order moves; none for a turn that no hook can follow, which is reported when it is given."""
    try:
        return machines.moved(order, lugs)
    except ModelError:
        return []


# ---- checks ---------------------------------------------------------------------------------------------------


def _spoken(x: Order) -> Violations:
    """A condition on slings needs a hooked one."""
    untils = [(o.until, x.lugs) for o in x.action.orders if isinstance(o, actions.Move | actions.Turn)]
    for condition, lugs in [(x.action.when, x.hooked), *untils]:
        slings = {s.name for s in x.plan.rig.slings}
        for term in terms(condition):
            if isinstance(term, actions.Slings) and set(term.names) <= slings and not set(term.names) & set(lugs):
                message = f"'{term.text}' says nothing here: none of {len(term.names)} slings is hooked then"
                yield term.text, term.where, message


def _reaches(x: Order) -> Violations:
    """A sling is hooked only if it reaches."""
    assert x.plan.block is not None
    lugs = {lug.name: lug.p for lug in x.plan.block.lugs}
    slings = {s.name: s for s in x.plan.rig.slings}
    for order in x.action.orders:
        if isinstance(order, actions.Hookup) and order.lug in lugs:
            s = slings[order.sling]
            beam = world(x.before, s.beam.body, s.beam.p)
            if message := reach(s, order.lug, beam, world(x.before, x.plan.block.name, lugs[order.lug])):
                yield s.loader, order.where, message


def _hangs(x: Order) -> Violations:
    """A sling is hooked once, and unhooked where it hangs."""
    for order in x.action.orders:
        if not isinstance(order, actions.Hookup | actions.Unhook):
            continue
        if fault := sling_fault(order, x.hooked, x.hooked, x.parted):
            yield order.sling, order.where, fault


def _lets_fall(x: Order) -> Violations:
    """Something holds the block while it hangs."""
    unhooks = any(isinstance(o, actions.Unhook) and not o.parted for o in x.action.orders)
    if x.before.grounded or x.plan.block is None or not unhooks:
        return
    carriers = [s.name for s in x.plan.rig.slings if s.name in x.lugs and is_taut(x.plan, x.before, s.loader)]
    if not carriers:
        yield "block", x.action.where, f"no sling is taut: the block would fall ({x.action.stage})"


def _turns(x: Order) -> Violations:
    """A block that turns hangs, from hooks that can follow."""
    for order in x.action.orders:
        if not isinstance(order, actions.Turn):
            continue
        if x.state.grounded:
            yield "block", order.where, "the block stands on its stools and cannot turn: hoist it first"
            continue
        try:
            x.machines.followers(order, x.lugs)
        except ModelError as error:
            yield "block", order.where, str(error)


def _drags(x: Order) -> Violations:
    """No crane moves sideways with slings that hold on to a block on its stools."""
    for m in _moves(x, [verb.name for verb in VERBS.values() if verb.along]):
        tied = x.carrying(x.moved(m)) if x.state.grounded else []
        if tied:
            message = f"{m.model} would {m.verb} while the block is on its stools and {tied[0]} taut"
            yield m.actuator, m.where, f"{message}: slacken or unhook the slings first"


def _fast(x: Order) -> Violations:
    """No actuator is faster than it can, with or without a load."""
    for m in (m for m in _moves(x, MOTIONS) if m.model in x.scene.cranes):
        crane, verb = x.scene.cranes[m.model], VERBS[m.verb]
        hangs = not x.state.grounded and bool(x.carrying(x.moved(m)))
        limit, how = verb.limit(crane, loaded=hangs), ""
        if limit is None:
            continue
        lifts = verb.sign != 0 and any(_lifts(x, step, m) for step in x.steps)
        if abs(m.speed) <= limit * SAME and lifts:
            limit, how = verb.limit(crane, loaded=True) or limit, " with a load"
        if abs(m.speed) > limit * SAME:
            message = f"{m.verb} {abs(m.speed) * 60:g} m/min is faster than {m.model} can{how}"
            yield m.actuator, m.where, f"{message}: {limit * 60:g} m/min"


def _lifts(x: Order, step: Step, m: actions.Move) -> bool:
    """Whether a winch moves the block in a state."""
    moving = abs(step.static.speeds.get(m.actuator, 0.0)) > 0.0
    return moving and not step.static.grounded and any(is_taut(x.plan, step.static, n) for n in x.moved(m))


def _follows(x: Order) -> Violations:
    """No winch and no trolley has to follow a turn faster than it can."""
    for order in x.action.orders:
        if not isinstance(order, actions.Turn):
            continue
        for crane in x.plan.cranes:
            given = x.scene.cranes[crane.name]
            drives = [(h.rope, h.rope, given.hoist_speed) for h in crane.hooks]
            drives += [
                (f"{crane.name} {t.name}", plan.drive_name(crane.name, t.name), given.trolley_speed)
                for t in (crane.upper, crane.lower)
            ]
            for name, actuator, limit in drives:
                speed = max((abs(step.static.speeds.get(actuator, 0.0)) for step in x.steps), default=0.0)
                if speed > limit * SAME:
                    message = f"{name} would have to follow the turn at {speed * 60:.1f} m/min"
                    yield name, order.where, f"{message}, it can {limit * 60:g} m/min"


def _tips(x: Order) -> Violations:
    """A block that is lifted stays as it was: its centre of mass is inside the lugs that carry."""
    turning = any(isinstance(o, actions.Turn) for o in x.action.orders)
    if turning or not x.state.grounded:
        return
    for step in x.steps:
        if not step.static.grounded and (lean := _lean(x.plan, step.static)) > TIPS:
            message = f"the block tips by {degrees(lean):.0f} degrees as it is lifted"
            slack = sorted(name for name in step.static.hooked if step.static.tensions[name] <= 0.0)
            hint = f", and {slack[0]} goes slack" if slack else ""
            yield "block", x.action.where, f"{message}{hint}: its centre of mass is not between the lugs that carry"
            return


def _lean(built: plan.Plan, x: StaticState) -> float:
    """Angle between the vertical and that of the block which was nearest to it at the start of the lift [rad]."""
    assert built.block is not None
    R = x.poses[built.block.name][1]
    upright = min(1.0, max(abs(R[2][i]) for i in range(3)))
    return float(atan2(sqrt(1.0 - upright * upright), upright))


def _moves(x: Order, verbs: Iterable[str]) -> Iterator[actions.Move]:
    for order in x.action.orders:
        if isinstance(order, actions.Move) and order.verb in verbs and order.model in x.scene.cranes:
            yield order


CHECKS: tuple[Callable[[Order], Violations], ...] = (
    _spoken, _hangs, _reaches, _lets_fall, _turns, _drags, _fast, _follows, _tips,
)  # fmt: skip
