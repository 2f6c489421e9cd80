"""Random trees with one flexible body: a beam that bends, stretches and twists between rigid bodies."""

import numpy as np
from heavylift.kernel.description import WORLD, Beam, Body, Flexible, Joint, System
from random_trees import nested, rotation

FRAMES = ("clamped", "simply supported", "free")


def beam(random: np.random.Generator, **options) -> Beam:
    """A few metres and tonnes, soft enough to bend visibly."""
    EI_y, EI_z, EA, GJ = random.uniform(1e5, 1e6, 4)
    return Beam(float(random.uniform(2.0, 5.0)), 300.0, EI_y, EI_z, 1e2 * EA, GJ, 30.0, elements=12, **options)


def rigid(random: np.random.Generator, name: str) -> Body:
    mass = float(random.uniform(100.0, 1000.0))
    R = rotation(random)
    inertia = R @ np.diag(random.uniform(0.6, 1.0, 3) * mass) @ R.T
    return Body(name, mass, nested(random.normal(size=3)), nested((inertia + inertia.T) / 2))


def flexible_tree(
    seed: int, kinds=("revolute", "prismatic"), root: str = "", modes: int = 5, slider: bool = False
) -> System:
    """A chain: rigid body, flexible body; on it two rigid ones at stations, and another one on one of these.

    `root`: kind of the first joint, else random as the others; `slider`: the first of the two slides along the beam.
    """
    random = np.random.default_rng(seed)
    flexible = Flexible(modes, beam(random), frame=FRAMES[seed % 3])
    bodies = [rigid(random, "a"), Body("flex", 50.0, flexible=flexible), *(rigid(random, n) for n in "cde")]
    length = flexible.beam.length
    parents = (WORLD, "a", "flex", "flex", "c")
    joints = []
    for i, (body, parent) in enumerate(zip(bodies, parents, strict=True)):
        axis = random.normal(size=3)
        p = random.normal(size=3)
        if parent == "flex":
            p[0] = random.uniform(0.0, length)
        kind = root if root and not i else kinds[int(random.integers(len(kinds)))]
        if slider and body.name == "c":
            kind = "slider"
        joint = Joint(f"j{body.name}", kind, parent, body.name, nested(p), nested(rotation(random)))
        joints.append(Joint(**{**joint.__dict__, "axis": nested(axis / np.linalg.norm(axis))}))
    return System(tuple(bodies), tuple(joints))
