"""Actors of slings, brakes and supports, which can be hooked, engaged or touched.

A sling is hooked and unhooked by orders; whether it is taut or slack is a state event of the kernel. A latch is a brake
that is engaged as long as no sling is hooked. The supports report when the block leaves the ground and when it is back.
"""

from collections.abc import Mapping

from heavylift.kernel.description.mechanics import System
from heavylift.nodes.devs import Bag, In, Out
from heavylift.nodes.plan.actions import BrakeOrder, Hookup, UnhookSling

from . import messages as m
from .parts import LiveActor


class SlingActor(LiveActor):
    """Actor of the sling `element`: hooks and unhooks it, and reports when it becomes taut or slack.

    It also informs the latch of a lifting beam."""

    latch = Out(m.Latch)

    def __init__(self, name: str, rope: str, laws: System | None = None) -> None:
        super().__init__(name, rope, laws, hears=(rope,))

    def execute(self, order: m.Order) -> None:
        """Hook or unhook the sling."""
        match order.what:
            case Hookup(lug=lug, p=p):
                self.say(m.Hook(self.element, b=p), m.Hooked(self.element, lug))
            case UnhookSling():
                self.say(m.Unhook(self.element), m.Unhooked(self.element))
            case _:
                super().execute(order)
        self.say(m.Done(self.element, order.id))

    def notice(self, event: m.StateEvent) -> None:
        """Report that the sling has become taut or slack."""
        if event.what in ("taut", "slack"):
            self.say(m.RopeState(self.element, event.what, event.value))

    def output(self) -> None:
        """Send the sling's reports and kernel inputs, and inform the latch about hooking and unhooking."""
        super().output()
        for message in self.outbox:
            if isinstance(message, (m.Hooked, m.Unhooked)):
                self.latch.send(m.Latch(self.element, isinstance(message, m.Hooked)))


class BrakeActor(LiveActor):
    """Engages and releases the brake `element`."""

    def __init__(self, name: str, brake: str, laws: System, *, engaged: bool) -> None:
        super().__init__(name, brake, laws)
        self.initial = engaged

    def begin(self) -> None:
        """Reset the brake to its declared state."""
        self.engaged = self.initial

    def execute(self, order: m.Order) -> None:
        """Engage or release the brake."""
        if not isinstance(order.what, BrakeOrder):
            super().execute(order)
        else:
            self.set(order.what.engaged)
            self.say(m.Done(self.element, order.id))

    def set(self, engaged: bool) -> None:
        """Engage or release the brake and report this, unless the brake is in this state already."""
        if engaged != self.engaged:
            self.engaged = engaged
            if self.laws != System():  # a joint that is not modelled needs no brake
                self.say(self.command(engaged))
            self.say(m.BrakeState(self.element, engaged))

    def command(self, engaged: bool) -> m.KernelInput:
        """Return the kernel input that engages or releases the brake."""
        return m.SetBrake(self.element, engaged)


class JointLockActor(BrakeActor):
    """Locks and releases a joint; the kernel reports the energy that is lost when the joint is locked in motion."""

    def __init__(self, name: str, lock: str, laws: System, *, engaged: bool) -> None:
        super().__init__(name, lock, laws, engaged=engaged)
        self.hears = frozenset((lock,))

    def command(self, engaged: bool) -> m.KernelInput:
        """Return the kernel input that locks or releases the joint."""
        return m.SetLock(self.element, engaged)


class LatchActor(BrakeActor):
    """Actor of a brake that an order engages, and that is also engaged while no sling of its frame is hooked."""

    latch = In(m.Latch)

    def __init__(self, name: str, brake: str, laws: System, *, hooked: frozenset[str]) -> None:
        super().__init__(name, brake, laws, engaged=not hooked)
        self.first = hooked

    def begin(self) -> None:
        """Reset the latch to its declared state and to the slings hooked at the start."""
        super().begin()
        self.hooked = self.first

    def external(self, e: int, x: Bag) -> None:
        """Process hooked and unhooked slings first, then orders."""
        for latch in x.get(self.latch, []):
            self.hooked = self.hooked | {latch.sling} if latch.hooked else self.hooked - {latch.sling}
        if self.latch in x:
            self.set(not self.hooked)
        super().external(e, x)


class BlockSupports(LiveActor):
    """Actor of the supports of the body `element`: reports lift-off, first touch and landing of each face."""

    def __init__(
        self, name: str, element: str, laws: System, *, faces: Mapping[str, str], closed: frozenset[str]
    ) -> None:
        super().__init__(name, element, laws, hears=tuple(faces))
        self.first, self.faces = closed, dict(faces)

    def begin(self) -> None:
        """Reset the supports to their declared state."""
        self.closed = self.first

    def notice(self, event: m.StateEvent) -> None:
        """Update the supports that are in contact; report first touch, landing or lift-off of the body."""
        before = self.closed
        if event.what == "closed":
            self.closed = before | {event.name}
            if not before:
                self.say(m.Touched(self.element, event.name))
            face = self.faces[event.name]
            if self.standing() == face and before != self.closed:
                self.say(m.Landed(self.element, face))
        elif event.what == "open":
            self.closed = before - {event.name}
            if before and not self.closed:
                self.say(m.Lifted(self.element))

    def standing(self) -> str:
        """Return the face of the body at which all supports are in contact, or "" if there is none."""
        for face in dict.fromkeys(self.faces.values()):
            if all(name in self.closed for name, f in self.faces.items() if f == face):
                return face
        return ""
