"""Random mechanisms with everything at once: all kinds of joints and loops, elastic and rigid ropes, springs."""

from dataclasses import replace

import numpy as np
from heavylift.kernel import KernelError
from heavylift.kernel.description import JOINTS, WORLD, JointSpring, Line, Point, RigidRope, Rope, System
from heavylift.kernel.simulation import Simulation
from linkages import looped, poses
from random_trees import KINDS
from small_scenes import SECOND, imbalance

LOOPS = (
    "fixed",
    "revolute",
    "prismatic",
    "cylindrical",
    "screw",
    "universal",
    "planar",
    "spherical",
    "constant-velocity",
)
CLOSES = 1e-6  # of the energy that is turned over, at a tolerance of 1e-9
SPRUNG = 30.0  # rad/s of a spring under its body, so that no spring is stiffer than its scene is long


def mechanism(seed: int, decades: float) -> System:
    """Three to six bodies with masses over some decades, at a random pose in motion, with up to two loops."""
    random = np.random.default_rng(seed)
    n = int(random.integers(3, 7))
    loops = tuple(str(kind) for kind in random.choice(LOOPS, int(random.integers(0, 3))))
    system, _, _ = looped(seed, loops, n, decades, (*KINDS, "constant-velocity"))
    at, masses = poses(replace(system, joints=system.joints[:n])), {b.name: b.mass for b in system.bodies}
    springs, ropes, rigid = [], [], []
    for j in system.joints[:n]:
        stiffness = float(masses[j.child] * SPRUNG**2)
        for c in JOINTS[j.kind].actable[:1]:
            springs.append(JointSpring(f"s-{j.name}", j.name, stiffness, 0.1 * stiffness / SPRUNG, coordinate=c))
    for name, mass in masses.items():
        p, _ = at[name]
        sky = p + random.normal(size=3) + (0.0, 0.0, 10.0)
        distance = float(np.linalg.norm(sky - p))
        line = (Line(Point(WORLD, tuple(sky.tolist())), Point(name)),)
        match random.integers(4):
            case 0:
                length = distance * float(random.uniform(0.98, 1.05))
                ropes.append(Rope(f"rope-{name}", line, mass * SPRUNG**2 * 10.0, length, damping=mass))
            case 1:
                rigid.append(RigidRope(f"rigid-{name}", line, distance * float(random.uniform(1.0, 1.02)) + 1e-3))
    return replace(system, springs=tuple(springs), ropes=tuple(ropes), rigid_ropes=tuple(rigid))


def has_loops(system: System) -> bool:
    return any(j.name.startswith("loop") for j in system.joints)


class Enough(Exception):
    """A run has taken all attempts that it was given."""


def outcome(system: System, t_ns: int = SECOND // 5, batches: int = 8) -> tuple[str, float]:
    """The sentence of a refusal, or "" and how well the energy of the run closes; fails for numbers without end.

    A stiff scene is left after so many batches of 4000 attempts, with the samples that it has made by then.
    """
    left = batches

    def pause() -> None:
        nonlocal left
        left -= 1
        if not left:
            raise Enough

    try:
        s = Simulation(system, tolerance=1e-9, sample_ns=t_ns // 10, opt=0, cache=False)
        s.start()
        try:
            s.run(t_ns, pause)
            s.interrupt(t_ns)
            s.settle()
        except Enough:
            pass
    except KernelError as error:
        return str(error), 0.0
    assert np.isfinite(s.state).all()
    return "", imbalance(s) if s.rows[-1][0] > 0 else 0.0
