"""Forces held between two solvers: what happens when the ends of one rope live in two processes that exchange forces.

Two bodies on one elastic rope, each integrated by a kernel of its own; every h seconds they tell each other where they
are, and the rope's force of that instant is held until the next.  Each solver is exact, yet the pair makes energy:
x'' = -w^2 x(nh) held over h has |lambda|^2 = 1 + (w h)^2 / 2, a damping ratio of -w h / 4 to first order.  That is
why bodies tied together by taut ropes are given to one kernel.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import hypot, log, pi, sqrt

from heavylift.kernel.description.forces import Load, Signal
from heavylift.kernel.description.mechanics import Body, Joint, Point, System
from heavylift.kernel.simulation.simulation import Simulation
from heavylift.nodes.fidelity.case import Case
from heavylift.nodes.plan.plan import Plan

__all__ = ["EXCHANGES", "Held", "Pair", "held", "hook_pairs"]

EXCHANGES = (0.02, 0.01, 0.005, 0.002, 0.001)  # [s]
PERIODS = 6.0  # over which amplitudes are compared
BUDGET = 0.01  # growth of an amplitude over a run that somebody may accept
STRETCH = 0.01  # [m] at the start


@dataclass(frozen=True)
class Pair:
    """Two bodies [kg] on a rope [N/m]."""

    name: str
    upper: float
    lower: float
    stiffness: float

    @property
    def omega(self) -> float:
        """Frequency of their motion against each other [rad/s]."""
        return sqrt(self.stiffness * (1.0 / self.upper + 1.0 / self.lower))


@dataclass(frozen=True)
class Held:
    """A pair with forces held over `h` [s]: damping ratio as measured and by its law, and the h [s] that would let the
    amplitude grow by 1 % over the run of the scene."""

    pair: str
    omega: float
    h: float
    measured: float
    law: float
    one_percent: float


def hook_pairs(plan: Plan, case: Case) -> list[Pair]:
    """A crane and what hangs from it on the stiffest hook of a lift: loaded, and empty."""
    hook = min(case.hooks, key=lambda h: h.soft_rope)
    rope = next(r for r in plan.rig.hook_ropes if r.name == hook.rope)
    crane = next(c for c in plan.cranes if c.name == rope.crane)

    loader = next(x for x in plan.loaders if x.name == rope.carries)
    empty = loader.upper.mass + loader.lower.mass
    k = 1.0 / hook.soft_rope
    return [
        Pair(f"{rope.name}, loaded", crane.main.mass, hook.load, k),
        Pair(f"{rope.name}, empty", crane.main.mass, empty, k),
    ]


def held(pair: Pair, h: float, lasts: float) -> Held:
    """Measure a pair whose forces are held over h [s]; `lasts`: of the scene's run [s]."""
    omega = pair.omega
    first, second = (
        _alone("upper", pair.upper, STRETCH * _part(pair)),
        _alone("lower", pair.lower, -STRETCH * (1.0 - _part(pair))),
    )
    steps = max(1, round(PERIODS * 2.0 * pi / omega / h))
    h_ns = round(h * 1e9)

    def apart() -> tuple[float, float]:
        (x1, v1), (x2, v2) = first.state[:2], second.state[:2]
        return float(x1 - x2), float(v1 - v2)

    before = hypot(apart()[0], apart()[1] / omega)
    for k in range(steps):
        for solver in (first, second):
            solver.interrupt(k * h_ns)
        pull = pair.stiffness * apart()[0]
        for solver, force in ((first, -pull), (second, pull)):
            solver.references.set_value("pull", solver.epoch, force)
            solver.settle()
    for solver in (first, second):
        solver.interrupt(steps * h_ns)
    x, v = apart()
    growth = log(hypot(x, v / omega) / before) / (steps * h)  # of the amplitude, per second
    return Held(pair.name, omega, h, -growth / omega, -omega * h / 4.0, 4.0 * log(1.0 + BUDGET) / (omega**2 * lasts))


def _part(pair: Pair) -> float:
    """Of a stretch, what the upper body moves while the centre of mass rests."""
    return pair.lower / (pair.upper + pair.lower)


def _alone(name: str, mass: float, x: float) -> Simulation:
    """A solver of one body on a rail, under a force that is told from outside."""
    pull = Load("pull", Point(name), force=(1.0, 0.0, 0.0), signal=Signal(0.0, driven=True))
    rail = Joint("rail", "prismatic", "world", name, axis=(1.0, 0.0, 0.0), q0=(x,))
    solver = Simulation(System((Body(name, mass),), (rail,), forces=(pull,), gravity=0.0))
    solver.start()
    return solver
