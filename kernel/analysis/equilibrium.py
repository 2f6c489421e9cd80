"""Static equilibrium with one-sided force laws: a pose without accelerations, and which ropes and pads carry load
there.

Pseudo-transient continuation (Kelley, Keyes 1998): steps (1/h^2 - da/dq)^-1 a in the metric of the inertia; with small
h the scene falls with gravity and friction, large h is Newton's method. Between steps, laws whose guards are negative
switch as at events, until the active set stays the same. Neutral directions, such as the travel of a crane, keep their
position.

Discrete states at rest: which one-sided laws act, and how far dry friction has slid.

Ropes, pads and stops switch as at events. Friction loaded beyond its limit slides and draws the anchor of its spring
along until the spring relaxes; then it holds at its new place (return mapping of perfect plasticity; Simo, Hughes,
Computational Inelasticity, 1998, 1.4).
"""

from __future__ import annotations

from dataclasses import dataclass
from math import sqrt
from typing import TYPE_CHECKING

import numpy as np
from heavylift.kernel.description.findings import RESTLESS
from heavylift.kernel.errors import KernelError
from heavylift.kernel.forces.joint_laws import BrakeAt, SupportAt
from heavylift.kernel.model.switching import StateChange
from heavylift.kernel.model.tangent_stiffness import SECOND
from heavylift.kernel.simulation.native.samples import channels, published
from heavylift.kernel.simulation.safeguards.deflection_check import check_bending

from .poses import SMALLEST, STEP, Poses

if TYPE_CHECKING:
    from heavylift.kernel.simulation.simulation import Simulation

RUBS = ("rub", "brake")  # kinds of guards that watch dry friction
SLIDING = {
    "rub": (SupportAt.CLOSED, SupportAt.STICK, SupportAt.KT),
    "brake": (BrakeAt.ENGAGED, BrakeAt.STICK, BrakeAt.K),
}
SETTLED = 20  # rounds of switching at one pose after which laws contradict each other
OPPOSITE = {"taut": "slack", "closed": "open", "stick": "slip", "locked": "freed"}


def switch(poses: Poses, q: np.ndarray, thresholds: bool = False) -> list[StateChange]:
    """Switch the force laws whose guards (event functions) are negative at pose q (nq,); return the changes.

    Repeated until no guard is negative. If `thresholds`, switch armed thresholds of signals, too.
    """
    simulation = poses.simulation
    guards = simulation.program.guards
    happened: list[StateChange] = []
    for _ in range(SETTLED):
        poses.accelerations(q)
        fallen = [int(i) for i in np.flatnonzero(poses.guards() < 0.0)]
        # bending is a check of validity and thresholds are signals: neither changes the forces
        fallen = [i for i in fallen if guards[i][0] != "bending" and (thresholds or guards[i][0] != "threshold")]
        if not fallen:
            break
        # friction switches by its spring's direction, not by velocities, which statics does not have
        others = [i for i in fallen if guards[i][0] not in RUBS]
        happened += [_rub(simulation, *guards[i]) for i in fallen if guards[i][0] in RUBS]
        happened += simulation.events.switch(others, simulation.epoch) if others else []
    return happened


def _rub(simulation: Simulation, kind: str, name: str) -> StateChange:
    """Toggle a friction law: from holding to slipping in the direction of its force, or back to holding."""
    program, row = simulation.program, simulation.row()
    law = program.of_guard[kind, name]
    shown, p = program.shown(law, row), simulation.P[program.parameters.at[law.law.kind, name]]
    at: type[SupportAt] | type[BrakeAt]
    if kind == "rub":
        at, distance, value = SupportAt, shown[1:3] - p[SupportAt.ANCHOR], float(shown[0])
        direction = distance / max(_length(distance), 1e-300)
    else:
        at, value, direction = BrakeAt, float(shown[0]), np.sign(shown[0] - p[BrakeAt.ANCHOR])
    slips = p[at.STICK] > 0.0
    p[at.STICK], p[at.DIRECTION] = float(not slips), direction
    return StateChange(name, "slip" if slips else "stick", 0.0 if slips and kind == "brake" else value)


def release(simulation: Simulation) -> float:
    """Move the anchors of slipping friction springs until friction holds the spring forces (radial return).

    Return the longest slide of a pad [m]; each slide is taken to be straight, in its final direction.
    """
    slid, row = 0.0, None
    program = simulation.program
    for kind, law in ((kind, x) for (kind, _), x in program.of_guard.items() if kind in RUBS):
        p = simulation.P[program.parameters.at[law.law.kind, law.name]]
        acts, sticks, stiff = SLIDING[kind]
        if not (p[acts] > 0.0 and p[sticks] <= 0.0 and p[stiff] > 0.0):
            continue
        row = row or simulation.row()
        shown = program.shown(law, row)
        if kind == "rub":
            place, limit = shown[1:3], p[SupportAt.MU] * shown[0]
            distance = place - p[SupportAt.ANCHOR]
            # the anchor follows until the spring carries the limit (radial return)
            anchor = place - limit / p[SupportAt.KT] / max(_length(distance), 1e-300) * distance
            slid = max(slid, _length(anchor - p[SupportAt.ANCHOR]))
            p[SupportAt.ANCHOR] = anchor
        else:
            q = shown[0]
            p[BrakeAt.ANCHOR] = q - p[BrakeAt.MOMENT] / p[BrakeAt.K] * np.sign(q - p[BrakeAt.ANCHOR])
    return slid


def net(events: list[StateChange]) -> list[StateChange]:
    """Return the net changes of state: the last change of each force law that did not return to its first state."""
    last: dict[tuple[str, str], StateChange] = {}
    odd: dict[tuple[str, str], bool] = {}
    pairs = {two: one for one, two in OPPOSITE.items()}
    for e in events:
        key = e.name, pairs.get(e.what, e.what)
        # a law that switched there and back has not changed
        last[key] = e
        odd[key] = not odd.get(key, False) or e.what not in {*OPPOSITE, *pairs}
    return [e for key, e in last.items() if odd[key]]


def _length(way: np.ndarray) -> float:
    return sqrt(float(way[0] * way[0] + way[1] * way[1]))


STILL = 1e-9  # [m/s2, rad/s2] acceleration that counts as none
ROUNDING = 1e-6  # [m/s2, rad/s2] below which an acceleration that no longer falls is rounding of stiff laws
NEAR = 1e-10  # [m, rad] a Newton step behind which there is only the rounding of stiff laws on light bodies
LONGEST = 0.3  # [m, rad] a step
MOST, MORE = 300, 150  # steps; halves of steps behind them, for two poses may lead to each other
SHORTER = 25  # steps behind which they are halved once more
# steps behind which a stiffness is looked for on a small scale: sliding friction of a pad that carries a few newtons
# turns its direction within the deflection of its spring, which is less than a micrometre
FINE = 100
ONWARD = 0.9  # cosine between late steps that go on in one direction: what slides far slides in long steps
RELAXED = 1.0  # [s] of pseudo time from which a step is Newton's
SHORT, LONG = 0.1, 100.0  # [s] of pseudo time; LONG leaves neutral directions alone


@dataclass(frozen=True)
class Equilibrium:
    """A pose at rest: coordinates q (nq,), rope tensions and support forces [N], and number of iterations needed."""

    q: np.ndarray
    tensions: dict[str, float]
    supports: dict[str, float]
    steps: int


def equilibrium(simulation: Simulation) -> Equilibrium:
    """Stop the drives of a started simulation and move it to the equilibrium into which it settles.

    Raises KernelError, naming the body that does not come to rest.
    """
    poses = Poses.stopped(simulation)
    q, steps, _ = relaxed(poses, poses.q)
    return equilibrium_at(simulation, q, steps)


def equilibrium_at(simulation: Simulation, q: np.ndarray, steps: int) -> Equilibrium:
    """Return the equilibrium of a simulation at rest at q (nq,), with rope tensions and support forces."""
    return Equilibrium(q, _shown(simulation, "tension"), _shown(simulation, "support/force"), steps)


def relaxed(poses: Poses, q: np.ndarray) -> tuple[np.ndarray, int, list[StateChange]]:
    """Return the pose at rest (nq,) reached from q, the number of iterations, and the state changes of force laws.

    Raises KernelError naming a body that does not come to rest.
    """
    h, before, last, stalled, onward, way = SHORT, np.inf, np.inf, 0, False, np.zeros(len(poses.free))
    events: list[StateChange] = []
    for steps in range(MOST + MORE):
        switched = switch(poses, q)
        events += switched
        a = poses.accelerations(q)
        size = float(np.abs(a).max(initial=0.0))
        if not np.isfinite(size):
            break
        # accelerations that no longer fall although small: rounding
        stalled = stalled + 1 if size > 0.5 * before and size < ROUNDING else 0
        if not switched and (size <= STILL or last <= NEAR or stalled >= 3):
            check_bending(poses.simulation.native)
            return q, steps, events
        # switched evolution relaxation: the pseudo time step grows as the residual falls
        grown = min(10.0, max(0.2, before / size if size else 10.0))
        h = min(LONG, max(SHORT, h * (2.0 if onward else grown)))
        before = size
        K = poses.stiffness(q, SECOND, STEP if steps < FINE else SMALLEST)
        step, h = _step(poses, poses.basis(q), K, a, h)
        last = float(np.abs(step).max(initial=0.0)) if h > RELAXED else np.inf
        onward, way = steps > FINE and _along(step, way) > ONWARD, step
        # full steps may alternate between two poses: late ones go half as far, and less where halves do not help
        part = 1.0 if steps < MOST else 0.5 ** (1 + (steps - MOST) // SHORTER)
        q = poses.moved(q, step * min(part, LONGEST / float(np.abs(step).max(initial=LONGEST))))
        poses.count_turns(q)
    raise _restless(poses, q)


def _shown(simulation: Simulation, topic: str) -> dict[str, float]:
    """Return the sampled values of all channels whose topic ends with `topic`, by name."""
    method = simulation.method
    values = published(method, np.array(method.row_layout.pack(simulation.row()))[None])[0]
    shown = [c for c in channels(method) if c.topic.endswith(topic)]
    return {name: float(x) for c in shown for name, x in zip(c.names, values[c.start : c.stop], strict=True)}


def _step(poses: Poses, basis: np.ndarray | None, K: np.ndarray, a: np.ndarray, h: float) -> tuple[np.ndarray, float]:
    """Return the step (n_free,) for the accelerations a, and its pseudo-time step h [s], reduced where unstable."""
    while True:
        poses.factorise(K, h, basis)
        step = poses.solve(a)
        # against the acceleration means an unstable direction: shorten towards a gradient step
        if np.cumsum(step * a)[-1] >= 0.0 or h <= SHORT:
            return step, h
        h = max(SHORT, 0.25 * h)


def _along(a: np.ndarray, b: np.ndarray) -> float:
    """Return the cosine of the angle between two steps; 0 if one of them is zero."""
    products = [float(np.cumsum(x)[-1]) if len(x) else 0.0 for x in (a * b, a * a, b * b)]
    return products[0] / sqrt(products[1] * products[2]) if products[1] * products[2] > 0.0 else 0.0


def _restless(poses: Poses, q: np.ndarray) -> KernelError:
    a = np.abs(poses.accelerations(q))
    worst = int(np.argmax(np.where(np.isfinite(a), a, np.inf)))
    k = poses.free[worst]
    link = next(x for x in poses.simulation.program.graph.links if x.v.start <= k < x.v_modes.stop)
    return KernelError(
        f"body '{link.body.name}' {RESTLESS}: joint '{link.joint.name}' still accelerates by {a[worst]:.3g} "
        "(m/s2 or rad/s2); hang it on a rope, support it, or brake its joint"
    )
