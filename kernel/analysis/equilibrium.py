"""Static equilibrium with one-sided laws: where nothing accelerates, and which ropes and pads then carry.

Pseudo-transient continuation (Kelley, Keyes 1998): steps (1/h^2 - da/dq)^-1 a in the metric of the inertia; small h
falls with gravity and friction, large h is Newton's method.  Between steps the laws whose guards have fallen switch,
as at events, until the active set stays.  Neutral directions, such as the travel of a crane, stay where they are.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from ..bending import check_bending
from ..errors import KernelError
from ..samples import channels, published
from .linearise import stiffness
from .poses import Poses

if TYPE_CHECKING:
    from ..simulation import Simulation

__all__ = ["Equilibrium", "equilibrium"]

STILL = 1e-9  # [m/s2, rad/s2] acceleration that counts as none
ROUNDING = 1e-6  # [m/s2, rad/s2] below which an acceleration that no longer falls is rounding of stiff laws
NEAR = 1e-10  # [m, rad] a Newton step behind which there is only the rounding of stiff laws on light bodies
LONGEST = 0.3  # [m, rad] a step
MOST = 300  # steps
RELAXED = 1.0  # [s] of pseudo time from which a step is Newton's
SHORT, LONG = 0.1, 100.0  # [s] of pseudo time; LONG leaves neutral directions alone
SETTLED = 20  # rounds of switching at one pose after which laws contradict each other


@dataclass(frozen=True)
class Equilibrium:
    """A pose at rest: coordinates q (nq,), tension per rope and normal force per support [N], steps needed."""

    q: np.ndarray
    tensions: dict[str, float]
    supports: dict[str, float]
    steps: int


def equilibrium(simulation: Simulation) -> Equilibrium:
    """Bring a started simulation to the equilibrium that it falls into from where it is; its drives are stopped.

    Raises KernelError, naming the body that finds no rest.
    """
    poses = Poses(simulation)
    q, h, before, last, stalled = poses.q, SHORT, np.inf, np.inf, 0
    for steps in range(MOST):
        switched = _switch(poses, q)
        a = poses.accelerations(q)
        size = float(np.abs(a).max(initial=0.0))
        if not np.isfinite(size):
            break
        stalled = stalled + 1 if size > 0.5 * before and size < ROUNDING else 0
        if not switched and (size <= STILL or last <= NEAR or stalled >= 3):
            check_bending(simulation)
            return Equilibrium(q, _shown(simulation, "tension"), _shown(simulation, "support/force"), steps)
        h = min(LONG, max(SHORT, h * min(10.0, max(0.2, before / size if size else 10.0))))
        before = size
        basis = poses.basis(q)
        way, h = _step(stiffness(poses, q, basis), basis.T @ a, h)
        step = basis @ way
        last = float(np.abs(step).max(initial=0.0)) if h > RELAXED else np.inf
        q = poses.moved(q, step * min(1.0, LONGEST / float(np.abs(step).max(initial=LONGEST))))
        poses.count_turns(q)
    raise _restless(poses, q)


def _shown(simulation: Simulation, topic: str) -> dict[str, float]:
    """What samples show under topics of this ending, by name."""
    method = simulation.method
    values = published(method, np.array(method.row_layout.pack(simulation.row()))[None])[0]
    shown = [c for c in channels(method) if c.topic.endswith(topic)]
    return {name: float(x) for c in shown for name, x in zip(c.names, values[c.start : c.stop], strict=True)}


def _step(K: np.ndarray, a: np.ndarray, h: float) -> tuple[np.ndarray, float]:
    """A step that goes with the acceleration; h [s] shrinks where the pose is unstable."""
    while True:
        step = np.linalg.solve(np.eye(len(a)) / h**2 - K, a)
        if step @ a >= 0.0 or h <= SHORT:
            return step, h
        h = max(SHORT, 0.25 * h)


def _switch(poses: Poses, q: np.ndarray) -> bool:
    """Switch every law whose guard has fallen; friction that slips holds on at its limit, since nothing moves."""
    simulation = poses.simulation
    kinds = [kind for kind, _ in simulation.program.guards]
    any_switched = False
    for _ in range(SETTLED):
        poses.accelerations(q)
        fallen = [i for i in np.flatnonzero(poses.guards() < 0.0) if kinds[i] not in ("threshold", "bending")]
        if not fallen:
            break
        any_switched = True
        switched = simulation._switch([int(i) for i in fallen], simulation.epoch)
        slipped = {e.name for e in switched if e.what == "slip"}
        for i in fallen:
            if kinds[i] in ("rub", "brake") and simulation.program.guards[i][1] in slipped:
                simulation.switches.fire(int(i), simulation.row())
    return any_switched


def _restless(poses: Poses, q: np.ndarray) -> KernelError:
    a = np.abs(poses.accelerations(q))
    worst = int(np.argmax(np.where(np.isfinite(a), a, np.inf)))
    k = poses.free[worst]
    link = next(x for x in poses.simulation.program.graph.links if x.v.start <= k < x.v_modes.stop)
    return KernelError(
        f"body '{link.body.name}' finds no rest: joint '{link.joint.name}' still accelerates by {a[worst]:.3g} "
        "(m/s2 or rad/s2); hang it on a rope, support it, or brake its joint"
    )
