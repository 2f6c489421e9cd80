"""The goliath crane: main body on rails, upper and lower trolley on sliding joints, hooks with their winches.

It executes moves through its actors, follows a turn, and reports moves done, end positions, drum empty, the
upper limit switch of each hook, and overload of hook, trolley and crane.  Rated load = capacity plus the
hook blocks, for the ropes carry both.
"""

from __future__ import annotations

from heavylift.kernel.description.mechanics import WORLD, Drive, Joint, System, Threshold, Vector
from heavylift.nodes.models.parts.chains import pieces
from heavylift.nodes.models.parts.drive import DriveActor, HeldActor
from heavylift.nodes.models.parts.fidelity_variants import modelled
from heavylift.nodes.models.parts.gauges import LoadCell
from heavylift.nodes.models.parts.girder import girder, on_girder, stiff_part
from heavylift.nodes.models.parts.parts import Actor, BodyCoupled, JointCoupled, Law, Machine, body
from heavylift.nodes.models.parts.winch import WinchActor
from heavylift.nodes.plan.fidelity import held_by
from heavylift.nodes.plan.plan import Axis, Crane, Hook, HookRope, Plan, Trolley

X: Vector = (1.0, 0.0, 0.0)
Y: Vector = (0.0, 1.0, 0.0)


class CraneModel(Machine):
    """One crane of the plan."""

    def __init__(self, plan: Plan, crane: Crane) -> None:
        super().__init__(crane.name)
        self.plan, self.crane = plan, crane
        self.ropes = {rope.hook: rope for rope in plan.rig.hook_ropes if rope.crane == crane.name}
        self.bends = plan.fidelity.girder == "elastic"
        main = f"{crane.name}.main"
        self._slide("gantry", f"{crane.name}.gantry", WORLD, main, X, crane.gantry)
        inertia = stiff_part(crane) if self.bends else crane.main
        self.take(BodyCoupled("main", body(main, inertia), Law("weight"), *self._cell(main, crane.hooks)))
        if self.bends:
            held, beam = girder(plan, crane)
            self.take(JointCoupled("girder-feet", held, Law("held")))
            self.take(BodyCoupled("girder", beam, Law("weight")))
        for trolley in (crane.upper, crane.lower):
            self._trolley(trolley, main)

    def _trolley(self, trolley: Trolley, main: str) -> None:
        name = f"{main.removesuffix('main')}{trolley.name}"
        hooks = tuple(h for h in self.crane.hooks if h.trolley == trolley.name and h.name in self.ropes)
        winches: list[Actor] = []
        for hook in hooks:
            winches.append(_winch(self.plan, hook, self.ropes[hook.name]))
            winches += self._cell(hook.rope, (hook,), f"{hook.name}-load", hook.capacity)
        cell = self._cell(name, hooks, "load", trolley.capacity) if len(hooks) > 1 else ()
        self._slide(f"{trolley.name}-slide", f"{name}-slide", main, name, Y, trolley.axis)
        self.take(BodyCoupled(trolley.name, body(name, trolley.body), Law("weight"), *winches, *cell))

    def _slide(self, name: str, element: str, parent: str, child: str, axis: Vector, motion: Axis) -> None:
        """A sliding joint with its servo; one that is locked has none."""
        at = (*self.crane.at, 0.0) if parent == WORLD else (0.0, 0.0, 0.0)
        free = Joint(element, "prismatic", parent, child, at, axis=axis, q0=(motion.start,), v0=(0.0,))
        joint = modelled(free, self.plan.fidelity)
        if self.bends and axis == Y:
            joint = on_girder(self.plan, self.crane, joint, motion.start)
        drive = Drive(f"{element}.drive", element, "servo", motion.kp, motion.kv)
        if element in self.plan.fidelity.locked:
            actor: Actor = HeldActor("drive", drive.name, held_by(self.plan.fidelity, element))
        else:
            laws = System(drives=(drive,))
            actor = DriveActor(
                "drive", drive.name, laws, start=motion.start, lower=motion.lower, upper=motion.upper,
                emergency=motion.emergency,
            )  # fmt: skip
        self.take(JointCoupled(name, joint, actor))

    def _cell(
        self, name: str, hooks: tuple[Hook, ...], cell: str = "load", capacity: float | None = None
    ) -> tuple[Actor, ...]:
        """A load cell over the ropes of some hooks, rated for what they may carry together [kg]."""
        hooks = tuple(hook for hook in hooks if hook.name in self.ropes)
        if not hooks:
            return ()
        mass = (self.crane.capacity if capacity is None else capacity) + sum(h.block_mass for h in hooks)
        return (LoadCell(cell, f"{name}.load", tuple(h.rope for h in hooks), mass * self.plan.gravity),)


def _winch(plan: Plan, hook: Hook, rope: HookRope) -> WinchActor:
    """The winch of a hook; its rope stands in the rig."""
    switch = (Threshold(f"{hook.rope}.highest", "height", point=rope.eye), hook.highest)
    return WinchActor(
        hook.name,
        hook.rope,
        start=rope.L0,
        lower=hook.shortest,
        upper=hook.drum,
        switch=switch,
        pieces=pieces(plan.fidelity, hook.rope),
        emergency=hook.emergency,
    )
