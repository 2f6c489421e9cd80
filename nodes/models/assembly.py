"""From a plan to models and couplings: the model of each node process, and the couplings between nodes.

One coupled model per real object and one for the commander, which also owns the master of a turn. Node names:
"commander", machines, user models, and "kernel" for the mechanics.
"""

from collections.abc import Collection, Iterable, Iterator, Mapping
from typing import Any, TypeAlias, cast

import msgspec
from heavylift.kernel.description.mechanics import Master, System, Threshold, assembled
from heavylift.kernel.errors import ModelError
from heavylift.nodes.devs import Atomic, Bag, Coupled, Event, In, Model, Out
from heavylift.nodes.models.commander.actuator_registry import machines, turns
from heavylift.nodes.models.commander.commander import Commander
from heavylift.nodes.models.commander.conditions import concerned, crossed, watched
from heavylift.nodes.models.parts import messages as m
from heavylift.nodes.models.parts.drive import DriveActor
from heavylift.nodes.models.parts.gauges import ThresholdWatcher, fit
from heavylift.nodes.models.parts.parts import LiveActor, RealObject, declared, share
from heavylift.nodes.plan.actions import Begin
from heavylift.nodes.plan.plan import ActionList, Mechanism, Plan

from .levels.listing import as_modelled
from .machine import MachineModel
from .user_models import UserModelNode, aim_port, sample_port

COMMANDER, KERNEL = "commander", "kernel"
Coupling: TypeAlias = tuple[str, str, str, str]  # source model, its out port, target model, its in port


class Ending(Atomic):
    """Atomic model that reports, after the last action list, that all action lists are finished."""

    heard, finished = In(m.Finished), Out(m.Finished)

    def __init__(self, lists: int) -> None:
        super().__init__("ending")
        self.lists = lists

    def start(self) -> None:
        """Start with all action lists unfinished."""
        self.left = self.lists
        self.passivate()

    def external(self, e: int, x: Bag) -> None:
        """Count the action lists that have finished."""
        self.left -= len(x.get(self.heard, ()))
        if self.left == 0:
            self.hold_in(0)

    def output(self) -> None:
        """Send `finished` after the last action list."""
        self.finished.send(m.Finished())

    def internal(self) -> None:
        """Wait for the next input after the message `finished` was sent."""
        self.passivate()


class CommanderModel(Coupled):
    """Coupled model of the commander: action lists, and the virtual master drive for turns of the block."""

    report, command = In(m.Report), In(m.OperatorCommand)
    stage = Out(m.Stage)
    skipped = Out(m.Skipped)
    finished = Out(m.Finished)
    answer = Out(m.OperatorAnswer)

    def __init__(self, plan: Plan) -> None:
        super().__init__(COMMANDER)
        if plan.lists:
            self._lists(plan)
        else:
            self.actions = self.add(Commander("actions", plan))
            for port in self.actions.aims:
                self.add_in(port.name, m.SetPoint)
            share(self, self.actions)
            for name in machines(plan):
                self.connect(self.actions.to[name], self.add_out(f"order_{name}", m.Order))
            self._turning(self.actions)

    def _turning(self, commander: Commander) -> None:
        """Add the master actor of a commander's turns."""
        plan, master = commander.plan, commander.turn
        if turns(plan):
            turn = self.add(DriveActor(master, master, System(masters=(Master(master),)), start=plan.start))
            self.connect(commander.to[master], turn.order)
            self.connect(turn.report, commander.report)
            self.connect(turn.input, self.ports.get("input") or self.add_out("input", m.KernelInput))

    def _lists(self, plan: Plan) -> None:
        """Add a commander for each action list, coupled with its machines."""
        ending = self.add(Ending(len(plan.lists)))
        self.connect(ending.finished, self.finished)
        ends = [*(each.first for each in plan.lists[1:]), len(plan.actions)]
        for each, end in zip(plan.lists, ends, strict=True):
            led = tuple(own for own in plan.models if any(x.move.model in each.machines for x in own.leads))
            more = {"models": led, "actions": plan.actions[each.first : end], "lists": (each,)}
            own = _of_lift(plan, each, **more) if each.machines else msgspec.structs.replace(plan, limits=(), **more)
            commander = self.add(Commander(each.name, own))
            if each.machines:
                self.connect(self.add_in(f"report_{each.name}", m.Report), commander.report)
                self._turning(commander)
            else:
                self._begin_others(commander, plan.lists)
            for out in ("stage", "skipped", "answer"):
                self.connect(commander.ports[out], self.ports[out])
            self.connect(commander.finished, ending.heard)
            self.connect(self.command, commander.command)
            for port in commander.aims:
                self.connect(self.add_in(port.name, m.SetPoint), port)
            for name in (name for name in commander.to if name != commander.turn):
                out = f"order_{name}"
                self.connect(commander.to[name], self.ports.get(out) or self.add_out(out, m.Order))

    def _begin_others(self, whole: Commander, lists: tuple[ActionList, ...]) -> None:
        """Couple the commander of the whole scene with those of the lifts: it starts the lifts and receives the
        messages about their ends."""
        about = {whole.owners.get(name, name) for name in concerned(whole.plan)}
        begins = {order.lift for action in whole.plan.actions for order in action.orders if isinstance(order, Begin)}
        for each in (each for each in lists if each.machines):
            other = self.children[each.name]
            if about & {*each.machines}:
                self.connect(self.ports[f"report_{each.name}"], whole.report)
            if each.name in about:
                self.connect(other.ports["lists"], whole.report)
            if each.name in begins:
                self.connect(whole.ports["lists"], other.ports["report"])

    def waiting_for(self) -> str:
        """Return a sentence about the conditions that the action lists still wait for; "" when the lists are done."""
        lists = [child for child in self.children.values() if isinstance(child, Commander)]
        return "; ".join(message for each in lists if (message := each.waiting_for()))

    def declare(self) -> System:
        """Return the commander's mechanics: a virtual master drive that actuators follow in a turn of a block."""
        return declared(list(self.children.values()))


NodeModel: TypeAlias = CommanderModel | RealObject | UserModelNode


def build(plan: Plan, names: Iterable[str] | None = None) -> dict[str, NodeModel]:
    """Return the models of a plan, or those in `names`, by node name; drives that replay a log are given this log."""
    names = names or (COMMANDER, *machines(plan), *(own.name for own in plan.models))
    crossed, known = watched(plan), {machine.name: machine for machine in plan.machines}
    models = {name: _built(plan, name, known.get(name), crossed.get(name, ())) for name in names}
    logs = {log.actuator: log for log in plan.driven}
    for drive in (drive for model in models.values() for drive in drives(model)) if logs else ():
        drive.log = logs.get(drive.element)
    return models


def build_one(plan: Plan, name: str) -> NodeModel:
    """Build the model of one node."""
    return build(plan, [name])[name]


def node_names(plan: Plan) -> tuple[str, ...]:
    """Return all nodes of a run: commander, machines, user models, kernel."""
    return (COMMANDER, *machines(plan), *(own.name for own in plan.models), KERNEL)


def divided(plan: Plan, nodes: Iterable[Collection[str]]) -> Iterator[Plan]:
    """Yield, for each node, the part of the plan that it needs; the commander gets the whole plan."""
    waiting: dict[str, set[int]] = {}  # model -> actions for which it watches a threshold
    for number, action in enumerate(plan.actions):
        for crossing in crossed(action):
            waiting.setdefault(crossing.model, set()).add(number)
    for names in nodes:
        if COMMANDER in names:
            yield plan
            continue
        asked = sorted({number for name in names for number in waiting.get(name, ())})
        yield _only(
            plan,
            names,
            models=plan.models if any(own.name in names for own in plan.models) else (),  # which may share globals
            actions=tuple(plan.actions[number] for number in asked),
            lists=tuple(each for each in plan.lists if any(name in names for name in each.machines)),
        )


def _only(plan: Plan, machines: Collection[str], **more: Any) -> Plan:
    """Return the part of a plan for some machines."""
    more["machines"] = tuple(each for each in plan.machines if each.name in machines)
    more["interlocks"] = tuple(each for each in plan.interlocks if each.machine in machines)
    return msgspec.structs.replace(plan, limits=(), gear=(), **more)


def _of_lift(plan: Plan, of: ActionList, **more: Any) -> Plan:
    """Return the plan of one of several lifts."""
    own = _only(plan, of.machines, lists=(of,), **{key: x for key, x in more.items() if key != "lists"})
    return msgspec.structs.replace(own, fidelity=of.fidelity, start=of.start)


def driving(plan: Plan) -> tuple[str, ...]:
    """Return the nodes whose events keep a run going until its action list is done: commander and machines.

    User models are left out because they may run forever."""
    return (COMMANDER, *machines(plan))


def goes_on(event: Event) -> bool:
    """Return whether an event shows progress: a message from the commander other than a set-point."""
    if event.source != COMMANDER:
        return False
    return event.type != m.Order.__name__ or not cast("m.Order", event.value).led


def together(plan: Plan) -> Coupled:
    """Return the user's models of a plan as children of one coupled model."""
    root = Coupled(plan.name)
    for own in plan.models:
        root.add(UserModelNode(own))
    return root


def drives(model: NodeModel) -> list[DriveActor]:
    """Return all drives and winches of a model."""
    return [actor for actor in _actors(model) if isinstance(actor, DriveActor)]


def _built(plan: Plan, name: str, machine: Mechanism | None, thresholds: tuple[Threshold, ...]) -> NodeModel:
    if name == COMMANDER:
        return CommanderModel(plan)
    if own := next((own for own in plan.models if own.name == name), None):
        return UserModelNode(own)
    if machine is None:
        known = ", ".join([COMMANDER, *machines(plan)])
        raise ModelError(f"there is no model {name} in {plan.name}; its models are {known}")
    model = MachineModel(as_modelled(plan, machine))
    if thresholds:
        model.take(ThresholdWatcher("gauge", thresholds))
    for interlock in (interlock for interlock in plan.interlocks if interlock.machine == name):
        fit(model, interlock)
    return model


def system(plan: Plan, models: Mapping[str, NodeModel] | None = None) -> System:
    """Return the mechanical system that all models of a plan declare together.

    `models`: the models of the plan, if already built."""
    return assembled([model.declare() for model in (models or build(plan)).values()], plan.gravity)


def couplings(plan: Plan) -> list[Coupling]:
    """Return all couplings between nodes, including the kernel."""
    found: list[Coupling] = []
    if turns(plan):
        found.append((COMMANDER, "input", KERNEL, f"input_{COMMANDER}"))
    heard = {name: f"report_{each.name}" for each in plan.lists for name in each.machines}
    for name in machines(plan):
        found += [
            (COMMANDER, f"order_{name}", name, "order"),
            (name, "report", COMMANDER, heard.get(name, "report")),
            (name, "input", KERNEL, f"input_{name}"),
            (KERNEL, f"state_{name}", name, "state"),
        ]
    for own in plan.models:
        found += [(KERNEL, sample_port(own.name, port), own.name, port) for port in own.signals]
        found += [(own.name, led.port, COMMANDER, aim_port(own.name, led.port)) for led in own.leads]
    return found


def subscriptions(plan: Plan, models: Mapping[str, NodeModel] | None = None) -> dict[str, tuple[str, ...]]:
    """Return the nodes that receive the state events of each rope, support or threshold."""
    found: dict[str, tuple[str, ...]] = {}
    for name, model in (models or build(plan)).items():
        for element in sorted({e for actor in _actors(model) for e in actor.hears}):
            found[element] = (*found.get(element, ()), name)
    return found


def _actors(model: Model) -> list[LiveActor]:
    if isinstance(model, Coupled):
        return [actor for child in model.children.values() for actor in _actors(child)]
    return [model] if isinstance(model, LiveActor) else []
