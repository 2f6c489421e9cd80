"""Fenders as one machine: massless faces on a quay or a vessel, against which points of vessels lean; beside its face a
fender exerts no force."""

from math import sqrt

from heavylift.kernel.algebra.dense import cross, norm, product
from heavylift.kernel.description.mechanics import WORLD, Body, Joint, Matrix, Point, Support, System, Vector, merge
from heavylift.nodes.plan import plan
from heavylift.nodes.scene.construction.scene_builder import SceneBuilder
from heavylift.nodes.scene.keys.environment import Fender
from heavylift.nodes.scene.keys.parts import kinematics
from heavylift.nodes.scene.text.faults import closest

FENDERS = "fenders"
EDGE = 1e-6  # [m]
THICKEST = 2.0  # [m] to which a fender without a capacity yields: large pneumatic ones (ISO 17357) by 60 % of 3.3 m


def fenders_machine(builder: SceneBuilder, around: System) -> plan.Mechanism:
    """Return all fenders of a scene as one machine; errors are added to the scene."""
    scene, source = builder.scene, builder.source
    vessels = list(scene.vessels)
    for name, given in scene.fenders.items():
        for key, word, known in (("on", given.on, [WORLD, *vessels]), ("vessel", given.vessel, vessels)):
            if word not in known or (key == "vessel" and word == given.on):
                message = f"there is no vessel '{word}'" if word not in known else "a vessel cannot lean on itself"
                source.fault((FENDERS, name, key), message, closest(word, [x for x in known if x != given.on]))
        if not norm(given.facing):
            source.fault((FENDERS, name, "facing"), "the direction has no length")
    if source.faults:
        return plan.Mechanism(name=FENDERS, system=System())
    made = System(
        tuple(Body(f"{name}.face", 0.0) for name in scene.fenders),
        tuple(Joint(f"{name}.foot", "fixed", x.on, f"{name}.face", p_PJ=x.at, R_PJ=facing(x.facing))
              for name, x in scene.fenders.items()),
        supports=tuple(_support(name, x) for name, x in scene.fenders.items()), gravity=scene.gravity,
    )  # fmt: skip
    at = kinematics.poses(merge([around, made], scene.gravity))
    closed = []
    for support in made.supports:
        R, p = at[support.on][1], at[support.on][0]
        r = (p - kinematics.place(support.point, at)).tolist()
        *beside, depth = product(R.T.tolist(), r)
        name, given = support.name, scene.fenders[support.name]
        over = max((abs(w) - size / 2 for w, size in zip(beside, given.size or (), strict=False)), default=-THICKEST)
        if abs(over) < EDGE:
            message = f"'{given.vessel}' begins at the edge of the face, so it is open whether they meet"
            source.fault((FENDERS, name, "size"), message, "give a larger face, or move one of them")
        if over > 0.0:
            continue
        most = given.capacity / given.stiffness if given.capacity else THICKEST
        if depth > most:
            message = (
                f"'{given.vessel}' begins {depth:.3g} m behind the face, and the fender yields by {most:.3g} m only"
            )
            source.fault((FENDERS, name), f"{message}: move one of them", on_key=True)
        if depth > 0.0:
            closed.append(name)
    return plan.Mechanism(name=FENDERS, system=made, closed=tuple(closed), where=source.where((FENDERS,)))


def _support(name: str, x: Fender) -> Support:
    """Return the law of a fender: its face is the level up to which it pushes."""
    rubs = (x.stiffness, x.damping) if x.friction else (0.0, 0.0)
    return Support(
        name, Point(x.vessel, x.meets), 0.0, x.stiffness, x.damping, x.friction, *rubs, f"{name}.face", x.size
    )


def facing(direction: Vector) -> Matrix:
    """Return the rotation matrix of a frame whose z axis points in a given direction."""
    n = [x / norm(direction) for x in direction]
    side = cross([0.0, 0.0, 1.0] if abs(n[2]) < sqrt(0.5) else [1.0, 0.0, 0.0], n)
    x = [a / norm(side) for a in side]
    y = cross(n, x)
    a, b, c = ((x[i], y[i], n[i]) for i in range(3))
    return a, b, c
