"""The two-crane scene with its loaders pinned to the block as loops, 36 rows of rank 30, against the same scene as a
tree of 24 degrees of freedom."""

from dataclasses import replace

import numpy as np
import pytest
from goliath import scene
from heavylift.kernel.description import WORLD, Joint, System
from heavylift.kernel.model import Program, evaluate
from heavylift.kernel.simulation import Simulation
from linkages import poses
from random_trees import nested
from scipy.spatial.transform import Rotation
from small_scenes import SECOND, column, started

AGREES = 1e-8  # of a tension
BLOCK, SPIN, DRIFT = np.array([0.0, 0.0, 20.0]), (0.010, -0.015, 0.020), (0.4, 0.3, 0.0)


def is_loader(name: str, part: str) -> bool:
    return name.startswith(part) and name.removeprefix(part).isdigit()


def pinned(tree: System) -> System:
    """Loaders that float as trees of their own, each held at the block's lugs by two balls on its hinge's axis."""
    joints = []
    place = {j.child: np.array(j.p_PJ) for j in tree.joints}
    for j in tree.joints:
        if is_loader(j.child, "low"):
            x, y, z = j.p_PJ
            for side, dx in (("left", -0.5), ("right", 0.5)):
                pin = Joint(f"{j.child}-{side}", "spherical", "block", j.child, (x + dx, y, z), p_CJ=(dx, 0.0, 0.0))
                joints.append(pin)
        elif is_loader(j.child, "up"):
            at = place[j.parent] + [0.0, 0.0, 1.0]
            v = np.array(DRIFT) + np.cross(SPIN, at)
            start = (*(BLOCK + at), 0.0, 0.0, 0.0, 1.0)
            joints.append(Joint(f"{j.child}-floats", "free", WORLD, j.child, q0=start, v0=(*v, *SPIN)))
            joints.append(Joint(j.name, j.kind, j.child, j.parent, axis=j.axis, p_CJ=(0.0, 0.0, 1.0)))
        else:
            joints.append(j)
    return replace(tree, joints=tuple(joints))


@pytest.mark.large
def test_36_redundant_constraints_do_not_change_the_rope_tensions_of_a_scene():
    whole = scene()
    tree = replace(
        whole, springs=tuple(x for x in whole.springs if not is_loader(x.joint.removesuffix("-joint"), "low"))
    )
    tensions = []
    for system in (tree, pinned(tree)):
        s = started(system, tolerance=1e-10, sample_ns=SECOND // 10)
        s.run(SECOND)
        tensions.append(column(s, "rope/tension")[1][:10])
    assert len(s.program.constraints) == 36
    assert np.isfinite(tensions[1]).all()
    assert np.abs(tensions[1] / tensions[0] - 1.0).max() < AGREES


def posed(seed: int) -> tuple[System, System]:
    """The tree and the pinned scene at the same random pose and speeds, each rope stretched by about its share."""
    random = np.random.default_rng(seed)
    tree = scene()
    joints = []
    for j in tree.joints:
        if j.kind == "free":
            turn = Rotation.from_rotvec(random.uniform(-1.0, 1.0, 3)).as_quat()
            q0: tuple = (*(BLOCK + random.uniform(-3.0, 3.0, 3)), *turn)
            joints.append(replace(j, q0=nested(np.array(q0)), v0=nested(random.uniform(-1.0, 1.0, 6))))
        else:
            joints.append(replace(j, q0=(random.uniform(-1.0, 1.0),), v0=(random.uniform(-1.0, 1.0),)))
    springs = tuple(x for x in tree.springs if not is_loader(x.joint.removesuffix("-joint"), "low"))
    tree = replace(tree, joints=tuple(joints), springs=springs)
    program = Program(tree)
    ends = evaluate(program, 0.0, program.initial_state(), program.parameters.initial).ends
    at = poses(tree)
    ropes = []
    for r in tree.ropes:
        (line,) = r.lines
        a, b = (at[p.body][0] + at[p.body][1] @ np.array(p.p) for p in (line.a, line.b))
        ropes.append(replace(r, L0=float(np.linalg.norm(b - a)) / (1.0 + random.uniform(2e5, 8e5) / r.EA)))
    tree = replace(tree, ropes=tuple(ropes))
    given = {j.name: j for j in tree.joints}
    loops = []
    for j in pinned(tree).joints:
        if j.kind == "free" and j.child != "block":
            p, R = at[j.child]
            _, r, V = np.split(ends[program.graph.number(j.child)][9:], (3, 6))
            q0, v = (*p, *Rotation.from_matrix(R).as_quat()), V[3:] + np.cross(V[:3], r)
            loops.append(replace(j, q0=nested(np.array(q0)), v0=nested(np.concatenate([R.T @ v, R.T @ V[:3]]))))
        elif is_loader(j.child, "low") and j.kind == "revolute":
            q, v = given[j.name].q0[0], given[j.name].v0[0]
            loops.append(replace(j, q0=(-q,), v0=(-v,)))
        else:
            loops.append(j)
    return tree, replace(tree, joints=tuple(loops))


def block_acceleration(s: Simulation) -> np.ndarray:
    """(6,) of the block, after every acceleration has been found finite."""
    dv = s.X[s.method.layout.at["f"]][s.program.nq : s.program.nq + s.program.nv]
    assert np.isfinite(dv).all()
    return np.array(dv[s.program.graph.joint("block-joint").v])


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.large
def test_redundant_joints_do_not_change_the_accelerations_and_tensions_of_a_system_at_random_poses(seed: int) -> None:
    tensions, accelerations = [], []
    for system in posed(seed):
        s = started(system, tolerance=1e-12, sample_ns=SECOND // 50)
        assert not [n.sentence for n in s.notes if n.sentence.startswith("the start")], "given values fit each other"
        accelerations.append(block_acceleration(s))
        s.run(SECOND // 10)
        tensions.append(column(s, "rope/tension")[1][:5])
    assert len(s.program.constraints) == 36
    assert np.abs(accelerations[1] - accelerations[0]).max() < AGREES * np.abs(accelerations[0]).max()
    assert np.isfinite(tensions[1]).all()
    assert np.abs(tensions[1] - tensions[0]).max() < AGREES * tensions[0].max()


@pytest.mark.large
def test_doubling_constraint_rows_does_not_change_the_motion() -> None:
    """On floats: machine code of 72 rows takes long to compile."""
    _, once = posed(3)
    again = [replace(j, name=f"{j.name}-again") for j in once.joints if j.kind == "spherical"]
    twice = started(replace(once, joints=(*once.joints, *again)), native=False)
    assert len(twice.program.constraints) == 72
    want = block_acceleration(started(once))
    assert np.abs(block_acceleration(twice) - want).max() < AGREES * np.abs(want).max()
