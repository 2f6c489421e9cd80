"""What each kernel input does to a simulation."""

from __future__ import annotations

from typing import Any

from heavylift.kernel.errors import ModelError

from . import messages as m

__all__ = ["obey"]


def obey(simulation: Any, x: object) -> None:
    """Give a kernel input to whatever has the commands of a `Simulation`; raises KernelError if it cannot obey."""
    match x:
        case m.SetProfile():
            simulation.set_profile(x.actuator, x.start_ns, x.speed, x.accel, x.distance)
        case m.SetFollow():
            simulation.set_follow(x.actuator, x.master, (x.k1, x.kc, x.ks))
        case m.SetBrake():
            simulation.set_brake(x.brake, x.engaged)
        case m.SetLock():
            simulation.set_lock(x.lock, x.engaged)
        case m.Hook():
            simulation.hook(x.rope, x.a, x.b, x.L0)
        case m.Unhook():
            simulation.unhook(x.rope)
        case m.Watch():
            simulation.watch(x.threshold, x.value, x.rising)
        case m.Unwatch():
            simulation.unwatch(x.threshold)
        case _:
            raise ModelError(f"the kernel has no use for a {type(x).__name__}")
