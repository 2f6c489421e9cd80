"""The parts of machines (Fig. 7 of the paper), and how they are coupled.

    joint coupled = joint atomic (type of the joint)       + actors, which generate the forces on the joint
    body coupled  = body atomic (properties of the body)   + actors, which generate the forces on the body
    machine       = joint coupled and body coupled models: one per real object

Each part declares a piece of the mechanical system. A `LawModel` is an actor whose force law never changes; a
`LiveActor` receives orders and state events and sends kernel inputs and reports. Groups, machines and live actors have
the same four ports, so a message reaches the actor that it names without a dispatcher.
"""

from collections.abc import Iterable, Iterator
from typing import NoReturn, TypeVar

from heavylift.kernel.description.mechanics import Body, Joint, System, merge
from heavylift.kernel.errors import ModelError
from heavylift.nodes.devs import Atomic, Bag, Coupled, In, InPort, Model, Out
from heavylift.nodes.plan.places import numbered

from .messages import KernelInput, Order, Report, StateEvent

Child = TypeVar("Child", bound=Model)


def declared(models: list[Model]) -> System:
    """Return the mechanical system that these models and all their descendants declare, in the order of the tree."""
    return merge(_pieces(models), System().gravity)


def _pieces(models: Iterable[Model]) -> Iterator[System]:
    for model in models:
        if isinstance(model, Coupled):
            yield from _pieces(model.children.values())
        elif isinstance(model, Part):
            yield model.declare()


class Part(Atomic):
    """An atomic model that declares a piece of the mechanical system."""

    def __init__(self, name: str, laws: System | None = None) -> None:
        super().__init__(name)
        self.laws = laws or System()

    def declare(self) -> System:
        """Return the piece of the mechanical system that this part declares."""
        return self.laws


class JointAtomic(Part):
    """Atomic model that declares a joint: its type, position and start values."""

    def __init__(self, joint: Joint) -> None:
        super().__init__("joint")
        self.joint = joint

    def declare(self) -> System:
        """Return the mechanical system that consists of this joint."""
        return System(joints=(self.joint,))


class BodyAtomic(Part):
    """Atomic model that declares a body: its mass, centre of mass and inertia."""

    def __init__(self, body: Body) -> None:
        super().__init__("body")
        self.body = body

    def declare(self) -> System:
        """Return the mechanical system that consists of this body."""
        return System(bodies=(self.body,))


class Actor(Part):
    """Base class of atomic models that declare force laws on a body or joint."""


class LawModel(Actor):
    """Actor of a force that takes no orders, such as weight, a damper or an end stop."""


class LiveActor(Actor):
    """Base class of actors that execute orders to `element` and process state events of the elements in `hears`.

    `say` puts messages into its outbox, which is sent at the next microstep; the messages of `due` are sent at the time
    `wake` [ns]."""

    order = In(Order)
    state = In(StateEvent)
    input = Out(KernelInput)
    report = Out(Report)

    def __init__(self, name: str, element: str, laws: System | None = None, hears: tuple[str, ...] = ()) -> None:
        super().__init__(name, laws)
        self.element = element
        self.hears = frozenset(hears)
        self.outbox: list[KernelInput | Report] = []
        self.wake: int | None = None

    def start(self) -> None:
        """Set the actor's initial state at logical time (0, 0), and schedule its first messages."""
        self.outbox, self.wake = [], None
        self.begin()
        self.schedule()

    def external(self, e: int, x: Bag) -> None:
        """Process the orders and state events that concern this actor."""
        for order in x.get(self.order, []):
            if self.answers(order.actor):
                self.execute(order)
        for event in x.get(self.state, []):
            if event.name in self.hears:
                self.notice(event)
        self.schedule()

    def output(self) -> None:
        """Send the actor's outbox or, if it is empty, the messages due now."""
        for message in self.outbox or self.due():
            if isinstance(message, KernelInput):
                self.input.send(message)
            else:
                self.report.send(message)

    def internal(self) -> None:
        """Remove the messages that the actor has sent or, if there were none, wake it up and change its state."""
        if self.outbox:
            self.outbox = []
        else:
            self.wake = None
            self.expire()
        self.schedule()

    def schedule(self) -> None:
        """Schedule the actor's output: at the next microstep if its outbox has messages, else at its wake-up time."""
        if self.outbox:
            self.hold_in(0)
        elif self.wake is not None:
            self.hold_in(self.wake - self.now.t)
        else:
            self.passivate()

    def say(self, *messages: KernelInput | Report) -> None:
        """Put messages into the actor's outbox, which is sent at the next microstep."""
        self.outbox = [*self.outbox, *messages]

    def refuse(self, order: Order, text: str) -> NoReturn:
        """End the run with an error about an order that the actor cannot execute."""
        raise ModelError(f"{numbered(order.at)}: {text}")

    def answers(self, element: str) -> bool:
        """Return whether this actor executes orders to the mechanical element with this name."""
        return element == self.element

    def begin(self) -> None:
        """Set the state of the actor at the start of the run."""

    def execute(self, order: Order) -> None:
        """Carry out an order to the actor."""
        self.refuse(order, f"{self.element} cannot carry out '{order.what.__struct_config__.tag}'")

    def notice(self, event: StateEvent) -> None:
        """Process a state event of the kernel that concerns the actor."""

    def due(self) -> list[KernelInput | Report]:
        """Return the messages that the actor sends at its wake-up time, without changing its state."""
        return []

    def expire(self) -> None:
        """Change the state of the actor at its wake-up time."""


def share(outer: Coupled, child: Model) -> None:
    """Connect the ports of a child model with the ports of the same names on its parent."""
    for name, port in child.ports.items():
        if own := outer.ports.get(name):
            outer.connect(*((own, port) if isinstance(port, InPort) else (port, own)))


class Group(Coupled):
    """A coupled model of live actors, with ports for the orders, state events, inputs and reports of all of them."""

    order = In(Order)
    state = In(StateEvent)
    input = Out(KernelInput)
    report = Out(Report)

    def take(self, child: Child) -> Child:
        """Add a child to the group, and connect its ports with the group's ports of the same names."""
        self.add(child)
        share(self, child)
        return child

    def declare(self) -> System:
        """Return the mechanical system that the group's parts declare."""
        return declared(list(self.children.values()))


class JointCoupled(Group):
    """The coupled model of a joint: its atomic model and the actors of the forces on it."""

    def __init__(self, name: str, joint: Joint, *actors: Actor) -> None:
        super().__init__(name)
        for part in (JointAtomic(joint), *actors):
            self.take(part)


class BodyCoupled(Group):
    """The coupled model of a body: its atomic model and the actors of the forces on it."""

    def __init__(self, name: str, body: Body, *actors: Actor) -> None:
        super().__init__(name)
        for part in (BodyAtomic(body), *actors):
            self.take(part)


class RealObject(Group):
    """The coupled model of a real object: crane, lifting frame, block or mechanism."""
