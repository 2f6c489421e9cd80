"""Mechanisms with loops: rows of four-bar windows, random trees with closing joints, and what is read from them."""

from dataclasses import replace

import numpy as np
from heavylift.kernel.description import WORLD, Body, Joint, System
from heavylift.kernel.model import Program, evaluate
from random_trees import nested, random_state, random_system, rotation
from scipy.spatial.transform import Rotation
from small_scenes import Y

G_A02 = 9.81


def rod(name: str, length: float = 1.0, mass: float = 1.0) -> Body:
    """A uniform thin rod along its z axis; it may turn about x and y only."""
    i = mass * length**2 / 12.0
    return Body(name, mass, (0.0, 0.0, length / 2.0), ((i, 0.0, 0.0), (0.0, i, 0.0), (0.0, 0.0, 0.0)))


def windows(n: int, theta: float = 0.0, omega: float = 1.0) -> System:
    """IFToMM A02: n + 1 uprights of 1 m on the ground, theta from the vertical, and n rods that join their tops."""
    uprights = [rod(f"upright{i}") for i in range(n + 1)]
    joints = [
        Joint(f"foot{i}", "revolute", WORLD, f"upright{i}", (float(i), 0.0, 0.0), axis=Y, q0=(theta,), v0=(omega,))
        for i in range(n + 1)
    ]
    top = (0.0, 0.0, 1.0)
    for i in range(n):
        a, b, bar = f"upright{i}", f"upright{i + 1}", f"bar{i}"
        joints.append(Joint(f"left{i}", "revolute", a, bar, top, axis=Y, q0=(np.pi / 2 - theta,), v0=(-omega,)))
        joints.append(Joint(f"right{i}", "revolute", b, bar, top, axis=Y, p_CJ=top))
    return System((*uprights, *(rod(f"bar{i}") for i in range(n))), tuple(joints), gravity=G_A02)


TREE_KINDS = ("fixed", "revolute", "prismatic", "cylindrical", "universal", "free")  # less free than a ball joint


def looped(
    seed: int, kinds: tuple[str, ...], n: int = 9, decades: float = 1.0, tree_kinds: tuple[str, ...] = TREE_KINDS
) -> tuple[System, np.ndarray, np.ndarray]:
    """A random tree at a random pose with joints of the given kinds between random bodies, closed in that pose."""
    random = np.random.default_rng(seed)
    tree = random_system(seed, n, decades, kinds=tree_kinds)
    graph = Program(tree).graph
    q, v = random_state(graph, seed + 1)
    starts = {k.joint.name: (tuple(q[k.q]), tuple(v[k.v])) for k in graph.links}
    joints = [replace(j, q0=starts[j.name][0], v0=starts[j.name][1]) for j in tree.joints]
    tree = replace(tree, joints=tuple(joints))
    at = poses(tree)
    for number, kind in enumerate(kinds):
        a, b = random.choice([WORLD, *(f"b{i}" for i in range(n))], 2, replace=False)
        p, R = random.normal(size=3), rotation(random)
        axis = random.normal(size=3)
        axis /= np.linalg.norm(axis)
        (p_A, R_A), (p_B, R_B) = at[a], at[b]
        p_C, R_C = R_B.T @ (p_A + R_A @ p - p_B), R_B.T @ R_A @ R
        second = np.cross(axis, R[0])
        second /= np.linalg.norm(second)
        pitch = 0.3 if kind == "screw" else 0.0
        ends = nested(p), nested(R), nested(axis), nested(second), pitch
        joints.append(Joint(f"loop{number}", kind, str(a), str(b), *ends, p_CJ=nested(p_C), R_CJ=nested(R_C)))
    return replace(tree, joints=tuple(joints)), q, v


def poses(system: System) -> dict[str, tuple[np.ndarray, np.ndarray]]:
    """Place and rotation of each body at the start."""
    program = Program(system)
    x = evaluate(program, 0.0, program.initial_state(), program.parameters.initial)
    rows = np.array(x.poses_and_energies()[0], dtype=float).reshape(-1, 12)
    found = {k.body.name: (r[:3], r[3:].reshape(3, 3)) for k, r in zip(program.graph.links, rows, strict=True)}
    return {WORLD: (np.zeros(3), np.eye(3)), **found}


def relative(
    a: tuple[np.ndarray, np.ndarray], b: tuple[np.ndarray, np.ndarray], joint: Joint
) -> tuple[np.ndarray, np.ndarray]:
    """Place [m] and rotation vector [rad] of the joint's frame on its child, seen from that on its parent."""
    R_A, R_B = a[1] @ np.array(joint.R_PJ), b[1] @ np.array(joint.R_CJ)
    d = b[0] + b[1] @ np.array(joint.p_CJ) - a[0] - a[1] @ np.array(joint.p_PJ)
    return R_A.T @ d, Rotation.from_matrix(R_A.T @ R_B).as_rotvec()
