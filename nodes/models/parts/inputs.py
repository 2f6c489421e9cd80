"""What each kernel input does to a simulation, and what it means for a piece of a rope and for what follows."""

from __future__ import annotations

from typing import Any

from heavylift.kernel.algebra.elementary import cos, sin
from heavylift.kernel.errors import ModelError

from . import messages as m


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


def part(order: m.SetProfile | m.SetFollow, piece: str, share: float) -> m.SetProfile | m.SetFollow:
    """What a piece of a rope has to do of it."""
    if isinstance(order, m.SetFollow):
        return m.SetFollow(piece, order.master, order.k1 * share, order.kc * share, order.ks * share)
    distance = None if order.distance is None else order.distance * share
    return m.SetProfile(piece, order.start_ns, order.speed * share, order.accel * share, distance)


def value(law: m.Follow, s: float) -> float:
    """f(s) of a follower."""
    own = float(law.kc * cos(s) + law.ks * sin(s))
    return law.k1 * s + own if isinstance(law, m.FollowAngle) else own
