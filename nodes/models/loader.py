"""The block loader: upper body (hook block, frame) on a free joint, beam on a hinge with stops and lock.

It hooks and unhooks its slings and reports it, reports them taut and slack, its overload and its hinge
lock, which holds the beam while no sling is hooked.
"""

from __future__ import annotations

from heavylift.kernel.description.mechanics import WORLD, Brake, Joint, JointSpring, Stop, System
from heavylift.nodes.models.parts.fidelity_variants import modelled
from heavylift.nodes.models.parts.gauges import LoadCell
from heavylift.nodes.models.parts.messages import Latch
from heavylift.nodes.models.parts.parts import BodyCoupled, JointCoupled, Law, Machine, body
from heavylift.nodes.models.parts.rigging import LockActor, SlingActor
from heavylift.nodes.plan.plan import Loader, Plan

REST6 = (0.0,) * 6


class LoaderModel(Machine):
    """One loader of the plan."""

    def __init__(self, plan: Plan, loader: Loader) -> None:
        super().__init__(loader.name)
        n = loader.name
        slings = [sling for sling in plan.rig.slings if sling.loader == n]
        upper, lower = body(f"{n}.upper", loader.upper), body(f"{n}.lower", loader.lower)
        free = Joint(f"{n}.free", "free", WORLD, upper.name, q0=loader.pose, v0=REST6)
        self.take(JointCoupled("free", modelled(free, plan.fidelity), Law("free")))
        self.take(BodyCoupled("upper", upper, Law("weight")))

        between, y = (upper.name, lower.name), (0.0, 1.0, 0.0)
        hinge = Joint(f"{n}.hinge", "revolute", *between, loader.hinge, axis=y, q0=(0.0,), v0=(0.0,))
        damper = JointSpring(f"{hinge.name}.damper", hinge.name, d=loader.damping)
        ends = loader.stop_lower, loader.stop_upper
        stop = Stop(f"{hinge.name}.stop", hinge.name, *ends, loader.stop_k, loader.stop_d)
        hooked = frozenset(sling.name for sling in slings if sling.lug)
        brake = Brake(f"{hinge.name}.lock", hinge.name, loader.lock_moment, loader.lock_k, loader.lock_d, not hooked)
        held = hinge.name in plan.fidelity.locked  # then nothing acts on it
        laws = System() if held else System(brakes=(brake,))
        lock = LockActor("lock", brake.name, laws, hooked=hooked)
        others = () if held else (Law("damper", System(springs=(damper,))), Law("stop", System(stops=(stop,))))
        joint = self.take(JointCoupled("hinge", modelled(hinge, plan.fidelity), *others, lock))

        actors = [SlingActor(f"sling-{i}", sling.name) for i, sling in enumerate(slings, 1)]
        names = tuple(sling.name for sling in slings)
        cells = [LoadCell("load", f"{n}.load", names, loader.capacity_N)] if names else []
        beam = self.take(BodyCoupled("lower", lower, Law("weight"), *actors, *cells))
        into, out = joint.add_in("latch", Latch), beam.add_out("latch", Latch)
        joint.connect(into, lock.latch)
        self.connect(out, into)
        for actor in actors:
            beam.connect(actor.latch, out)
