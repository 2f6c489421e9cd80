"""A joint that closes a loop tells the coordinates that it would have in the tree; beside SciPy's rotations."""

from random import Random

import numpy as np
import pytest
from heavylift.kernel.constraints import CLOSURES, closed_coordinates
from heavylift.kernel.description import JOINTS, WORLD, Body, Joint, System
from scipy.spatial.transform import Rotation
from small_scenes import started

KINDS = sorted(k for k in CLOSURES if JOINTS[k].n_q and k != "free")
CLOSE = 1e-9


def frame(random):
    return Rotation.random(random_state=random.randrange(2**31))


def moved(joint, q, axes):
    """Rotation and displacement of the child's side in the parent's, in the joint's own frame."""
    if joint.kind == "spherical":
        return Rotation.from_quat(q), np.zeros(3)
    slid, turned = np.zeros(3), Rotation.identity()
    for m in JOINTS[joint.kind].motions:
        x = q[m.coordinate] * (joint.pitch if m.factor is None else m.factor)
        if m.turns:
            turned = turned * Rotation.from_rotvec(x * axes[m.axis])
        else:
            slid = slid + x * axes[m.axis]
    return turned, slid


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("seed", range(20))
def test_coordinates_are_those_of_a_joint_of_the_tree(kind, seed):
    random = Random(f"{kind} {seed}")
    of = JOINTS[kind]
    E, R_PJ, R_CJ, R_A = (frame(random) for _ in range(4))
    axes = E.as_matrix().T
    q = [random.uniform(-1.5, 1.5) for _ in of.coordinates]
    if kind == "spherical":
        q = Rotation.random(random_state=seed).as_quat(canonical=True).tolist()
    p_PJ, p_CJ, o_A = (np.array([random.uniform(-2, 2) for _ in range(3)]) for _ in range(3))
    joint = Joint(
        "x", kind, "a", "b", tuple(p_PJ), tuple(map(tuple, R_PJ.as_matrix())), tuple(axes[0]), tuple(axes[1]),
        p_CJ=tuple(p_CJ), R_CJ=tuple(map(tuple, R_CJ.as_matrix())), pitch=0.3 if kind == "screw" else 0.0,
        q0=tuple(x + random.uniform(-0.3, 0.3) for x in q),
    )  # fmt: skip
    turned, slid = moved(joint, q, axes)
    R_B = R_A * R_PJ * turned * R_CJ.inv()
    o_B = o_A + R_A.apply(p_PJ + R_PJ.apply(slid)) - R_B.apply(p_CJ)
    A, B = (np.concatenate([R.as_matrix().ravel(), o, np.zeros(9)]) for R, o in ((R_A, o_A), (R_B, o_B)))
    assert closed_coordinates(joint, A, B) == pytest.approx(q, abs=CLOSE)


def shafts(kind, name, asked):
    """Two shafts at 40 degrees in bearings, joined by a joint that closes the loop."""
    c, s = np.cos(np.radians(40.0)), np.sin(np.radians(40.0))
    bodies = tuple(Body(b, 1.0, (0.0, 0.0, 0.0), ((0.01, 0, 0), (0, 0.01, 0), (0, 0, 0.01))) for b in ("in", "out"))
    X, Y, Z = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)
    joints = (
        Joint("b1", "revolute", WORLD, "in", axis=X),
        Joint("b2", "revolute", WORLD, "out", axis=X, R_PJ=((c, 0, s), (0, 1, 0), (-s, 0, c)), R_CJ=tuple(
            map(tuple, np.eye(3)))),
        Joint(name, kind, "in", "out", axis=Z if kind == "universal" else X, second=Y, q0=asked),
    )  # fmt: skip
    return System(bodies, joints)


@pytest.mark.parametrize("name", ["a", "z"])
@pytest.mark.parametrize(("kind", "asked", "told"), [
    ("universal", (0.1, 0.2), ("angle1 from 5.72958 degrees to 0 deg", "angle2 from 11.4592 degrees to 40 degrees")),
    ("constant-velocity", (0.1, 0.0), ("angle1 from 5.72958 degrees to 20 degrees",)),
    ("spherical", (0.0, 0.0, 0.0, 1.0), ("attitude from 0 degrees to 40 degrees",)),
])  # fmt: skip
def test_a_start_value_that_is_not_kept_is_told(kind, asked, told, name):
    (note,) = [n.sentence for n in started(shafts(kind, name, asked), native=False).notes if "start pose" in n.sentence]
    assert note.startswith(f"the start pose was changed so that the loops of joint '{name}' close: joint '{name}' ")
    assert all(f"joint '{name}' {x}" in note for x in told), note
    assert note.count(" from ") == len(told)
