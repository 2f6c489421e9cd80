"""Scenes of one or two bodies, and what tests read from a simulation."""

from dataclasses import replace

import numpy as np
from heavylift.kernel.description import Body, Joint, Line, Point, Rope, System
from heavylift.kernel.simulation import Simulation
from heavylift.kernel.simulation.native import channels, published

G = 9.80665
X, Y, Z = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)
SECOND = 1_000_000_000
MASS, EA, LENGTH = 4.5e5, 1.87e9, 60.0  # C07a: a block on twenty falls


def cube(mass: float, a: float = 2.0) -> tuple:
    i = mass * a * a / 6.0
    return ((i, 0.0, 0.0), (0.0, i, 0.0), (0.0, 0.0, i))


def slider(name: str = "load", mass: float = MASS, axis=Z, q0: float = 0.0, v0: float = 0.0) -> System:
    """A body on a straight guide from the world's origin."""
    joint = Joint(f"{name}-guide", "prismatic", "world", name, axis=axis, q0=(q0,), v0=(v0,))
    return System((Body(name, mass),), (joint,), gravity=G)


def hung(z: float, L0: float = LENGTH, v0: float = 0.0, **rope) -> System:
    """A load on a vertical guide under a rope from the origin; it starts at height -z."""
    line = Line(Point("world"), Point("load"))
    return replace(slider(q0=-z, v0=v0), ropes=(Rope("rope", (line,), EA, L0, **rope),))


def started(system: System, **options) -> Simulation:
    simulation = Simulation(system, **options)
    simulation.start()
    return simulation


def hand_over(simulation: Simulation, t_ns: int) -> None:
    """Up to t_ns as the kernel node goes there: events on the way, then an interrupt for commands."""
    while True:
        simulation.run(t_ns)
        if simulation.next_ns >= t_ns:
            break
        simulation.fire()
        simulation.settle()
    simulation.interrupt(t_ns)


def events(simulation: Simulation) -> list[tuple[str, str]]:
    return [(e.name, e.what) for _, e in simulation.log]


def times(simulation: Simulation, name: str, what: str) -> list[float]:
    return [t * 1e-9 for t, e in simulation.log if (e.name, e.what) == (name, what)]


def column(simulation: Simulation, topic: str) -> tuple[np.ndarray, np.ndarray]:
    """Times [s] and the columns of a channel."""
    channel = next(c for c in channels(simulation.method) if c.topic == topic)
    rows = published(simulation.method, np.array([row for _, row in simulation.rows]))
    return np.array([t for t, _ in simulation.rows]) * 1e-9, rows[:, channel.start : channel.stop]


def imbalance(simulation: Simulation) -> float:
    """Largest error of kinetic + potential + stored - work + heat, relative to the energy turned over."""
    _, e = column(simulation, "energy")
    _, accounts = column(simulation, "account")
    total = e[:, 0] + e[:, 1] + e[:, 2] - e[:, 3] + e[:, 4]
    turned_over = max(np.ptp(e[:, 0]), np.ptp(e[:, 1]), np.abs(accounts).max())
    return float(np.abs(total - total[0]).max() / turned_over)
