"""Random mechanisms of all joint kinds, and the same mechanisms built in Pinocchio."""

import numpy as np
import pinocchio as pin
from heavylift.kernel.description import WORLD, Body, Joint, System
from heavylift.kernel.multibody import Graph
from scipy.linalg import block_diag
from scipy.spatial.transform import Rotation

KINDS = (
    "fixed",
    "revolute",
    "prismatic",
    "cylindrical",
    "screw",
    "universal",
    "planar",
    "spherical",
    "free",
)  # those whose velocities are Pinocchio's, fmt: skip
GRAVITY = 9.80665


def rotation(random: np.random.Generator) -> np.ndarray:
    return Rotation.random(random_state=int(random.integers(2**31))).as_matrix()


def nested(x: np.ndarray) -> tuple:
    return tuple(tuple(map(float, row)) if np.ndim(row) else float(row) for row in x)


def parents(random: np.random.Generator, n: int) -> list[int]:
    """Parents before children; about every fifth body stands on the ground."""
    return [-1 if i == 0 or random.random() < 0.2 else int(random.integers(i)) for i in range(n)]


def random_system(
    seed: int, n: int = 9, decades: float = 4.0, floating: bool = False, kinds: tuple[str, ...] = KINDS
) -> System:
    """Several trees; masses over some decades, full inertias, centres of mass off the joints, frames askew.

    Free joints stand on the ground unless `floating`: a body that floats on a lighter one is badly conditioned.
    """
    random = np.random.default_rng(seed)
    bodies, joints = [], []
    for i, p in enumerate(parents(random, n)):
        mass = float(10.0 ** random.uniform(2.0, 2.0 + decades))
        R, size = rotation(random), 10.0 ** random.uniform(-0.5, 0.5)
        a, b, c = np.sort(random.uniform(0.5, 1.0, 3)) * mass * size**2
        inertia = R @ np.diag([a, b, min(c, 0.99 * (a + b))]) @ R.T
        bodies.append(Body(f"b{i}", mass, nested(random.normal(size=3)), nested((inertia + inertia.T) / 2)))
        axis = random.normal(size=3)
        second = np.cross(axis, random.normal(size=3))
        possible = [k for k in kinds if floating or p < 0 or k != "free"]
        kind = possible[int(random.integers(len(possible)))] if i else "free"  # something always moves
        joints.append(
            Joint(
                f"j{i}",
                kind,
                WORLD if p < 0 else f"b{p}",
                f"b{i}",
                nested(random.normal(scale=3.0, size=3)),
                nested(rotation(random)),
                nested(axis / np.linalg.norm(axis)),
                nested(second / np.linalg.norm(second)),
                pitch=float(random.normal()) if kind == "screw" else 0.0,
            )
        )
    random.shuffle(bodies)
    random.shuffle(joints)
    return System(tuple(bodies), tuple(joints), gravity=GRAVITY)


def random_state(graph: Graph, seed: int) -> tuple[np.ndarray, np.ndarray]:
    """Coordinates (unit quaternions) and velocities of order one."""
    random = np.random.default_rng(seed)
    q = random.normal(size=graph.nq)
    for link in graph.links:
        start = {"spherical": 0, "free": 3}.get(link.joint.kind)
        if start is not None:
            at = slice(link.q.start + start, link.q.stop)
            q[at] /= np.linalg.norm(q[at])
    return q, random.normal(size=graph.nv)


def pinocchio_joints(joint: Joint) -> list:
    """A joint as one of Pinocchio's or as a chain of those; the turns of a constant-velocity joint are coupled."""
    axis, second = np.array(joint.axis), np.array(joint.second)
    turn, slide = pin.JointModelRevoluteUnaligned, pin.JointModelPrismaticUnaligned
    return {
        "fixed": lambda: [],
        "revolute": lambda: [turn(axis)],
        "prismatic": lambda: [slide(axis)],
        "cylindrical": lambda: [slide(axis), turn(axis)],
        "screw": lambda: [pin.JointModelHelicalUnaligned(axis, joint.pitch)],
        "universal": lambda: [turn(axis), turn(second)],
        "constant-velocity": lambda: [turn(second), turn(np.cross(axis, second)), turn(second)],
        "planar": lambda: [slide(second), slide(np.cross(axis, second)), turn(axis)],
        "spherical": lambda: [pin.JointModelSpherical()],
        "free": lambda: [pin.JointModelFreeFlyer()],
    }[joint.kind]()


def pinocchio_model(graph: Graph, gravity: float = GRAVITY) -> pin.Model:
    """Joints in the order of the graph's links, so that q and v are the kernel's own."""
    model = pin.Model()
    model.gravity.linear = np.array([0.0, 0.0, -gravity])
    carried: list[tuple[int, pin.SE3]] = []  # moving joint and place on it, per link
    for link in graph.links:
        joint, body = link.joint, link.body
        on, place = (0, pin.SE3.Identity()) if link.parent < 0 else carried[link.parent]
        place = place * pin.SE3(np.array(joint.R_PJ), np.array(joint.p_PJ))
        for made in pinocchio_joints(joint):
            on, place = model.addJoint(on, made, place, f"{joint.name}.{model.njoints}"), pin.SE3.Identity()
        inertia = pin.Inertia(body.mass, np.array(body.com), np.array(body.inertia))
        model.appendBodyToJoint(on, inertia, place)
        carried.append((on, place))
    return model


def turns_of(graph: Graph) -> np.ndarray:
    """(n_pinocchio, nv) what Pinocchio's velocities are: the kernel's, where constant-velocity joints couple turns."""
    blocks = [
        np.array([[1.0, 0.0], [0.0, 2.0], [1.0, 0.0]])
        if link.joint.kind == "constant-velocity"
        else np.eye(link.v.stop - link.v.start)
        for link in graph.links
    ]
    return block_diag(*[b for b in blocks if b.size])


def pinocchio_coordinates(graph: Graph, q: np.ndarray) -> np.ndarray:
    """(n_pinocchio,) the kernel's coordinates, with the three turns of each constant-velocity joint."""
    return np.concatenate(
        [
            q[link.q] @ np.array([[1.0, 0.0, 1.0], [0.0, 2.0, 0.0]])
            if link.joint.kind == "constant-velocity"
            else q[link.q]
            for link in graph.links
        ]
    )
